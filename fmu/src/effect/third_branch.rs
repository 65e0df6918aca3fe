//! Slow third branch: relaxation beyond the hold.

use super::descriptor::{Effect, Place, linear, one_sided, switch};

/// The declaration.
pub const EFFECT: Effect = Effect::new("third_branch", "slow third branch", Place::Specimen)
    .physics(
        "A further spring and dashpot in series relax in some hundred seconds, beyond the hold of 90 s. \
         Full relaxation was seen to take 400 to 600 s.",
    )
    .revealed_by(
        "The slope at the end of the hold, residuals in its late decades, and later cycles that start \
         before the branch has recovered.",
    )
    .mimicked_by(
        "The slower of the two fitted branches, modulus or load-cell drift over one hold, a stretched \
         spectrum of Eyring flow.",
        &["eyring", "modulus_drift", "load_cell_drift"],
    )
    // 60 Pa of shear modulus (mu alpha / 2 with the start value alpha = -3) relaxing in 200 s.
    .variants(&[one_sided(
        "slow",
        &[linear("material.branch[3].mu", 0.0, -40.0), switch("material.branch[3].eta", 1e3, 1.2e4)],
    )]);
