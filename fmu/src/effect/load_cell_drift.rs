//! Load-cell drift: the zero of the electronics moves with time.

use super::descriptor::{Effect, Place, linear, two_sided};
use super::parameter::{Parameter, real};
use crate::unit::NEWTON_PER_SECOND;
use serde::{Deserialize, Serialize};

/// Rate of the drift.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Parameters {
    /// Rate (N/s).
    pub rate: f64,
}

pub(super) const PARAMETERS: &[Parameter] = &[real!(
    "effect.load_cell_drift.rate",
    "Rate at which the load cell's zero drifts, from the test's start, with and without contact",
    &NEWTON_PER_SECOND,
    (-1.0, 1.0),
    load_cell_drift.rate,
)];

/// The declaration.
pub const EFFECT: Effect = Effect {
    name: "load_cell_drift",
    title: "load-cell drift",
    place: Place::Sensor,
    variants: &[two_sided("upwards", &[linear("effect.load_cell_drift.rate", 0.0, 2e-6)])],
    physics: "Temperature and creep of the cell move its zero; the reading grows linearly with time. It does so \
              in air as well as in contact.",
    revealed_by: "The force off contact, in approach and rests.",
    mimicked_by: "Over one hold a slow branch or modulus drift, which both leave the air at zero.",
    mimics: &["third_branch", "modulus_drift"],
};
