//! Adhesion on retraction: the surface that was touched clings to the punch.
//!
//! Dugdale's law, per reference area and along the axis: what is in contact stays there up to a pull of the
//! strength s; where it opens the punch still pulls with s, until the gap exceeds the critical opening d and the
//! bond breaks for good - until the place is touched again. The work of adhesion is `s d` (J/m^2), the largest pull
//! `s` times the area. Friction acts on the pressure and the strength together (Derjaguin). Approach is free of it.

use super::status::Contact;
use super::surface::Surface;
use std::f64::consts::PI;

/// Dugdale's law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adhesion {
    /// s (Pa); 0: none.
    pub strength: f64,
    /// d (m).
    pub opening: f64,
}

impl Adhesion {
    /// No adhesion.
    pub const NONE: Self = Self { strength: 0.0, opening: 0.0 };

    pub(super) fn is_active(&self) -> bool {
        self.strength != 0.0
    }
}

impl Surface {
    /// Areas that the three nodes of a side stand for (m^2).
    fn areas(&self, side: usize) -> [f64; 3] {
        nodal_areas(self.nodes[2 * side].radius, self.nodes[2 * side + 2].radius)
    }

    /// Sum of a node's areas on its sides of the kind that `of` picks from intact and bridged ones (m^2).
    fn area(&self, node: usize, contact: &Contact, of: fn((bool, bool)) -> bool) -> f64 {
        let sides = (node.saturating_sub(1) / 2..=node / 2).filter(|side| *side + 1 < contact.corners.len());
        sides.filter(|side| of(contact.clings(*side))).map(|side| self.areas(side)[node - 2 * side]).sum()
    }

    /// Adhesive pull on a node from its sides that are open but bridged (N).
    pub fn pull(&self, node: usize, contact: &Contact) -> f64 {
        if !self.adhesion.is_active() {
            return 0.0;
        }
        self.adhesion.strength * self.bridged_area(node, contact)
    }

    /// Area of a node on its sides that are open but bridged (m^2).
    pub fn bridged_area(&self, node: usize, contact: &Contact) -> f64 {
        self.area(node, contact, |(_, bridged)| bridged)
    }

    /// Adhesive force on a node from its sides that are in contact (N).
    pub fn cling(&self, node: usize, contact: &Contact) -> f64 {
        if !self.adhesion.is_active() {
            return 0.0;
        }
        self.adhesion.strength * self.clinging_area(node, contact)
    }

    /// Area of a node on its sides that are in contact (m^2).
    pub fn clinging_area(&self, node: usize, contact: &Contact) -> f64 {
        self.area(node, contact, |(intact, bridged)| intact && !bridged)
    }

    /// Pull that adhesion bears on a node (N).
    pub(super) fn bond_strength(&self, node: usize, contact: &Contact) -> f64 {
        if !self.adhesion.is_active() {
            return 0.0;
        }
        self.adhesion.strength * self.bonded_area(node, contact)
    }

    /// Area of a node on its sides that are in contact or bridged (m^2).
    fn bonded_area(&self, node: usize, contact: &Contact) -> f64 {
        self.area(node, contact, |(intact, _)| intact)
    }

    /// Pull that adhesion bears against a corner's hat function (N).
    pub(super) fn strength(&self, corner: usize, contact: &Contact) -> f64 {
        self.against_hat(corner, |node| self.bond_strength(node, contact))
    }

    /// Change of that by the strength (m^2).
    pub(super) fn strength_area(&self, corner: usize, contact: &Contact) -> f64 {
        self.against_hat(corner, |node| self.bonded_area(node, contact))
    }

    /// A quantity of the nodes against a corner's hat function.
    fn against_hat(&self, corner: usize, of: impl Fn(usize) -> f64) -> f64 {
        let around = (2 * corner).saturating_sub(1)..=(2 * corner + 1).min(self.nodes.len() - 1);
        let weight = |node: usize| if node == 2 * corner { 1.0 } else { 0.5 };
        around.map(|node| weight(node) * of(node)).sum()
    }
}

/// Areas of a ring between two radii (m) that its inner, middle and outer node stand for, with quadratic shape
/// functions: `int N 2 pi r dr` (m^2).
fn nodal_areas(inner: f64, outer: f64) -> [f64; 3] {
    let third = PI * (outer - inner) / 3.0;
    [third * inner, third * 2.0 * (inner + outer), third * outer]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_of_a_ring_sum_to_it() {
        let areas = nodal_areas(0.7, 1.9);
        approx::assert_relative_eq!(areas.iter().sum::<f64>(), PI * (1.9 * 1.9 - 0.49), max_relative = 1e-14);
        // First moment of a linear field: int r 2 pi r dr.
        let moment = 0.7 * areas[0] + 1.3 * areas[1] + 1.9 * areas[2];
        approx::assert_relative_eq!(moment, 2.0 / 3.0 * PI * (1.9_f64.powi(3) - 0.343), max_relative = 1e-14);
    }
}
