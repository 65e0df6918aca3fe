//! Where adhesion holds the surface on the punch, and with what force.

use super::contact::{Contact, Surface};
use crate::effect::adhesion;

impl Surface {
    /// Areas that the three nodes of a side stand for (m^2).
    fn areas(&self, side: usize) -> [f64; 3] {
        adhesion::nodal_areas(self.nodes[2 * side].radius, self.nodes[2 * side + 2].radius)
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
        self.adhesion.strength * self.area(node, contact, |(_, bridged)| bridged)
    }

    /// Adhesive force on a node from its sides that are in contact (N).
    pub fn cling(&self, node: usize, contact: &Contact) -> f64 {
        if !self.adhesion.is_active() {
            return 0.0;
        }
        self.adhesion.strength * self.area(node, contact, |(intact, bridged)| intact && !bridged)
    }

    /// Pull that adhesion bears against a corner's hat function (N).
    pub(super) fn strength(&self, corner: usize, contact: &Contact) -> f64 {
        if !self.adhesion.is_active() {
            return 0.0;
        }
        let around = (2 * corner).saturating_sub(1)..=(2 * corner + 1).min(self.nodes.len() - 1);
        let weight = |node: usize| if node == 2 * corner { 1.0 } else { 0.5 };
        let intact = |(intact, _): (bool, bool)| intact;
        around.map(|node| self.adhesion.strength * weight(node) * self.area(node, contact, intact)).sum()
    }
}
