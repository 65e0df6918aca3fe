//! Softening with past strain: the law is [`crate::law::softening`].

use super::descriptor::{Effect, Place, linear, one_sided, switch};
use super::parameter::parameters;
use crate::unit::{ONE, SECOND};

parameters! {
    /// Loss, and the strain and time in which it happens.
    softening:
    /// Share D of all springs and dashpots that is lost at large past strain
    loss: real(ONE, (0.0, 0.95)) = 0.0;
    /// Past equivalent logarithmic strain at which 63 % of the loss has happened
    strain: real(ONE, (1e-3, 10.0)) = 0.2;
    /// Time in which the past strain follows a larger present one; 0: at once
    delay: real(SECOND, (0.0, 1e4)) = 0.0;
}

/// The declaration.
pub const EFFECT: Effect = Effect::new("softening", "softening with past strain", Place::Specimen)
    .physics(
        "Bonds that break on first loading, at once or while it is held, do not heal: stresses fall \
         with the largest strain a point has seen. Unloading and later cycles to the same depth follow \
         the softened response.",
    )
    .revealed_by("A first cycle above the later ones, unloading below loading without any rate.")
    .mimicked_by(
        "Within the first loading all moduli with smaller exponents; over cycles a branch that has not \
         recovered, or swelling.",
        &["modulus_drift", "third_branch"],
    )
    .variants(&[
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
    ]);
