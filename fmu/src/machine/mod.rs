//! A compliant machine: the punch's place depends on its force, which couples all unknowns by one scalar.
//!
//! The punch's face is at `-(displacement - C F(x))`. The matrix holds the rigid machine; the scalar equation is
//! added by the solution for a unit motion of the punch (bordering), so that Newton's method stays what it is.

use crate::contact::conditions::{Condition, Conditions};

/// Energy stored in a machine of this compliance (m/N) under a force (N) (J).
pub fn machine_energy(compliance: f64, force: f64) -> f64 {
    0.5 * compliance * force * force
}

/// How the sample follows when the punch moves up by one length scale.
pub struct UnitMotion {
    /// Change of the dimensionless unknowns.
    change: Vec<f64>,
    /// The length scale (m).
    length: f64,
    /// Fall of the force (N), positive for a stable sample.
    stiffness: f64,
}

impl UnitMotion {
    /// `solve` applies the inverse of the dimensionless tangent; `reaction_row` is minus the force's
    /// derivative (N per unit of the unknowns), whose units are `scale`.
    ///
    /// # Errors
    /// That of `solve`.
    pub fn new<E>(
        conditions: &Conditions,
        scale: &[f64],
        reaction_row: &[f64],
        solve: impl FnOnce(&mut [f64]) -> Result<(), E>,
    ) -> Result<Self, E> {
        let is_punch = |condition: &Condition| *condition == Condition::Punch;
        let mut change: Vec<_> =
            conditions.unknowns.iter().map(|c| f64::from(u8::from(is_punch(c)))).collect();
        let length = conditions.unknowns.iter().position(is_punch).map_or(1.0, |first| scale[first]);
        solve(&mut change)?;
        let stiffness = product(reaction_row, scale, &change);
        Ok(Self { change, length, stiffness })
    }

    /// Completes a Newton correction (to be subtracted), which took the force as given.
    pub fn couple(&self, compliance: f64, scale: &[f64], reaction_row: &[f64], correction: &mut [f64]) {
        let rise = product(reaction_row, scale, correction);
        let share = -compliance * rise / (self.length + compliance * self.stiffness);
        correction.iter_mut().zip(&self.change).for_each(|(c, unit)| *c += share * unit);
    }

    /// Completes the change of the unknowns (in their units) and of the force (N) by some parameter, which
    /// took the punch's place as given; returns the change of the force.
    pub fn follow(&self, compliance: f64, scale: &[f64], force: f64, change: &mut [f64]) -> f64 {
        let share = compliance * force / (self.length + compliance * self.stiffness);
        for ((value, unit), scale) in change.iter_mut().zip(&self.change).zip(scale) {
            *value += share * unit * scale;
        }
        force - share * self.stiffness
    }
}

fn product(row: &[f64], scale: &[f64], change: &[f64]) -> f64 {
    row.iter().zip(scale).zip(change).map(|((r, s), c)| r * s * c).sum()
}
