//! Unilateral contact of the punch with the surface: which nodes touch, and where they stick.
//!
//! An active set over the nodes that the punch can reach. A node in contact has the axial displacement of
//! the punch's face; it opens when it would be pulled, and closes when it would pass through the face. The
//! consistent nodal forces of a quadratic element under uniform pressure are zero at some nodes, so tension
//! is judged by the reaction against bilinear hat functions: a corner's own and half of its neighbours'. A
//! mid-side node is in contact when both its corners are; where the edge of the contact lies between them, it is in
//! contact on its own account, by its own gap and force.
//!
//! A bonded face holds every node radially where it was touched. As long as it is touched everywhere nothing
//! else matters; but at the edge of a partly opened face the shear of an unbreakable bond would grow without
//! limit while the pressure vanishes. The bond therefore fails from the edge inwards: beside a part that is open or
//! slides, or where a corner is pulled, the surface begins to slide where the shear exceeds the friction, until its
//! motion turns. It does so in patches of at least a tenth of the punch's radius: the rings of small elements at the
//! edge would be squeezed if they slid one by one. Where a corner is pulled that friction could hold, the patch yields
//! for one stage under the shear that it has: the shear spreads in proportion to the pressure, and none is let go.
//!
//! Partial slip: a face that friction alone holds has no such bond. Coulomb's law then acts corner by corner, under
//! pressure, too: a corner slides as soon as the shear exceeds the friction, and is held again where its motion turned.
//!
//! Under a platen the free side of a bonded sample folds over: from the rims on it lies down on the platen and on the
//! support. Its corners follow those of the face; one that touches a plate sticks (slides on a frictionless one) until
//! it is pulled.

use super::adhesion::Adhesion;
use super::decision::Trial;
use super::parameters::BoundaryParameters;
use super::profile::{Face, Profile};
use super::status::{Contact, Status};
use crate::element::geometry::{FacePoint, Geometry};
use crate::mesh::Mesh;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Least width of a patch over the punch's radius.
const PATCH: f64 = 0.1;
/// Largest turn of the face over a side (radian) with which the contact may end between its corners. Around a narrower
/// edge a quadratic side cannot follow the face: laid on it with one end free it turns its element inside out.
const FOLLOWED_TURN: f64 = 0.1;

/// The rigid body that a node of the surface can touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Plate {
    /// The punch, whose tip is this far above the node in the undeformed sample (m).
    Punch(f64),
    /// The support under the sample, this far below the node (m).
    Support(f64),
}

/// A node of the surface that the punch can reach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceNode {
    /// What it can touch.
    pub plate: Plate,
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
    /// From the axis outwards, then down a side that may fold over: corner, mid-side node, corner, ..., corner.
    pub(super) nodes: Vec<SurfaceNode>,
    /// How many corners lie on the undeformed face.
    pub(super) face_corners: usize,
    /// Their places in the order of the mesh's numbers.
    in_mesh_order: Vec<usize>,
    profile: Profile,
    pub(super) adhesion: Adhesion,
    /// Friction coefficient of a bonded face; a frictionless one has none.
    pub(super) friction: Option<f64>,
    /// Whether friction alone holds the face: it slides under pressure, too.
    pub(super) partial_slip: bool,
    /// Corners that slide together.
    pub(super) patches: Vec<Range<usize>>,
    /// Length of the surface that each corner stands for (m).
    pub(super) lengths: Vec<f64>,
    /// The inner corner of the side on which each quadrature point of the face lies.
    sides: Vec<usize>,
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

