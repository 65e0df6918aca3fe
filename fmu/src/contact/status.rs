//! Which nodes of the surface are in contact, and how.

use serde::{Deserialize, Serialize};
use std::ops::Range;

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
    pub(super) fn is_closed(self) -> bool {
        !matches!(self, Self::Open | Self::Bridged)
    }

    /// Direction of full friction, positive outwards.
    pub(super) fn direction(self) -> f64 {
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
    pub(super) middles: Vec<bool>,
    /// Radial displacement at which each node stuck when it was last touched (m).
    pub(super) held: Vec<f64>,
    /// Friction, positive outwards over pressure, under which each corner yields.
    pub(super) yielding: Vec<f64>,
}

impl Contact {
    /// Whether a node of the surface is in contact.
    pub fn is_closed(&self, node: usize) -> bool {
        self.is_alone(node) || self.around(node).iter().all(|status| status.is_closed())
    }

    /// Whether a node is a mid-side node in contact beside an open corner.
    pub(super) fn is_alone(&self, node: usize) -> bool {
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
    pub(super) fn friction(&self, node: usize, coefficient: f64) -> f64 {
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

    /// Numbers of its entries.
    pub fn lengths(&self) -> [usize; 4] {
        [self.corners.len(), self.middles.len(), self.held.len(), self.yielding.len()]
    }

    /// The corners, from the axis outwards.
    pub fn corners(&self) -> &[Status] {
        &self.corners
    }
}
