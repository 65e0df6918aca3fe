//! Which unknowns are prescribed, and to what.

use super::parameters::BoundaryParameters;
use super::profile::{Face, Profile};
use super::status::Contact;
use super::surface::{Plate, Surface};
use crate::mesh::Mesh;

/// Least part of the normal force's axial share that friction leaves.
const LEAST_GLIDE: f64 = 0.1;

/// Condition on one unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Condition {
    /// Solved for.
    Free,
    /// Held at a value, mostly zero.
    Fixed,
    /// Axial displacement of the punch's face: minus the indentation, and the height of its profile.
    Punch,
}

/// A node that slides along a face which is inclined or holds it back by friction.
#[derive(Debug, Clone, Copy)]
pub struct Slide {
    /// Its place on the surface, from the axis outwards.
    pub node: usize,
    /// Unknown `u_r`; `u_z` follows.
    pub radial: usize,
    /// Distance from the axis in the undeformed sample (m).
    pub radius: f64,
    /// Friction force over pressure, positive outwards.
    pub friction: f64,
    /// Adhesive force that adds to the pressure as far as friction goes (N).
    pub adhesion: f64,
}

/// How the punch acts on a sliding node at its present place.
#[derive(Debug, Clone, Copy)]
pub struct Guide {
    /// Radial force of the punch over its axial pressure.
    pub ratio: f64,
    /// Change of that with `u_r` (1/m).
    pub ratio_slope: f64,
    /// Change of that with the friction [-].
    pub ratio_by_friction: f64,
    /// The face.
    pub face: Face,
}

impl Slide {
    /// At the radial displacement that the unknowns `x` have.
    ///
    /// With the face's slope s and the friction f the punch presses with `N (s + f, -1 + f s)`, so that the
    /// radial force is `(s + f) / (1 - f s)` times the pressure.
    pub fn at(&self, profile: &Profile, x: &[f64]) -> Guide {
        let face = profile.at(self.radius + x[self.radial]);
        // Friction that jams the node on a steep flank holds it as if the flank were just not so steep.
        let free = 1.0 - self.friction * face.slope;
        let rest = free.max(LEAST_GLIDE);
        let ratio = (face.slope + self.friction) / rest;
        let ratio_slope = face.curvature * (1.0 + self.friction * self.friction) / (rest * rest);
        let ratio_by_friction = (1.0 + if free > LEAST_GLIDE { ratio * face.slope } else { 0.0 }) / rest;
        Guide { ratio, ratio_slope, ratio_by_friction, face }
    }
}

/// Conditions of all unknowns for one set of nodes in contact.
#[derive(Debug, Clone)]
pub struct Conditions {
    /// One per unknown.
    pub unknowns: Vec<Condition>,
    /// What a fixed unknown is held at, or the height of the punch's profile above its tip (m, Pa).
    pub values: Vec<f64>,
    /// Adhesive pull where the face is open but still bridged, by axial unknown (N).
    pub pulls: Vec<(usize, f64)>,
    /// That of the nodes that are not in contact, which their reactions do not contain (N).
    pub free_pull: f64,
    /// Nodes that slide along the face.
    pub slides: Vec<Slide>,
    /// Axial unknowns in contact, whose residuals sum to the reaction.
    pub punch: Vec<usize>,
    /// Which of the face's quadrature points are in contact.
    pub closed_points: Vec<bool>,
    /// The conditions with all nodes of the face in contact, and with none.
    closed: Vec<Condition>,
    open: Vec<Condition>,
}