impl Surface {
    /// The nodes under the punch.
    pub fn new(
        mesh: &Mesh,
        geometry: &Geometry,
        boundary: &BoundaryParameters,
        profile: Profile,
        adhesion: Adhesion,
    ) -> Self {
        let height = mesh.height();
        let node = |n: u32| SurfaceNode {
            plate: match mesh.nodes[n as usize][1] {
                z if mesh.is_upper(z) => Plate::Punch(height - z),
                z => Plate::Support(z),
            },
            radius: mesh.nodes[n as usize][0],
            radial: mesh.displacement(n),
            axial: mesh.displacement(n) + 1,
            pressure: mesh.pressure(n),
        };
        let face: Vec<SurfaceNode> = mesh.punch().map(node).collect();
        let mut nodes = face.clone();
        nodes.sort_by(|a, b| a.radius.total_cmp(&b.radius));
        let face_corners = nodes.len().div_ceil(2);
        // A side in a smooth ring cannot fold.
        let side = if boundary.confined_side { Vec::new() } else { mesh.folding_side() };
        nodes.extend(side.iter().map(|&n| node(n)));
        let numbered = mesh.punch().chain(side).map(node);
        let place = |n: &SurfaceNode| nodes.iter().position(|m| m.axial == n.axial);
        let in_mesh_order = numbered.filter_map(|n| place(&n)).collect();
        let before = |p: &FacePoint| {
            let is_before = |node: &SurfaceNode| match node.plate {
                _ if p.is_under_punch() => node.radius <= p.geometry.radius,
                Plate::Punch(depth) => depth <= height - p.height,
                Plate::Support(_) => false,
            };
            let corners = nodes.iter().step_by(2);
            let corners = corners.take(if p.is_under_punch() { face_corners } else { usize::MAX });
            corners.filter(|n| is_before(n)).count().saturating_sub(1)
        };
        let sides = geometry.face.iter().map(before).collect();
        let corners: Vec<f64> = nodes.iter().step_by(2).map(|n| n.radius).collect();
        let friction = boundary.bonded_punch.then_some(boundary.friction);
        let partial_slip = boundary.partial_slip;
        let patches = if partial_slip { one_by_one(face_corners) } else { patches(&corners[..face_corners]) };
        let lengths = lengths(&corners);
        Self {
            nodes,
            face_corners,
            in_mesh_order,
            profile,
            adhesion,
            friction,
            partial_slip,
            patches,
            lengths,
            sides,
        }
    }

    /// Corners that slide together.
    pub(super) fn patches(&self) -> &[Range<usize>] {
        &self.patches
    }

    /// How many nodes lie on the undeformed face.
    pub fn face_nodes(&self) -> usize {
        2 * self.face_corners - 1
    }

    /// The corners of a side that may fold over, but for the rim that rests on the support.
    pub(super) fn side_corners(&self) -> Range<usize> {
        self.face_corners..self.lengths.len().saturating_sub(1).max(self.face_corners)
    }

    /// The nodes, from the axis outwards and down a side that may fold over.
    pub fn nodes(&self) -> &[SurfaceNode] {
        &self.nodes
    }

    /// The nodes with their places from the axis outwards, in the order of the mesh's numbers.
    pub fn in_mesh_order(&self) -> impl Iterator<Item = (usize, &SurfaceNode)> {
        self.in_mesh_order.iter().map(|&index| (index, &self.nodes[index]))
    }

    /// The contact of the undeformed sample with a punch that just touches it.
    pub fn touched(&self) -> Contact {
        let touches = |node: &SurfaceNode| match node.plate {
            Plate::Punch(depth) => depth + self.profile.at(node.radius).height <= 0.0,
            Plate::Support(height) => height <= 0.0,
        };
        let status = |node: &SurfaceNode| if touches(node) { Status::Held } else { Status::Open };
        Contact {
            corners: self.nodes.iter().step_by(2).map(status).collect(),
            middles: vec![false; self.lengths.len() - 1],
            held: vec![0.0; self.nodes.len()],
            yielding: vec![0.0; self.lengths.len()],
        }
    }

    /// Profile of the punch's face.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// The punch's face where a node is held (m).
    pub fn face(&self, node: usize, contact: &Contact) -> Face {
        self.profile.at(self.nodes[node].radius + contact.held[node])
    }

    /// Height of the punch's face above its tip where a node is held (m).
    pub fn height(&self, node: usize, contact: &Contact) -> f64 {
        self.face(node, contact).height
    }

    /// The punch's face over a node that is displaced by the unknowns `x`.
    pub(super) fn face_over(&self, node: usize, x: &[f64]) -> Face {
        let node = &self.nodes[node];
        self.profile.at(node.radius + x[node.radial])
    }

    /// Friction force of the punch on a sliding node over its pressure.
    pub fn friction(&self, node: usize, contact: &Contact) -> f64 {
        contact.friction(node, self.friction.unwrap_or(0.0))
    }

    /// Whether each quadrature point of the face lies on a side in contact.
    pub fn closed_points(&self, contact: &Contact) -> Vec<bool> {
        self.sides.iter().map(|&corner| contact.is_closed(2 * corner + 1)).collect()
    }

    /// Whether the contact ends at a corner that touches: beside it the surface is open.
    pub fn is_at_edge(&self, corner: usize, contact: &Contact) -> bool {
        let beside = [corner.checked_sub(1), Some(corner + 1).filter(|&k| k < self.nodes.len())];
        beside.into_iter().flatten().any(|middle| !contact.is_closed(middle))
    }

