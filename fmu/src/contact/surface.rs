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
//! Under a platen the free side of a bonded sample folds over: from the rims on it lies down on the platen and on the
//! support. Its corners follow those of the face; one that touches a plate sticks (slides on a frictionless one) until
//! it is pulled.

use super::adhesion::Adhesion;
use super::parameters::BoundaryParameters;
use super::profile::{Face, Profile};
use super::yielding::Yield;
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
    face_corners: usize,
    /// Their places in the order of the mesh's numbers.
    in_mesh_order: Vec<usize>,
    profile: Profile,
    pub(super) adhesion: Adhesion,
    /// Friction coefficient of a bonded face; a frictionless one has none.
    friction: Option<f64>,
    /// Corners that slide together.
    patches: Vec<Range<usize>>,
    /// Length of the surface that each corner stands for (m).
    lengths: Vec<f64>,
    /// The inner corner of the side on which each quadrature point of the face lies.
    sides: Vec<usize>,
}

/// How a corner of the surface is in contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// Not at all.
    Open,
    /// Held radially by a bonded face; free to slide on a frictionless one.
    Held,
    /// Slides against the friction of a bonded face, which pushes the sample outwards.
    PushedOutwards,
    /// The same with friction that pushes inwards.
    PushedInwards,
    /// Open, but the punch still pulls by adhesion.
    Bridged,
    /// Slides for one stage under the shear that it has.
    Yields,
}

impl Status {
    fn is_closed(self) -> bool {
        !matches!(self, Self::Open | Self::Bridged)
    }

    /// Direction of full friction, positive outwards.
    fn direction(self) -> f64 {
        match self {
            Self::Open | Self::Held | Self::Bridged | Self::Yields => 0.0,
            Self::PushedOutwards => 1.0,
            Self::PushedInwards => -1.0,
        }
    }
}

/// Which nodes are in contact, and how.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Contact {
    /// The corners, from the axis outwards.
    pub(super) corners: Vec<Status>,
    /// Mid-side nodes that are in contact although one of their corners is open.
    middles: Vec<bool>,
    /// Radial displacement at which each node stuck when it was last touched (m).
    pub(super) held: Vec<f64>,
    /// Friction, positive outwards over pressure, under which each corner yields.
    yielding: Vec<f64>,
}

/// How the contact goes on after a solution: the part of it that is a choice, not a number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decision {
    /// The corners from then on.
    corners: Vec<Status>,
    /// The mid-side nodes, as [`Contact`] has them.
    middles: Vec<bool>,
    /// Whether the solution may not stand.
    pub solve_again: bool,
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

/// Slacks below which nothing is pulled and nothing passes through the face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slack {
    /// Force (N).
    pub force: f64,
    /// Length (m).
    pub length: f64,
}

/// A solution for one set of nodes in contact.
#[derive(Debug, Clone, Copy)]
pub struct Trial<'a> {
    /// Its unknowns.
    pub x: &'a [f64],
    /// The unknowns at the start of the stage.
    pub from: &'a [f64],
    /// Nodal forces.
    pub forces: &'a [f64],
    /// Indentation (m).
    pub indentation: f64,
    /// What is too small to matter.
    pub slack: Slack,
}

/// What a stage already did, so that its set settles.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Past {
    /// Corners that opened.
    opened: Vec<bool>,
    /// Mid-side nodes that opened by themselves.
    opened_middles: Vec<bool>,
    /// Patches that slid.
    slid: Vec<bool>,
}

impl Decision {
    /// The corners, from the axis outwards.
    pub fn corners(&self) -> &[Status] {
        &self.corners
    }
}

impl Contact {
    /// Whether a node of the surface is in contact.
    pub fn is_closed(&self, node: usize) -> bool {
        self.is_alone(node) || self.around(node).iter().all(|status| status.is_closed())
    }

