//! Specimen amplitude: one batch of specimens is stiffer than another.
//!
//! All moduli and viscosities of the skeleton times `a`, the permeability through `a`: stresses and pore
//! pressures are then those of the plain specimen times `a` at the same displacements, and so is the force.

use super::descriptor::{Effect, Place, linear, two_sided};
use super::parameter::parameters;
use crate::unit::ONE;

parameters! {
    /// Size of the response.
    amplitude:
    /// Logarithm of the factor on the specimen's force: all moduli and viscosities times it, K0 through it
    log_factor: real(ONE, (-5.0, 5.0)) = 0.0;
}

/// The declaration.
pub const EFFECT: Effect = Effect::new("amplitude", "specimen amplitude between batches", Place::Specimen)
    .physics(
        "The specimens of one protocol come from another batch: the same material with all stresses \
         times one factor. It is set per FMU instance, i.e. per protocol.",
    )
    .revealed_by(
        "The ratio of protocols after the hold, where any fading memory gives 1, and equal ratios at \
         all times.",
    )
    .mimicked_by(
        "Within one protocol all moduli together; between protocols nothing rate-dependent.",
        &["specimen_size", "discretisation"],
    )
    .variants(&[two_sided("stiffer", &[linear("effect.amplitude.log_factor", 0.0, 0.2)])]);
