//! Softening with past strain: the law is [`crate::law::softening`].

use super::descriptor::{Effect, Place, linear, one_sided, switch};
use super::parameter::{Parameter, real};
use crate::unit::{ONE, SECOND};
use serde::{Deserialize, Serialize};

/// Loss, and the strain and time in which it happens.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// D, the share that is lost at large strain [-].
    pub loss: f64,
    /// e_0 [-].
    pub strain: f64,
    /// tau (s); 0: at once.
    pub delay: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { loss: 0.0, strain: 0.2, delay: 0.0 }
    }
}

pub(super) const PARAMETERS: &[Parameter] = &[
    real!(
        "effect.softening.loss",
        "Share D of all springs and dashpots that is lost at large past strain",
        &ONE,
        (0.0, 0.95),
        softening.loss,
    ),
    real!(
        "effect.softening.strain",
        "Past equivalent logarithmic strain at which 63 % of the loss has happened",
        &ONE,
        (1e-3, 10.0),
        softening.strain,
    ),
    real!(
        "effect.softening.delay",
        "Time in which the past strain follows a larger present one; 0: at once",
        &SECOND,
        (0.0, 1e4),
        softening.delay,
    ),
];

/// The declaration.
pub const EFFECT: Effect = Effect {
    name: "softening",
    title: "softening with past strain",
    place: Place::Specimen,
    variants: &[
        one_sided(
            "immediate",
            &[linear("effect.softening.loss", 0.0, 0.3), switch("effect.softening.strain", 0.2, 0.2)],
        ),
        one_sided(
            "delayed",
            &[
                linear("effect.softening.loss", 0.0, 0.3),
                switch("effect.softening.strain", 0.2, 0.2),
                switch("effect.softening.delay", 0.0, 20.0),
            ],
        ),
    ],
    physics: "Bonds that break on first loading, at once or while it is held, do not heal: stresses fall with the \
              largest strain a point has seen. Unloading and later cycles to the same depth follow the softened response.",
    revealed_by: "A first cycle above the later ones, unloading below loading without any rate.",
    mimicked_by: "Within the first loading all moduli with smaller exponents; over cycles a branch that has not \
                  recovered, or swelling.",
    mimics: &["modulus_drift", "third_branch"],
};
