//! What opens, closes, sticks or slides after a solution: the active set's rules.

use super::status::{Contact, Status};
use super::surface::Surface;
use super::yielding::Yield;
use std::ops::Range;

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

impl Surface {
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
        let exceeds = shear.abs() > friction * pressure + trial.slack.force;
        let slides = if shear > 0.0 { Status::PushedOutwards } else { Status::PushedInwards };
        if self.partial_slip {
            // What is pulled opens; on the axis there is no shear.
            return (exceeds && !pulled && patch.start > 0).then_some((slides, true));
        }
        let loose = |k: usize| k < self.face_corners && contact.corners[k] != Status::Held;
        let at_open_edge =
            patch.start.checked_sub(1).is_some_and(loose) || loose(patch.end) || patch.clone().any(loose);
        match (pulled, exceeds) {
            (true, false) => Some((Status::Yields, true)),
            (_, true) if pulled || at_open_edge => Some((slides, pulled)),
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
    /// once. What begins or ends to slide under pressure does so from the next stage on; where friction alone holds the
    /// face it begins at once.
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