    /// Whether a node is a mid-side node in contact beside an open corner.
    fn is_alone(&self, node: usize) -> bool {
        node % 2 == 1 && self.middles[node / 2]
    }

    /// Whether the punch still holds a side by contact or adhesion, and whether it does so over a gap.
    pub(super) fn clings(&self, side: usize) -> (bool, bool) {
        let ends = [self.corners[side], self.corners[side + 1]];
        let intact = ends.iter().all(|status| *status != Status::Open);
        (intact, intact && ends.contains(&Status::Bridged))
    }

    /// The corners of a patch that are in contact.
    pub(super) fn closed(&self, patch: &Range<usize>) -> impl Iterator<Item = usize> + Clone + '_ {
        patch.clone().filter(|&k| self.corners[k].is_closed())
    }

    /// Whether a node that is in contact is held radially by a bonded face.
    pub fn is_held(&self, node: usize) -> bool {
        let is_alone = self.is_alone(node);
        self.around(node).iter().all(|status| *status == Status::Held || (is_alone && !status.is_closed()))
    }

    /// Friction of the punch on a node, positive outwards, over its pressure, for a friction coefficient.
    fn friction(&self, node: usize, coefficient: f64) -> f64 {
        self.corner_friction(self.rubbing_corner(node, coefficient), coefficient)
    }

    /// The corner under whose yielding friction a node slides.
    pub fn yielding_corner(&self, node: usize) -> Option<usize> {
        // Which corner acts does not depend on the size of the other's friction.
        Some(self.rubbing_corner(node, 1.0)).filter(|&corner| self.corners[corner] == Status::Yields)
    }

    /// The corner whose friction acts on a node: the outer one unless it has none.
    fn rubbing_corner(&self, node: usize, coefficient: f64) -> usize {
        let (inner, outer) = (node / 2, node.div_ceil(2));
        if self.corner_friction(outer, coefficient) == 0.0 { inner } else { outer }
    }

    fn corner_friction(&self, corner: usize, coefficient: f64) -> f64 {
        let status = self.corners[corner];
        if status == Status::Yields { self.yielding[corner] } else { status.direction() * coefficient }
    }

    /// The corner, twice, or the corners at both sides of a mid-side node.
    fn around(&self, node: usize) -> [Status; 2] {
        [self.corners[node / 2], self.corners[node.div_ceil(2)]]
    }

    /// Whether any node is in contact, or pulled by adhesion.
    pub fn any(&self) -> bool {
        self.corners.iter().any(|status| *status != Status::Open)
    }

    /// Whether the same nodes are in contact, held where they were, or sliding; no patch yields.
    pub fn touches_as(&self, other: &Self) -> bool {
        let kind = |status: &Status| (status.is_closed(), *status == Status::Open, *status == Status::Yields);
        self.corners.iter().map(kind).eq(other.corners.iter().map(kind))
            && self.middles == other.middles
            && self.held == other.held
    }

    /// The corners, from the axis outwards.
    pub fn corners(&self) -> &[Status] {
        &self.corners
    }
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
        let (patches, lengths) = (patches(&corners[..face_corners]), lengths(&corners));
        Self { nodes, face_corners, in_mesh_order, profile, adhesion, friction, patches, lengths, sides }
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
    fn side_corners(&self) -> Range<usize> {
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

    /// Whether a contact has this surface's number of nodes.
    pub fn fits(&self, contact: &Contact) -> bool {
        let corners = self.lengths.len();
        contact.held.len() == self.nodes.len()
            && contact.corners.len() == corners
            && contact.middles.len() + 1 == corners
            && contact.yielding.len() == corners
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
    fn beyond(&self, node: usize, x: &[f64], indentation: f64) -> f64 {
        let SurfaceNode { plate, axial, .. } = self.nodes[node];
        match plate {
            Plate::Punch(depth) => x[axial] - self.face_over(node, x).height - depth + indentation,
            Plate::Support(height) => -x[axial] - height,
        }
    }

    /// Whether a side is short enough to follow the face that it lies under.
    fn follows_face(&self, side: usize, x: &[f64]) -> bool {
        let angle = |node: usize| self.face_over(node, x).slope.atan();
        (angle(2 * side + 2) - angle(2 * side)).abs() < FOLLOWED_TURN
    }

    /// Force with which a plate presses on a node (N).
    fn pressing(&self, node: usize, forces: &[f64]) -> f64 {
        let SurfaceNode { plate, axial, .. } = self.nodes[node];
        if matches!(plate, Plate::Punch(_)) { -forces[axial] } else { forces[axial] }
    }

    /// Shear, positive outwards, and pressure of the punch on a corner, both with respect to its face (N); what
    /// adhesion can bear adds to the pressure.
    fn reaction(&self, corner: usize, contact: &Contact, trial: &Trial<'_>) -> (f64, f64) {
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

    /// How the bond of a patch changes, if at all, and whether that cannot wait for the next stage.
    fn bond(
        &self,
        patch: &Range<usize>,
        contact: &Contact,
        trial: &Trial<'_>,
        slid: bool,
    ) -> Option<(Status, bool)> {
        let friction = self.friction?;
        let first = contact.closed(patch).next()?;
        match contact.corners[first] {
            Status::Yields => Some((Status::Held, false)),
            Status::Held if slid => None,
            Status::Held => self.failure(patch, contact, trial, friction),
            sliding => self.turned(patch, contact, trial, sliding).then_some((Status::Held, false)),
        }
    }

    /// Whether a patch that slides moved against its direction.
    fn turned(&self, patch: &Range<usize>, contact: &Contact, trial: &Trial<'_>, sliding: Status) -> bool {
        let (mut motion, mut length) = (0.0, 0.0);
        for k in contact.closed(patch) {
            let radial = self.nodes[2 * k].radial;
            motion += self.lengths[k] * (trial.x[radial] - trial.from[radial]);
            length += self.lengths[k];
        }
        motion * sliding.direction() > trial.slack.length * length
    }

    /// How the bond of a patch that is held fails, as [`Surface::bond`].
    fn failure(
        &self,
        patch: &Range<usize>,
        contact: &Contact,
        trial: &Trial<'_>,
        friction: f64,
    ) -> Option<(Status, bool)> {
        let reactions = contact.closed(patch).map(|k| self.reaction(k, contact, trial));
        let pulled = reactions.clone().any(|(_, pressure)| pressure < -trial.slack.force);
        let (shear, pressure) = reactions.fold((0.0, 0.0), |sum, r| (sum.0 + r.0, sum.1 + r.1));
        let loose = |k: usize| k < self.face_corners && contact.corners[k] != Status::Held;
        let at_open_edge =
            patch.start.checked_sub(1).is_some_and(loose) || loose(patch.end) || patch.clone().any(loose);
        let exceeds = shear.abs() > friction * pressure + trial.slack.force;
        match (pulled, exceeds) {
            (true, false) => Some((Status::Yields, true)),
            (_, true) if pulled || at_open_edge => {
                let outwards = shear > 0.0;
                Some((if outwards { Status::PushedOutwards } else { Status::PushedInwards }, pulled))
            }
            _ => None,
        }
    }

    /// What happened before anything did.
    pub fn no_past(&self) -> Past {
        let corners = self.lengths.len();
        Past {
            opened: vec![false; corners],
            opened_middles: vec![false; corners - 1],
            slid: vec![false; self.patches.len()],
        }
    }

    /// Decides which corners open where they are pulled, close where they pass through the face, or slide. A corner
    /// that opened within the stage, which `past` tells, does not close again in it, and a patch slides at most
    /// once. What begins or ends to slide under pressure does so from the next stage on.
    pub fn decide(&self, before: &Contact, trial: &Trial<'_>, past: &mut Past) -> Decision {
        let mut corners = before.corners.clone();
        let mut solve_again = false;
        for (patch, slid) in self.patches.iter().zip(&mut past.slid) {
            if let Some((status, at_once)) = self.bond(patch, before, trial, *slid) {
                for k in before.closed(patch) {
                    corners[k] = status;
                }
                *slid |= status != Status::Held;
                solve_again |= at_once;
                if at_once {
                    // What is pulled may only have to slide out from under the edge.
                    continue;
                }
            }
            let closed = patch.clone().map(|k| corners[k]).find(|status| status.is_closed());
            for k in patch.clone() {
                let is_open = !before.corners[k].is_closed();
                let above_face = self.beyond(2 * k, trial.x, trial.indentation);
                if !is_open && self.reaction(k, before, trial).1 < -trial.slack.force {
                    corners[k] = if self.adhesion.is_active() { Status::Bridged } else { Status::Open };
                    past.opened[k] = true;
                    solve_again = true;
                } else if before.corners[k] == Status::Bridged && -above_face > self.adhesion.opening {
                    corners[k] = Status::Open;
                    past.opened[k] = true;
                    solve_again = true;
                } else if is_open && !past.opened[k] && above_face > trial.slack.length {
                    corners[k] = closed.unwrap_or(Status::Held);
                    solve_again = true;
                }
            }
        }
        for k in self.side_corners() {
            if before.corners[k].is_closed() {
                if self.reaction(k, before, trial).1 < -trial.slack.force {
                    corners[k] = Status::Open;
                    past.opened[k] = true;
                    solve_again = true;
                }
            } else if !past.opened[k] && self.beyond(2 * k, trial.x, trial.indentation) > trial.slack.length {
                corners[k] = Status::Held;
                solve_again = true;
            }
        }
        let mut middles = vec![false; corners.len() - 1];
        for (side, middle) in middles.iter_mut().enumerate() {
            if corners[side].is_closed() == corners[side + 1].is_closed() {
                continue;
            }
            let node = 2 * side + 1;
            let pressure = self.pressing(node, trial.forces) + self.bond_strength(node, before);
            *middle = if before.is_alone(node) {
                let is_pulled = pressure < -trial.slack.force;
                past.opened_middles[side] |= is_pulled;
                solve_again |= is_pulled;
                !is_pulled
            } else if before.is_closed(node) {
                // What opens is a corner; the node stays as long as it is pressed.
                pressure > trial.slack.force && self.follows_face(side, trial.x)
            } else {
                let passes = self.beyond(node, trial.x, trial.indentation) > trial.slack.length;
                let closes = passes && !past.opened_middles[side] && self.follows_face(side, trial.x);
                solve_again |= closes;
                closes
            };
        }
        Decision { corners, middles, solve_again }
    }

    /// The contact after a decision: a node that is touched, or no longer slides, sticks where the solution has it,
    /// and a patch that begins to yield does so under the shear that it has there.
    pub fn follow(&self, before: &Contact, decision: &Decision, trial: &Trial<'_>) -> Contact {
        let (corners, middles) = (decision.corners.clone(), decision.middles.clone());
        let mut contact = Contact { corners, middles, ..before.clone() };
        for (k, node) in self.nodes.iter().enumerate() {
            if contact.is_held(k) && !before.is_held(k) {
                contact.held[k] = trial.x[node.radial];
            }
        }
        for patch in &self.patches {
            let friction = match self.yields_from(patch, before, &contact) {
                Yield::No => 0.0,
                Yield::As(corner) => before.yielding[corner],
                Yield::Anew => {
                    let reactions = before.closed(patch).map(|k| self.reaction(k, before, trial));
                    let (shear, pressure) = reactions.fold((0.0, 0.0), |sum, r| (sum.0 + r.0, sum.1 + r.1));
                    shear / pressure
                }
            };
            patch.clone().for_each(|k| contact.yielding[k] = friction);
        }
        contact
    }
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
