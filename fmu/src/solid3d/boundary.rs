//! Which unknowns of the quarter are prescribed.

use super::mesh::Mesh;
use crate::contact::conditions::Condition;
use crate::contact::parameters::BoundaryParameters;

/// Conditions of all unknowns while the punch is in contact.
#[derive(Debug, Clone)]
pub struct Conditions {
    /// One per unknown.
    pub unknowns: Vec<Condition>,
    /// Axial unknowns under the punch, whose residuals sum to a quarter of the reaction.
    pub punch: Vec<usize>,
}

impl Conditions {
    /// The conditions of a parameter set on a mesh.
    ///
    /// Hanging nodes follow: their masters lie on the same plane, and under the punch if they do.
    pub fn new(mesh: &Mesh, boundary: &BoundaryParameters) -> Self {
        let mut unknowns = vec![Condition::Free; mesh.unknowns()];
        let mut punch = Vec::new();
        for node in 0..mesh.nodes.len() as u32 {
            if let Some(p) = mesh.pressure(node) {
                let drained = boundary.drained_bottom && mesh.is_bottom(node)
                    || boundary.drained_side && mesh.is_side(node)
                    || boundary.drained_top && mesh.is_free_top(node)
                    || boundary.drained_punch && mesh.is_punch(node);
                if drained {
                    unknowns[p] = Condition::Fixed;
                }
            }
            let Some(first) = mesh.displacement(node) else { continue };
            let side = mesh.is_side(node);
            for direction in 0..2 {
                if mesh.on_plane(node, direction) {
                    // On the side the unknowns are radial and tangential: the latter is normal to the plane.
                    unknowns[first + if side { 1 } else { direction }] = Condition::Fixed;
                }
            }
            if boundary.confined_side && side {
                unknowns[first] = Condition::Fixed;
            }
            if boundary.bonded_bottom && mesh.is_bottom(node) || boundary.bonded_punch && mesh.is_punch(node)
            {
                unknowns[first..first + 2].fill(Condition::Fixed);
            }
            if mesh.is_bottom(node) {
                unknowns[first + 2] = Condition::Fixed;
            }
            if mesh.is_punch(node) {
                unknowns[first + 2] = Condition::Punch;
                punch.push(first + 2);
            }
        }
        Self { unknowns, punch }
    }
}
