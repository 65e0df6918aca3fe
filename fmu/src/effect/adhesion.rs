//! Adhesion on retraction: the surface that was touched clings to the punch.
//!
//! Dugdale's law, per reference area and along the axis: what is in contact stays there up to a pull of the
//! strength s; where it opens the punch still pulls with s, until the gap exceeds the critical opening d and the
//! bond breaks for good - until the place is touched again. The work of adhesion is `s d` (J/m^2), the largest pull
//! `s` times the area. Friction acts on the pressure and the strength together (Derjaguin). Approach is free of it.

use super::descriptor::{Effect, Place, linear, one_sided, switch};
use crate::variables::units::{METRE, PASCAL};
use crate::variables::{Variable, field, real};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// The law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// s (Pa).
    pub strength: f64,
    /// d (m); of no effect while the strength is 0.
    pub opening: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { strength: 0.0, opening: 1e-4 }
    }
}

impl Parameters {
    pub(crate) fn is_active(&self) -> bool {
        self.strength != 0.0
    }
}

/// Areas of a ring between two radii (m) that its inner, middle and outer node stand for, with quadratic shape
/// functions: `int N 2 pi r dr` (m^2).
pub(crate) fn nodal_areas(inner: f64, outer: f64) -> [f64; 3] {
    let third = PI * (outer - inner) / 3.0;
    [third * inner, third * 2.0 * (inner + outer), third * outer]
}

pub(super) const VARIABLES: &[Variable] = &[
    real(
        "effect.adhesion.strength",
        "Traction that holds the touched surface on the retracting punch; 0: none",
        &PASCAL,
        (0.0, 1e6),
        field!(Real, padded.effect.adhesion.strength),
    ),
    real(
        "effect.adhesion.opening",
        "Gap at which that traction breaks; of no effect without effect.adhesion.strength",
        &METRE,
        (1e-8, 1.0),
        field!(Real, padded.effect.adhesion.opening),
    ),
];

/// The declaration.
pub const EFFECT: Effect = Effect {
    name: "adhesion",
    title: "adhesion on retraction",
    place: Place::Contact,
    variants: &[one_sided(
        "cohesive",
        &[linear("effect.adhesion.strength", 0.0, 100.0), switch("effect.adhesion.opening", 1e-4, 1e-4)],
    )],
    physics: "The touched surface clings to the punch up to a strength, and its bonds break where it has opened \
              by a critical gap. The force becomes negative on retraction and then returns to zero.",
    revealed_by: "A short negative peak after each retraction; separation later than the force's zero.",
    mimicked_by: "A contact-point offset or drift at the end of unloading alone.",
    mimics: &["offset", "load_cell_drift"],
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_of_a_ring_sum_to_it() {
        let areas = nodal_areas(0.7, 1.9);
        approx::assert_relative_eq!(areas.iter().sum::<f64>(), PI * (1.9 * 1.9 - 0.49), max_relative = 1e-14);
        // First moment of a linear field: int r 2 pi r dr.
        let moment = 0.7 * areas[0] + 1.3 * areas[1] + 1.9 * areas[2];
        approx::assert_relative_eq!(moment, 2.0 / 3.0 * PI * (1.9_f64.powi(3) - 0.343), max_relative = 1e-14);
    }
}
