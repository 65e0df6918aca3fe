//! Unilateral contact of the punch with the surface: which nodes touch, and where they stick.
//!
//! An active set over the nodes that the punch can reach. A node in contact has the axial displacement of
//! the punch's face; it opens when it would be pulled, and closes when it would pass through the face. The
//! consistent nodal forces of a quadratic element under uniform pressure are zero at some nodes, so tension
//! is judged by the reaction against bilinear hat functions: a corner's own and half of its neighbours'. A
//! mid-side node is in contact when both its corners are.

use crate::element::geometry::Geometry;
use crate::mesh::Mesh;
use serde::{Deserialize, Serialize};

/// A node of the surface that the punch can reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceNode {
    /// Distance from the axis in the undeformed sample (m).
    pub radius: f64,
    /// Unknown `u_r`.
    pub radial: usize,
    /// Unknown `u_z`.
    pub axial: usize,
    /// Unknown pressure, at corners.
    pub pressure: Option<usize>,
}

/// The part of the surface that the punch can reach.
#[derive(Debug, Clone)]
pub struct Surface {
    /// From the axis outwards: corner, mid-side node, corner, ..., corner.
    nodes: Vec<SurfaceNode>,
    /// Their places in the order of the mesh's numbers.
    in_mesh_order: Vec<usize>,
    /// The inner corner of the side on which each quadrature point of the face lies.
    sides: Vec<usize>,
}

/// Which nodes are in contact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// The corners, from the axis outwards.
    closed: Vec<bool>,
    /// Radial displacement at which each node stuck when it was last touched (m).
    pub(super) held: Vec<f64>,
}

/// Where the surface lies with respect to the punch.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Touch {
    /// Whether any node is in contact.
    pub in_contact: bool,
    /// Indentation at which the first open node would be touched (m).
    pub clearance: f64,
    /// Mean axial displacement of the face's nodes (m).
    pub level: f64,
}

/// A change of the set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Change {
    Open(usize),
    Close(usize),
}

/// Slacks below which nothing is pulled and nothing passes through the face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slack {
    /// Force (N).
    pub force: f64,
    /// Length (m).
    pub length: f64,
}

impl Contact {
    /// Whether a node of the surface is in contact.
    pub fn is_closed(&self, node: usize) -> bool {
        self.closed[node / 2] && self.closed[node.div_ceil(2)]
    }

    /// Whether any node is.
    pub fn any(&self) -> bool {
        self.closed.contains(&true)
    }

    /// The corners in contact, from the axis outwards.
    pub fn corners(&self) -> &[bool] {
        &self.closed
    }
}

impl Surface {
    /// The nodes under the punch.
    pub fn new(mesh: &Mesh, geometry: &Geometry) -> Self {
        let node = |n: u32| SurfaceNode {
            radius: mesh.nodes[n as usize][0],
            radial: mesh.displacement(n),
            axial: mesh.displacement(n) + 1,
            pressure: mesh.pressure(n),
        };
        let numbered: Vec<SurfaceNode> = mesh.punch().map(node).collect();
        let mut nodes = numbered.clone();
        nodes.sort_by(|a, b| a.radius.total_cmp(&b.radius));
        let place = |n: &SurfaceNode| nodes.iter().position(|m| m.axial == n.axial);
        let in_mesh_order = numbered.iter().filter_map(place).collect();
        let inner = |radius: f64| nodes.iter().step_by(2).filter(|n| n.radius <= radius).count();
        let sides = geometry.face.iter().map(|p| inner(p.geometry.radius).saturating_sub(1)).collect();
        Self { nodes, in_mesh_order, sides }
    }

    /// The nodes, from the axis outwards.
    pub fn nodes(&self) -> &[SurfaceNode] {
        &self.nodes
    }

    /// The nodes with their places from the axis outwards, in the order of the mesh's numbers.
    pub fn in_mesh_order(&self) -> impl Iterator<Item = (usize, &SurfaceNode)> {
        self.in_mesh_order.iter().map(|&index| (index, &self.nodes[index]))
    }

    /// The contact of the undeformed sample with a punch that just touches it.
    pub fn touched(&self) -> Contact {
        Contact { closed: vec![true; self.nodes.len().div_ceil(2)], held: vec![0.0; self.nodes.len()] }
    }

    /// Whether a contact has this surface's number of nodes.
    pub fn fits(&self, contact: &Contact) -> bool {
        contact.held.len() == self.nodes.len() && contact.closed.len() == self.nodes.len().div_ceil(2)
    }

    /// Height of the punch's face above its tip where a node is in contact (m).
    pub fn height(&self, _node: usize, _contact: &Contact) -> f64 {
        0.0
    }

    /// Whether each quadrature point of the face lies on a side in contact.
    pub fn closed_points(&self, contact: &Contact) -> Vec<bool> {
        self.sides.iter().map(|&corner| contact.is_closed(2 * corner + 1)).collect()
    }

    /// Where the surface lies with the unknowns `x`.
    pub fn touch(&self, contact: &Contact, x: &[f64]) -> Touch {
        let open = self.nodes.iter().step_by(2).zip(&contact.closed).filter(|(_, closed)| !**closed);
        let clearance = open.map(|(node, _)| -x[node.axial]).fold(f64::INFINITY, f64::min);
        let level = self.nodes.iter().map(|n| x[n.axial]).sum::<f64>() / self.nodes.len() as f64;
        Touch { in_contact: contact.any(), clearance, level }
    }

    /// Reaction of a corner against its hat function, positive when pressed (N); `forces` are the nodal ones.
    fn pressed(&self, corner: usize, contact: &Contact, forces: &[f64]) -> f64 {
        let middle = 2 * corner;
        let neighbours = [middle.checked_sub(1), Some(middle + 1).filter(|&k| k < self.nodes.len())];
        let half: f64 = neighbours
            .into_iter()
            .flatten()
            .filter(|&k| contact.is_closed(k))
            .map(|k| 0.5 * forces[self.nodes[k].axial])
            .sum();
        -(forces[self.nodes[middle].axial] + half)
    }

    /// Changes the set where corners are pulled or pass through the face; `false` when there are none.
    /// A corner that opened within the stage is in `opened` and stays open.
    pub fn change(
        &self,
        contact: &mut Contact,
        x: &[f64],
        forces: &[f64],
        indentation: f64,
        slack: Slack,
        opened: &mut [bool],
    ) -> bool {
        let change = |corner: usize| {
            if contact.closed[corner] {
                let pulled = self.pressed(corner, contact, forces) < -slack.force;
                return pulled.then_some(Change::Open(corner));
            }
            let above_face = x[self.nodes[2 * corner].axial] + indentation;
            (!opened[corner] && above_face > slack.length).then_some(Change::Close(corner))
        };
        let changes: Vec<Change> = (0..contact.closed.len()).filter_map(change).collect();
        let before = contact.clone();
        for &change in &changes {
            match change {
                Change::Open(corner) => {
                    contact.closed[corner] = false;
                    opened[corner] = true;
                }
                Change::Close(corner) => contact.closed[corner] = true,
            }
        }
        // A node that is touched sticks where it is.
        for (k, node) in self.nodes.iter().enumerate() {
            if contact.is_closed(k) && !before.is_closed(k) {
                contact.held[k] = x[node.radial];
            }
        }
        !changes.is_empty()
    }
}
