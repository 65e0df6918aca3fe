//! How finely a sharp edge of the punch is resolved: as finely as the mesh's preset says, but no finer than the edges of real punches
//! where a sharper one has no solution.
//!
//! Beside a sharp edge the strain grows without bound, and two laws give way there.
//! - *A skeleton that is weak in volume*: the law (Eq. 10) bears a mean tension of at most `lambda* (1 - n0S)`, so closer to the
//!   edge than a fraction of the punch's radius there is no equilibrium once lambda* is small beside the instantaneous shear modulus.
//! - *A face on which the sample slides*: it is drawn towards the axis and shortens along the face until, beside the edge, the
//!   surface wrinkles (a free surface does at a stretch of 0.54, Biot 1963), and an element that is small enough turns inside out.

use crate::Parameters;
use crate::mesh::parameters::MeshParameters;
use crate::mesh::presets;

impl Parameters {
    /// The mesh that the sample gets: the one asked for, its sharp edge resolved to at most 3 % of the punch's radius where the
    /// skeleton is weak or the face slides, unless `mesh.edge_size` says what is wanted.
    pub fn resolved_mesh(&self) -> MeshParameters {
        let mut mesh = self.mesh.clone();
        let radius = self.geometry.punch_radius;
        let sharp = self.indenter.is_plane() && !self.geometry.is_platen();
        let (preset, broken) = (presets::resolve(&mesh, radius).edge_size, BROKEN_EDGE * radius);
        if !sharp || mesh.edge_size != 0.0 || preset >= broken {
            return mesh;
        }
        let is_weak = self.material.lambda_star < WEAK_SKELETON * self.material.instantaneous_shear_modulus();
        let asked = if is_weak { broken } else { EDGE_OVER_SLIDING_LENGTH * self.sliding_length() };
        // In steps of two, so that a fit whose modulus changes does not ask for ever new meshes.
        let mut size = preset;
        while size < asked.min(broken) {
            size *= 2.0;
        }
        if size > preset {
            mesh.edge_size = size.min(broken);
        }
        mesh
    }

    /// How far the face lets the sample slide under a shear of its instantaneous modulus (m).
    fn sliding_length(&self) -> f64 {
        let boundary = &self.boundary;
        let is_held = boundary.bonded_punch && !(boundary.partial_slip && boundary.friction < WEAK_FRICTION);
        if is_held {
            self.effect.slip.compliance * self.material.instantaneous_shear_modulus()
        } else {
            f64::INFINITY
        }
    }
}

/// Radius of a broken edge over the punch's: 60 um of 2 mm.
const BROKEN_EDGE: f64 = 0.03;
/// A skeleton is weak in volume where lambda* is below this many instantaneous shear moduli (Poisson's ratio below 0.2). Measured, not
/// derived: with edges of 0.003 R runs fail up to here and not beyond, with 0.01 R none does (README of `fmu`).
const WEAK_SKELETON: f64 = 1.3;
/// Size of the element at an edge over the length by which a compliant face slides. Measured: with edges of 0.003 R runs complete at 1.9
/// and fail at 0.6, with 0.01 R they complete at 0.2 (README of `fmu`).
const EDGE_OVER_SLIDING_LENGTH: f64 = 2.0;
/// Friction below which a face that nothing else holds is as good as frictionless. Measured: with edges of 0.003 R runs fail with
/// 0.05 and complete with 0.1 (README of `fmu`).
const WEAK_FRICTION: f64 = 0.1;
