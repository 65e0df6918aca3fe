//! Slow third branch: relaxation beyond the hold.

use super::descriptor::{Effect, Place, linear, one_sided, proportional};

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
    // 60 Pa of shear modulus (mu alpha / 2 with the start value alpha = -3) relaxing in 200 s, whatever its modulus: with one viscosity
    // for all moduli a weak branch would relax in hours, and look like none.
    .variants(&[one_sided(
        "slow",
        &[linear("material.branch[3].mu", 0.0, -40.0), proportional("material.branch[3].eta", 1e3, 1.2e4)],
    )]);

#[cfg(test)]
mod tests {
    use super::*;

    /// Goal: the relaxation time is the same at every magnitude. Reference: eta / (mu alpha / 2) with alpha = -3.
    #[test]
    fn a_weak_branch_relaxes_as_slowly_as_a_strong_one() {
        let [mu, eta] = EFFECT.variants[0].settings else { panic!("two parameters") };
        for magnitude in [0.01, 1.0, 20.0] {
            let time_s = eta.at(magnitude) / (-1.5 * mu.at(magnitude));
            approx::assert_relative_eq!(time_s, 200.0, max_relative = 1e-12);
        }
        assert_eq!((mu.at(0.0), eta.at(0.0)), (mu.null, eta.null));
    }
}
