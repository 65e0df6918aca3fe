//! The fields of a state: what the stepper knows, handed over at one time.

use super::state::State;
use super::stepper::Stepper;
use crate::fields::{Fields, FieldsError, Matter, extract};
use crate::law::PointMaterial;

impl Stepper {
    /// Fields of a state; `touching` tells whether the punch has touched the sample yet.
    ///
    /// # Errors
    /// When an element cannot be evaluated.
    pub fn fields(&self, state: &State, touching: bool) -> Result<Fields, FieldsError> {
        let drifted = self.drifting.as_ref().map(|(m, e)| PointMaterial::extended(m, e, state.time));
        let mesh = &self.sample.mesh;
        let places = mesh.punch().zip(self.surface.in_mesh_order());
        let is_touched = |place: usize| touching && state.contact.is_closed(place);
        let touched: Vec<u32> =
            places.filter(|(_, (place, _))| is_touched(*place)).map(|(node, _)| node).collect();
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
