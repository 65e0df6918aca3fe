//! Which unknowns are prescribed.

use crate::mesh::Mesh;
use crate::parameters::BoundaryParameters;

/// Condition on one unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condition {
    /// Solved for.
    Free,
    /// Zero.
    Fixed,
    /// Axial displacement of the punch's face: minus the indentation.
    Punch,
}

/// Conditions of all unknowns while the punch is in contact.
#[derive(Debug, Clone)]
pub struct Conditions {
    /// One per unknown.
    pub unknowns: Vec<Condition>,
    /// Axial unknowns under the punch, whose residuals sum to the reaction.
    pub punch: Vec<usize>,
}

impl Conditions {
    /// The conditions of a parameter set on a mesh.
    pub fn new(mesh: &Mesh, boundary: &BoundaryParameters) -> Self {
        let mut unknowns = vec![Condition::Free; mesh.unknowns()];
        let mut fix = |unknown: usize| unknowns[unknown] = Condition::Fixed;
        let drain = |nodes: &mut dyn Iterator<Item = u32>, fix: &mut dyn FnMut(usize)| {
            nodes.filter_map(|n| mesh.pressure(n)).for_each(fix);
        };
        for node in mesh.axis() {
            fix(mesh.displacement(node));
        }
        for node in mesh.bottom() {
            fix(mesh.displacement(node) + 1);
            if boundary.bonded_bottom {
                fix(mesh.displacement(node));
            }
        }
        if boundary.confined_side {
            mesh.side().for_each(|node| fix(mesh.displacement(node)));
        }
        if boundary.drained_bottom {
            drain(&mut mesh.bottom(), &mut fix);
        }
        if boundary.drained_side {
            drain(&mut mesh.side(), &mut fix);
        }
        if boundary.drained_top {
            drain(&mut mesh.free_top(), &mut fix);
        }
        if boundary.drained_punch {
            drain(&mut mesh.punch(), &mut fix);
        }
        if boundary.bonded_punch {
            mesh.punch().for_each(|node| fix(mesh.displacement(node)));
        }
        let punch: Vec<usize> = mesh.punch().map(|node| mesh.displacement(node) + 1).collect();
        for &unknown in &punch {
            unknowns[unknown] = Condition::Punch;
        }
        Self { unknowns, punch }
    }
}
