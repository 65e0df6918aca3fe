//! Machine compliance: the frame yields, and the punch is not where the crosshead is.
//!
//! Displacement is measured at the crosshead; the punch is at `displacement - C F`. The scalar equation is
//! solved with the unknowns of every stage: see [`crate::machine`].

use super::descriptor::{Effect, Place, linear, one_sided};
use super::parameter::{Parameter, real};
use crate::unit::METRE_PER_NEWTON;
use serde::{Deserialize, Serialize};

/// Compliance of everything between displacement sensor and sample.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Parameters {
    /// C (m/N).
    pub per_newton: f64,
}

pub(super) const PARAMETERS: &[Parameter] = &[real!(
    "effect.compliance.per_newton",
    "Compliance C of the machine: the punch is at displacement - C force",
    &METRE_PER_NEWTON,
    (0.0, 1e3),
    compliance.per_newton,
)];

/// The declaration.
pub const EFFECT: Effect = Effect {
    name: "compliance",
    title: "machine compliance",
    place: Place::Machine,
    variants: &[one_sided("elastic frame", &[linear("effect.compliance.per_newton", 0.0, 2e-3)])],
    physics: "Load cell and frame are springs between the displacement sensor and the punch. The true depth \
              falls short by compliance times force and grows during the hold as the force relaxes.",
    revealed_by: "A peak that is cut more than the end of the hold; pressing on a rigid plate.",
    mimicked_by: "Lower moduli of the fast branches almost completely; lag at the peak.",
    mimics: &["load_cell_lag", "amplitude", "offset"],
};
