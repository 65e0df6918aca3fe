//! Machine compliance: the frame yields, and the punch is not where the crosshead is.
//!
//! Displacement is measured at the crosshead; the punch is at `displacement - C F`. The scalar equation is
//! solved with the unknowns of every stage: see [`crate::machine`].

use super::descriptor::{Effect, Place, linear, one_sided};
use super::parameter::parameters;
use crate::unit::METRE_PER_NEWTON;

parameters! {
    /// Compliance of everything between displacement sensor and sample.
    compliance:
    /// Compliance C of the machine: the punch is at displacement - C force
    per_newton: real(METRE_PER_NEWTON, (0.0, 1e3)) = 0.0;
}

/// The declaration.
pub const EFFECT: Effect = Effect::new("compliance", "machine compliance", Place::Machine)
    .physics(
        "Load cell and frame are springs between the displacement sensor and the punch. The true depth \
         falls short by compliance times force and grows during the hold as the force relaxes.",
    )
    .revealed_by("A peak that is cut more than the end of the hold; pressing on a rigid plate.")
    .mimicked_by(
        "Lower moduli of the fast branches almost completely; lag at the peak.",
        &["load_cell_lag", "amplitude", "offset"],
    )
    .variants(&[one_sided("elastic frame", &[linear("effect.compliance.per_newton", 0.0, 2e-3)])]);