    /// Where the surface lies with the unknowns `x`.
    pub fn touch(&self, contact: &Contact, x: &[f64]) -> Touch {
        let meets_punch = |k: &usize| matches!(self.nodes[2 * k].plate, Plate::Punch(_));
        let corners = (0..contact.corners.len()).filter(meets_punch);
        let (open, touched): (Vec<usize>, Vec<usize>) =
            corners.partition(|&k| contact.corners[k] == Status::Open);
        let clearance = open.iter().map(|&k| -self.beyond(2 * k, x, 0.0)).fold(f64::INFINITY, f64::min);
        let face = &self.nodes[..self.face_nodes()];
        let level = face.iter().map(|n| x[n.axial]).sum::<f64>() / face.len() as f64;
        Touch { in_contact: !touched.is_empty(), clearance, level }
    }

    /// How far a node is beyond what it can touch (m), the punch's tip at an indentation (m).
    pub(super) fn beyond(&self, node: usize, x: &[f64], indentation: f64) -> f64 {
        let SurfaceNode { plate, axial, .. } = self.nodes[node];
        match plate {
            Plate::Punch(depth) => x[axial] - self.face_over(node, x).height - depth + indentation,
            Plate::Support(height) => -x[axial] - height,
        }
    }

    /// Whether a side is short enough to follow the face that it lies under.
    pub(super) fn follows_face(&self, side: usize, x: &[f64]) -> bool {
        let angle = |node: usize| self.face_over(node, x).slope.atan();
        (angle(2 * side + 2) - angle(2 * side)).abs() < FOLLOWED_TURN
    }

    /// Force with which a plate presses on a node (N).
    pub(super) fn pressing(&self, node: usize, forces: &[f64]) -> f64 {
        let SurfaceNode { plate, axial, .. } = self.nodes[node];
        if matches!(plate, Plate::Punch(_)) { -forces[axial] } else { forces[axial] }
    }

    /// Shear, positive outwards, and pressure of the punch on a corner, both with respect to its face (N); what
    /// adhesion can bear adds to the pressure.
    pub(super) fn reaction(&self, corner: usize, contact: &Contact, trial: &Trial<'_>) -> (f64, f64) {
        let (radial, pressure) = self.hat_reaction(corner, contact, trial.forces);
        let slope = self.face_over(2 * corner, trial.x).slope;
        let length = (1.0 + slope * slope).sqrt();
        let normal = (pressure + slope * radial) / length;
        ((radial - slope * pressure) / length, normal + self.strength(corner, contact))
    }

    /// Radial force and pressure of the punch on a corner, against its hat function (N); `forces` are the nodal
    /// ones.
    pub(super) fn hat_reaction(&self, corner: usize, contact: &Contact, forces: &[f64]) -> (f64, f64) {
        let middle = 2 * corner;
        let neighbours = [middle.checked_sub(1), Some(middle + 1).filter(|&k| k < self.nodes.len())];
        let (mut radial, mut pressure) = (forces[self.nodes[middle].radial], self.pressing(middle, forces));
        let touches = |k: &usize| contact.clings(k / 2).0 || contact.is_alone(*k);
        for k in neighbours.into_iter().flatten().filter(touches) {
            radial += 0.5 * forces[self.nodes[k].radial];
            pressure += 0.5 * self.pressing(k, forces);
        }
        (radial, pressure)
    }
}

/// Every corner by itself.
fn one_by_one(corners: usize) -> Vec<Range<usize>> {
    (0..corners).map(|k| k..k + 1).collect()
}

/// Corners in patches of at least [`PATCH`] of the outermost radius, gathered from the edge inwards.
fn patches(radii: &[f64]) -> Vec<Range<usize>> {
    let width = PATCH * radii.last().copied().unwrap_or(0.0);
    let (mut patches, mut end) = (Vec::new(), radii.len());
    let mut outer = radii.last().copied().unwrap_or(0.0);
    for start in (0..radii.len()).rev() {
        // A patch reaches half-way to the next corner inwards.
        let inner = if start > 0 { 0.5 * (radii[start - 1] + radii[start]) } else { 0.0 };
        if start == 0 || outer - inner >= width {
            patches.push(start..end);
            (end, outer) = (start, inner);
        }
    }
    patches
}

/// Half the distances to both neighbours (m).
fn lengths(radii: &[f64]) -> Vec<f64> {
    let at = |k: usize| radii[k.min(radii.len() - 1)];
    (0..radii.len()).map(|k| 0.5 * (at(k + 1) - at(k.saturating_sub(1)))).collect()
}
