//! The fields of a state: what the stepper knows, handed over at one time.

use super::step::{State, Stepper};
use crate::fields::{Fields, FieldsError, Matter, extract};
use crate::material::PointMaterial;

impl Stepper {
    /// Fields of a state; `touching` tells whether the punch has touched the sample yet.
    ///
    /// # Errors
    /// When an element cannot be evaluated.
    pub fn fields(&self, state: &State, touching: bool) -> Result<Fields, FieldsError> {
        let drifted = self.drifting.as_ref().map(|(m, e)| PointMaterial::with_effects(m, e, state.time));
        let mesh = &self.sample.mesh;
        let is_touched = |&node: &u32| {
            let axial = mesh.displacement(node) + 1;
            let place = self.surface.nodes().iter().position(|n| n.axial == axial);
            place.is_some_and(|place| state.contact.is_closed(place))
        };
        let touched: Vec<u32> = mesh.punch().filter(|node| touching && is_touched(node)).collect();
        extract(&Matter {
            mesh,
            geometry: &self.sample.geometry,
            map: &self.sample.map,
            material: drifted.as_ref().unwrap_or(&self.material),
            x: &state.x,
            history: &state.history,
            touched: &touched,
        })
    }
}
