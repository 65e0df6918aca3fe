//! Shape of the punch's face, and the conditions on the surfaces of the sample.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Shape of the punch's face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum IndenterProfile {
    /// A plane.
    #[default]
    Flat,
    /// A sphere.
    Sphere,
    /// A cone.
    Cone,
}

/// The punch's face; dimensions of a profile that was not chosen stay at their defaults.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IndenterParameters {
    /// Its shape.
    pub profile: IndenterProfile,
    /// Radius of a flat punch's edge (m); 0: sharp.
    pub edge_radius: f64,
    /// Radius of the sphere (m).
    pub sphere_radius: f64,
    /// Angle between the cone's axis and its flank (rad).
    pub cone_half_angle: f64,
}

impl Default for IndenterParameters {
    fn default() -> Self {
        Self {
            profile: IndenterProfile::Flat,
            edge_radius: 0.0,
            sphere_radius: 4e-3,
            cone_half_angle: PI / 3.0,
        }
    }
}

impl IndenterParameters {
    /// Whether the face is a plane up to a sharp edge.
    pub fn is_plane(&self) -> bool {
        self.profile == IndenterProfile::Flat && self.edge_radius == 0.0
    }

    /// Distance from the axis (m) from which on the edge of the contact can run; `None` where it is the punch's.
    pub fn contact_edge_from(&self, punch_radius: f64) -> Option<f64> {
        match self.profile {
            IndenterProfile::Flat => (!self.is_plane()).then_some(punch_radius - self.edge_radius),
            IndenterProfile::Sphere | IndenterProfile::Cone => Some(0.0),
        }
    }
}

/// Boundary conditions, each one switchable. `default()` is the paper's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoundaryParameters {
    /// p = 0 on the bottom; otherwise no flux.
    pub drained_bottom: bool,
    /// p = 0 on the lateral surface.
    pub drained_side: bool,
    /// p = 0 on the free part of the top.
    pub drained_top: bool,
    /// p = 0 under the punch (porous punch).
    pub drained_punch: bool,
    /// u_r = 0 under the punch (full adhesion); otherwise frictionless.
    pub bonded_punch: bool,
    /// Friction coefficient of a bonded punch [-]: the bond fails beside an open part of the face - with `partial_slip`
    /// everywhere - where the shear exceeds this times the pressure.
    pub friction: f64,
    /// Friction alone holds a bonded punch: Coulomb's law at every corner of the face, under pressure, too.
    pub partial_slip: bool,
    /// u_r = 0 on the bottom (glued); otherwise it slides on its support.
    pub bonded_bottom: bool,
    /// u_r = 0 on the lateral surface (sample in a smooth rigid ring); otherwise it is free.
    pub confined_side: bool,
}

impl Default for BoundaryParameters {
    fn default() -> Self {
        Self {
            drained_bottom: true,
            drained_side: true,
            drained_top: true,
            drained_punch: false,
            bonded_punch: true,
            friction: 1.0,
            partial_slip: false,
            bonded_bottom: true,
            confined_side: false,
        }
    }
}
