//! Profiles of the indenter: height of its face above its tip at a distance from the axis.

use super::parameters::{IndenterParameters, IndenterProfile};

/// Largest distance from a sphere's or an edge's middle over its radius. Beyond it, where a node of the surface may still be pushed,
/// the face goes on along its tangent: a sphere has no height beyond its radius.
pub const LARGEST_CAP: f64 = 0.9;

/// Height, slope and curvature of the face at one distance from the axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Face {
    /// Above the tip (m).
    pub height: f64,
    /// dh/dr [-].
    pub slope: f64,
    /// d2h/dr2 (1/m).
    pub curvature: f64,
}

/// A rigid axisymmetric face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Profile {
    /// Flat.
    Flat,
    /// Flat up to a distance from the axis (m), then rounded with a radius (m).
    Rounded {
        /// Radius of the flat part (m).
        flat: f64,
        /// Radius of the edge (m).
        edge: f64,
    },
    /// A sphere of this radius (m).
    Sphere(f64),
    /// A cone whose face rises by this slope [-].
    Cone(f64),
}

impl Profile {
    /// The profile that the parameters describe.
    pub fn new(indenter: &IndenterParameters, punch_radius: f64) -> Self {
        match indenter.profile {
            IndenterProfile::Flat if indenter.is_plane() => Self::Flat,
            IndenterProfile::Flat => {
                Self::Rounded { flat: punch_radius - indenter.edge_radius, edge: indenter.edge_radius }
            }
            IndenterProfile::Sphere => Self::Sphere(indenter.sphere_radius),
            IndenterProfile::Cone => Self::Cone(1.0 / indenter.cone_half_angle.tan()),
        }
    }

    /// Whether the face is a plane, so that all of it is touched at once.
    pub fn is_flat(&self) -> bool {
        *self == Self::Flat
    }

    /// The face at a distance from the axis (m).
    pub fn at(&self, radius: f64) -> Face {
        match *self {
            Self::Flat => Face::default(),
            Self::Cone(slope) => Face { height: slope * radius, slope, curvature: 0.0 },
            Self::Sphere(sphere) => cap(sphere, radius),
            Self::Rounded { flat, .. } if radius <= flat => Face::default(),
            Self::Rounded { flat, edge } => cap(edge, radius - flat),
        }
    }
}

/// A sphere's face at a distance from its lowest point.
fn cap(sphere: f64, distance: f64) -> Face {
    let within = distance.min(LARGEST_CAP * sphere);
    let rise = (sphere * sphere - within * within).sqrt();
    let slope = within / rise;
    let height = within * within / (sphere + rise) + slope * (distance - within);
    let curvature = if distance > within { 0.0 } else { sphere * sphere / rise.powi(3) };
    Face { height, slope, curvature }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_and_curvatures_are_derivatives() {
        let rounded = Profile::Rounded { flat: 0.6, edge: 0.8 };
        for profile in [Profile::Flat, Profile::Sphere(2.0), Profile::Cone(0.3), rounded] {
            for radius in [0.1, 0.7, 1.3, 2.5] {
                let (face, e) = (profile.at(radius), 1e-5);
                let (up, down) = (profile.at(radius + e), profile.at(radius - e));
                approx::assert_relative_eq!(
                    face.slope,
                    (up.height - down.height) / (2.0 * e),
                    epsilon = 1e-8,
                    max_relative = 1e-7
                );
                approx::assert_relative_eq!(
                    face.curvature,
                    (up.slope - down.slope) / (2.0 * e),
                    epsilon = 1e-8,
                    max_relative = 1e-7
                );
            }
        }
    }

    #[test]
    fn heights_are_those_of_the_bodies() {
        approx::assert_relative_eq!(Profile::Sphere(5.0).at(3.0).height, 1.0, max_relative = 1e-15);
        let cone = IndenterParameters {
            profile: IndenterProfile::Cone,
            cone_half_angle: 60.0_f64.to_radians(),
            ..Default::default()
        };
        // 60 degrees from the axis is 30 degrees from the surface.
        let rise = 30.0_f64.to_radians().tan();
        let face = Profile::new(&cone, 1.0).at(2.0);
        approx::assert_relative_eq!(face.height, 2.0 * rise, max_relative = 1e-14);
        let rounded = IndenterParameters { edge_radius: 5.0, ..Default::default() };
        let face = Profile::new(&rounded, 12.0);
        assert_eq!(face.at(7.0).height, 0.0);
        approx::assert_relative_eq!(face.at(10.0).height, 1.0, max_relative = 1e-15);
    }
}
