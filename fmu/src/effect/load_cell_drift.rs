//! Load-cell drift: the zero of the electronics moves with time.

use super::descriptor::{Effect, Place, linear, two_sided};
use super::parameter::parameters;
use crate::unit::NEWTON_PER_SECOND;

parameters! {
    /// Rate of the drift.
    load_cell_drift:
    /// Rate at which the load cell's zero drifts, from the test's start, with and without contact
    rate: real(NEWTON_PER_SECOND, (-1.0, 1.0)) = 0.0;
}

/// The declaration.
pub const EFFECT: Effect = Effect::new("load_cell_drift", "load-cell drift", Place::Sensor)
    .physics(
        "Temperature and creep of the cell move its zero; the reading grows linearly with time. It does \
         so in air as well as in contact.",
    )
    .revealed_by("The force off contact, in approach and rests.")
    .mimicked_by(
        "Over one hold a slow branch or modulus drift, which both leave the air at zero.",
        &["third_branch", "modulus_drift"],
    )
    .variants(&[two_sided("upwards", &[linear("effect.load_cell_drift.rate", 0.0, 2e-6)])]);
