//! Modulus drift: the specimen dries or swells while it is tested.
//!
//! All springs and dashpots and lambda* times `exp(rate t)`, t since the test's start: relaxation times stay.
//! The change of the moduli under stress does work of its own, which no output reports.

use super::descriptor::{Effect, Place, linear, two_sided};
use super::parameter::parameters;
use crate::unit::PER_SECOND;

parameters! {
    /// Growth of the moduli.
    modulus_drift:
    /// Rate at which all moduli and viscosities grow, exp(rate time), time since the test's start
    rate: real(PER_SECOND, (-1.0, 1.0)) = 0.0;
}

/// The declaration.
pub const EFFECT: Effect = Effect::new("modulus_drift", "modulus drift (drying, swelling)", Place::Specimen)
    .physics(
        "Drying stiffens the skeleton, swelling softens it, whatever the punch does. All moduli and \
         viscosities grow exponentially with the time since the test's start.",
    )
    .revealed_by(
        "Peaks and ends of the hold that grow or fall together from cycle to cycle, also after long \
         rests.",
    )
    .mimicked_by(
        "Over one hold a slow branch; softening for a falling force, but that ends after the first \
         cycle.",
        &["third_branch", "softening", "load_cell_drift"],
    )
    .variants(&[two_sided("drying", &[linear("effect.modulus_drift.rate", 0.0, 1e-4)])]);