impl Conditions {
    /// The conditions of a parameter set on a mesh, all of the punch's face in contact.
    pub fn new(mesh: &Mesh, boundary: &BoundaryParameters) -> Self {
        let mut open = vec![Condition::Free; mesh.unknowns()];
        let mut fix = |unknown: usize| open[unknown] = Condition::Fixed;
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
        let mut closed = open.clone();
        let mut fix = |unknown: usize| closed[unknown] = Condition::Fixed;
        if boundary.drained_punch {
            drain(&mut mesh.punch(), &mut fix);
        }
        if boundary.bonded_punch {
            mesh.punch().for_each(|node| fix(mesh.displacement(node)));
        }
        let punch: Vec<usize> = mesh.punch().map(|node| mesh.displacement(node) + 1).collect();
        for &unknown in &punch {
            closed[unknown] = Condition::Punch;
        }
        if boundary.drained_top {
            drain(&mut mesh.punch(), &mut |unknown| open[unknown] = Condition::Fixed);
        }
        for node in mesh.folding_side() {
            let upper = mesh.is_upper(mesh.nodes[node as usize][1]);
            let (bonded, drained) = if upper {
                (boundary.bonded_punch, boundary.drained_punch)
            } else {
                (boundary.bonded_bottom, boundary.drained_bottom)
            };
            let held = |is_held| if is_held { Condition::Fixed } else { Condition::Free };
            let radial = mesh.displacement(node);
            closed[radial] = held(bonded);
            closed[radial + 1] = if upper { Condition::Punch } else { Condition::Fixed };
            if let Some(pressure) = mesh.pressure(node) {
                closed[pressure] = held(drained);
            }
        }
        let values = vec![0.0; mesh.unknowns()];
        Self {
            unknowns: closed.clone(),
            values,
            pulls: Vec::new(),
            free_pull: 0.0,
            slides: Vec::new(),
            punch,
            closed_points: Vec::new(),
            closed,
            open,
        }
    }

    /// Force of the punch on the sample (N) from the nodal residuals of all unknowns.
    pub fn reaction(&self, raw_residual: &[f64]) -> f64 {
        -self.punch.iter().map(|&unknown| raw_residual[unknown]).sum::<f64>() - self.free_pull
    }

    /// Adhesive pull on an axial unknown (N).
    pub fn pull(&self, axial: usize) -> f64 {
        self.pulls.iter().find(|(unknown, _)| *unknown == axial).map_or(0.0, |(_, pull)| *pull)
    }

    /// Takes over which nodes are in contact, and where they stick.
    pub fn apply(&mut self, surface: &Surface, contact: &Contact) {
        self.punch.clear();
        self.closed_points = surface.closed_points(contact);
        self.slides.clear();
        self.pulls.clear();
        self.free_pull = 0.0;
        for (index, node) in surface.in_mesh_order() {
            let closed = contact.is_closed(index);
            let from = if closed { &self.closed } else { &self.open };
            for unknown in [Some(node.radial), Some(node.axial), node.pressure].into_iter().flatten() {
                self.unknowns[unknown] = from[unknown];
                self.values[unknown] = 0.0;
            }
            if let Some(pressure) = node.pressure.filter(|_| closed && surface.is_at_edge(index, contact)) {
                // The water leaves at the edge of the contact.
                self.unknowns[pressure] = self.open[pressure];
            }
            let pull = surface.pull(index, contact);
            if pull != 0.0 {
                self.pulls.push((node.axial, pull));
                self.free_pull += if closed { 0.0 } else { pull };
            }
            if closed {
                self.values[node.radial] = contact.held[index];
                self.values[node.axial] = match node.plate {
                    Plate::Punch(depth) => {
                        self.punch.push(node.axial);
                        depth + surface.height(index, contact)
                    }
                    Plate::Support(height) => -height,
                };
                let loose = self.closed[node.radial] == Condition::Free || !contact.is_held(index);
                if loose && self.open[node.radial] == Condition::Free {
                    self.unknowns[node.radial] = Condition::Free;
                    let friction = surface.friction(index, contact);
                    if friction != 0.0 || !surface.profile().is_flat() {
                        let (radial, radius) = (node.radial, node.radius);
                        let adhesion = surface.cling(index, contact);
                        self.slides.push(Slide { node: index, radial, radius, friction, adhesion });
                    }
                }
            }
        }
    }
}
