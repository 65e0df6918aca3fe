//! Specimen amplitude: one batch of specimens is stiffer than another.
//!
//! All moduli and viscosities of the skeleton times `a`, the permeability through `a`: stresses and pore
//! pressures are then those of the plain specimen times `a` at the same displacements, and so is the force.

use super::descriptor::{Effect, Place, linear, two_sided};
use super::parameter::{Parameter, real};
use crate::unit::ONE;
use serde::{Deserialize, Serialize};

/// Size of the response.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Parameters {
    /// Logarithm of the factor on the force [-].
    pub log_factor: f64,
}

pub(super) const PARAMETERS: &[Parameter] = &[real!(
    "effect.amplitude.log_factor",
    "Logarithm of the factor on the specimen's force: all moduli and viscosities times it, K0 through it",
    &ONE,
    (-5.0, 5.0),
    amplitude.log_factor,
)];

/// The declaration.
pub const EFFECT: Effect = Effect {
    name: "amplitude",
    title: "specimen amplitude between batches",
    place: Place::Specimen,
    variants: &[two_sided("stiffer", &[linear("effect.amplitude.log_factor", 0.0, 0.2)])],
    physics: "The specimens of one protocol come from another batch: the same material with all stresses \
              times one factor. It is set per FMU instance, i.e. per protocol.",
    revealed_by: "The ratio of protocols after the hold, where any fading memory gives 1, and equal ratios at \
                  all times.",
    mimicked_by: "Within one protocol all moduli together; between protocols nothing rate-dependent.",
    mimics: &["specimen_size", "discretisation"],
};
