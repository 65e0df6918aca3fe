//! The fields of a state: what the stepper knows, handed over at one time.

use super::{FieldSource, Fields, FieldsError, extract};
use crate::specimen::{State, Stepper};

impl Stepper {
    /// Fields of a state; `touching` tells whether the punch has touched the sample yet.
    ///
    /// # Errors
    /// When an element cannot be evaluated.
    pub fn fields(&self, state: &State, touching: bool) -> Result<Fields, FieldsError> {
        let (sample, material) = (self.sample(), self.material_at(state.time));
        let mesh = &sample.mesh;
        let places = mesh.punch().chain(mesh.folding_side()).zip(self.surface().in_mesh_order());
        let is_touched = |place: usize| touching && state.contact.is_closed(place);
        let touched: Vec<u32> =
            places.filter(|(_, (place, _))| is_touched(*place)).map(|(node, _)| node).collect();
        extract(&FieldSource {
            mesh,
            geometry: &sample.geometry,
            map: &sample.map,
            material: &material,
            x: &state.x,
            history: &state.history,
            touched: &touched,
        })
    }
}
