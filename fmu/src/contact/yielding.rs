//! Patches of the bond that yield, and how their friction changes.

use super::status::{Contact, Status};
use super::surface::Surface;
use std::ops::Range;

/// Where the friction of a patch comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Yield {
    /// It does not yield.
    No,
    /// It yielded before, as this corner of it did.
    As(usize),
    /// It begins to yield under the shear that it has.
    Anew,
}

impl Surface {
    /// Whether and how a patch yields that did as `before` tells.
    pub(super) fn yields_from(&self, patch: &Range<usize>, before: &Contact, now: &Contact) -> Yield {
        let yields = |contact: &Contact| patch.clone().find(|&k| contact.corners()[k] == Status::Yields);
        match (yields(before), yields(now)) {
            (_, None) => Yield::No,
            (Some(corner), Some(_)) => Yield::As(corner),
            (None, Some(_)) => Yield::Anew,
        }
    }

    /// Whether a patch begins to yield.
    pub fn begins_to_yield(&self, before: &Contact, now: &Contact) -> bool {
        self.patches().iter().any(|patch| self.yields_from(patch, before, now) == Yield::Anew)
    }

    /// Whether the contact from now on depends on the solution by more than which nodes are in contact: where nodes
    /// stick, or under which friction patches yield.
    pub fn remembers(&self, before: &Contact, now: &Contact) -> bool {
        let sticks = |k: usize| now.is_held(k) && !before.is_held(k);
        (0..self.nodes().len()).any(sticks) || self.begins_to_yield(before, now)
    }

    /// Changes of the friction of every corner, as [`Surface::follow`] sets it, by one parameter.
    ///
    /// `solution` are unknowns and nodal forces, `change` their changes and that of the strength of adhesion; `yielding` holds
    /// the changes so far.
    pub fn differentiate_yield(
        &self,
        (before, now): (&Contact, &Contact),
        solution: (&[f64], &[f64]),
        change: (&[f64], &[f64], f64),
        yielding: &mut [f64],
    ) {
        for patch in self.patches() {
            let by_parameter = match self.yields_from(patch, before, now) {
                Yield::No => 0.0,
                Yield::As(corner) => yielding[corner],
                Yield::Anew => {
                    let (mut sum, mut by_parameter) = ([0.0; 2], [0.0; 2]);
                    for k in before.closed(patch) {
                        let [value, slope] = self.reaction_with_change(k, before, solution, change);
                        (0..2).for_each(|i| sum[i] += value[i]);
                        (0..2).for_each(|i| by_parameter[i] += slope[i]);
                    }
                    let [shear, pressure] = sum;
                    (by_parameter[0] - shear / pressure * by_parameter[1]) / pressure
                }
            };
            patch.clone().for_each(|k| yielding[k] = by_parameter);
        }
    }

    /// Shear and pressure of the punch on a corner as [`Surface::reaction`] has them (N), and their changes.
    fn reaction_with_change(
        &self,
        corner: usize,
        contact: &Contact,
        (x, forces): (&[f64], &[f64]),
        (x_change, force_change, strength_change): (&[f64], &[f64], f64),
    ) -> [[f64; 2]; 2] {
        let (radial, pressure) = self.hat_reaction(corner, contact, forces);
        let (radial_change, pressure_change) = self.hat_reaction(corner, contact, force_change);
        let face = self.face_over(2 * corner, x);
        let length = (1.0 + face.slope * face.slope).sqrt();
        let slope_change = face.curvature * x_change[self.nodes()[2 * corner].radial];
        // The shear turns into the normal force as the face turns under the corner.
        let turn = slope_change / (length * length);
        let strengthening =
            if strength_change == 0.0 { 0.0 } else { strength_change * self.strength_area(corner, contact) };
        let shear = (radial - face.slope * pressure) / length;
        let normal = (pressure + face.slope * radial) / length;
        [
            [shear, normal + self.strength(corner, contact)],
            [
                (radial_change - face.slope * pressure_change) / length - turn * normal,
                (pressure_change + face.slope * radial_change) / length + turn * shear + strengthening,
            ],
        ]
    }
}
