//! Adhesion on retraction: the law is [`crate::contact::adhesion`].

use super::descriptor::{Effect, Place, linear, one_sided, switch};
use super::parameter::parameters;
use crate::unit::{METRE, PASCAL};

parameters! {
    /// Strength and reach of the bond.
    adhesion:
    /// Traction that holds the touched surface on the retracting punch; 0: none
    strength: real(PASCAL, (0.0, 1e6)) = 0.0;
    /// Gap at which that traction breaks; of no effect without effect.adhesion.strength
    opening: real(METRE, (1e-8, 1.0)) = 1e-4;
}

/// The declaration.
pub const EFFECT: Effect = Effect::new("adhesion", "adhesion on retraction", Place::Contact)
    .physics(
        "The touched surface clings to the punch up to a strength, and its bonds break where it has \
         opened by a critical gap. The force becomes negative on retraction and then returns to zero.",
    )
    .revealed_by("A short negative peak after each retraction; separation later than the force's zero.")
    .mimicked_by(
        "A contact-point offset or drift at the end of unloading alone.",
        &["offset", "load_cell_drift"],
    )
    .variants(&[one_sided(
        "cohesive",
        &[linear("effect.adhesion.strength", 0.0, 100.0), switch("effect.adhesion.opening", 1e-4, 1e-4)],
    )]);
