//! Closed forms of the indenters: force over shear modulus at a depth, for an incompressible sample.
//!
//! Whatever the face, the stiffness of a contact of radius a is that of a flat punch of this radius (Pharr, Oliver and
//! Brotzen 1992): `dF/dd = 8 G a kappa(a / h)`, with a(d) of the half-space (Sneddon 1965) and kappa of the layer (Hayes et al.
//! 1972). Undrained at the peak the sample is incompressible; drained it nearly is, as long as lambda* is large beside G.

use std::f64::consts::PI;

/// The face that is pressed into the sample; lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Face {
    /// A flat punch.
    Flat {
        /// Its radius.
        radius: f64,
    },
    /// A sphere on a shank.
    Sphere {
        /// Radius of the sphere.
        radius: f64,
        /// Radius of the shank: the largest contact.
        shank: f64,
    },
    /// A cone on a shank.
    Cone {
        /// Angle between axis and flank (rad).
        half_angle: f64,
        /// Radius of the shank.
        shank: f64,
    },
    /// A plate that covers the sample.
    Platen,
}

/// What is pressed into what; lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rig {
    /// The face.
    pub face: Face,
    /// Radius of the sample.
    pub sample_radius: f64,
    /// Height of the sample.
    pub sample_height: f64,
    /// Whether the face holds the surface radially.
    pub bonded_face: bool,
    /// Whether the support holds the sample radially.
    pub bonded_support: bool,
}

/// kappa of an incompressible layer, `1 + A r + B r^2 + C r^3` at r = a / h: A and B fitted to Hayes' integral equation (within
/// 2 % up to r = 1, 12 % at r = 3)
const LAYER: [f64; 2] = [1.12, 1.33];
/// ... and C of the squeezed thin film: `3 pi / 16` between two bonded faces,
const FILM: f64 = 3.0 * PI / 16.0;
/// a quarter of it where one face is smooth.
const ONE_SMOOTH: f64 = 0.25;
/// Points of the table of forces.
const POINTS: usize = 2000;

impl Rig {
    /// Radius of the contact at a depth (m).
    pub fn contact_radius(&self, depth: f64) -> f64 {
        match self.face {
            Face::Flat { radius } => radius,
            Face::Platen => self.sample_radius,
            Face::Cone { half_angle, shank } => (2.0 / PI * depth.max(0.0) * half_angle.tan()).min(shank),
            Face::Sphere { radius, shank } => (radius * sphere_contact(depth / radius)).min(shank),
        }
    }

    /// Stiffness over shear modulus (m) at a depth (m).
    pub fn stiffness(&self, depth: f64) -> f64 {
        let bonded = match (self.bonded_face, self.bonded_support) {
            (true, true) => 1.0,
            (false, false) => 0.0,
            _ => ONE_SMOOTH,
        };
        let slender = self.sample_radius / self.sample_height;
        // A plug between two plates (Gent and Lindley 1959): 3 G pi R^2 / h (1 + R^2 / (2 h^2)) bonded to both.
        let plug =
            |bonded: f64| 3.0 * PI * self.sample_radius * slender * (1.0 + 0.5 * bonded * slender * slender);
        if self.face == Face::Platen {
            return plug(bonded);
        }
        let a = self.contact_radius(depth);
        let r = a / self.sample_height;
        let layer = 8.0 * a * (1.0 + r * (LAYER[0] + r * (LAYER[1] + r * FILM * bonded.max(ONE_SMOOTH))));
        // A sample not much wider than the contact yields as a column, too.
        let covered = (a / self.sample_radius).powi(2);
        layer / (1.0 + covered * layer / plug(bonded.min(ONE_SMOOTH)))
    }

    /// Force over shear modulus (m^2) up to a depth (m).
    pub fn law(&self, deepest: f64) -> Law {
        // Even in the root of the depth: a sphere's stiffness begins with it.
        let depth = |k: usize| deepest * (k as f64 / POINTS as f64).powi(2);
        let mut table = vec![0.0];
        for k in 0..POINTS {
            let middle = 0.5 * (depth(k) + depth(k + 1));
            table.push(table[k] + (depth(k + 1) - depth(k)) * self.stiffness(middle));
        }
        Law { deepest, table }
    }
}

/// Force over shear modulus against depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Law {
    deepest: f64,
    table: Vec<f64>,
}

impl Law {
    /// Force over shear modulus (m^2) at a depth (m); none above the surface.
    pub fn at(&self, depth: f64) -> f64 {
        let place = (depth / self.deepest).clamp(0.0, 1.0).sqrt() * POINTS as f64;
        let k = (place as usize).min(POINTS - 1);
        // Between two entries the force is linear in the depth, the square of the place.
        let (from, to) = ((k * k) as f64, ((k + 1) * (k + 1)) as f64);
        let share = (place * place - from) / (to - from);
        self.table[k] + share * (self.table[k + 1] - self.table[k])
    }
}

/// Contact radius of a sphere at a depth, both over the sphere's radius: `d = a / 2 ln((1 + a) / (1 - a))` (Sneddon 1965).
fn sphere_contact(depth: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let a: f64 = 0.5 * (low + high);
        if a * a.atanh() < depth { low = a } else { high = a }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn half_space(face: Face) -> Rig {
        Rig { face, sample_radius: 1e3, sample_height: 1e3, bonded_face: false, bonded_support: true }
    }

    #[test]
    fn a_half_space_has_the_classical_forces() {
        let (d, r) = (1e-4, 2e-3);
        let force = |face| half_space(face).law(d).at(d);
        assert_relative_eq!(force(Face::Flat { radius: r }), 8.0 * r * d, max_relative = 1e-4);
        let hertz = 16.0 / 3.0 * 1.0_f64.sqrt() * d.powf(1.5);
        assert_relative_eq!(force(Face::Sphere { radius: 1.0, shank: 1.0 }), hertz, max_relative = 1e-3);
        // Deeper than Hertz: E* ((a^2 + R^2) / 2 ln((R + a) / (R - a)) - a R), E* = 4 G.
        let (a, r) = (0.8_f64, 1.0_f64);
        let log = ((r + a) / (r - a)).ln();
        let deep = half_space(Face::Sphere { radius: r, shank: r }).law(2.0).at(0.5 * a * log);
        assert_relative_eq!(deep, 4.0 * (0.5 * (a * a + r * r) * log - a * r), max_relative = 5e-3);
        let angle = PI / 3.0;
        let cone = 8.0 / PI * angle.tan() * d * d;
        assert_relative_eq!(force(Face::Cone { half_angle: angle, shank: 1.0 }), cone, max_relative = 1e-4);
    }

    #[test]
    fn a_layer_is_stiffer_as_hayes_found() {
        let flat = Rig {
            face: Face::Flat { radius: 1.0 },
            sample_radius: 1e4,
            sample_height: 5.0,
            bonded_face: false,
            bonded_support: true,
        };
        // kappa of `tests/analytical/layer.rs`.
        for (height, kappa) in [(10.0, 1.1260), (5.0, 1.2806), (2.5, 1.6837), (1.0, 3.6189)] {
            let rig = Rig { sample_height: height, ..flat };
            assert_relative_eq!(rig.stiffness(0.1), 8.0 * kappa, max_relative = 2e-2);
        }
    }

    #[test]
    fn a_plug_has_its_shape_factor() {
        let plug = Rig {
            face: Face::Platen,
            sample_radius: 2.0,
            sample_height: 1.0,
            bonded_face: true,
            bonded_support: true,
        };
        let smooth = Rig { bonded_face: false, bonded_support: false, ..plug };
        assert_relative_eq!(smooth.law(0.1).at(0.1), 3.0 * PI * 4.0 * 0.1, max_relative = 1e-6);
        assert_relative_eq!(plug.stiffness(0.1) / smooth.stiffness(0.1), 3.0, max_relative = 1e-12);
    }

    #[test]
    fn a_shank_ends_the_growth_of_the_contact() {
        let cone = half_space(Face::Cone { half_angle: PI / 4.0, shank: 1e-3 });
        assert_eq!(cone.contact_radius(1.0), 1e-3);
        assert_eq!(cone.law(1.0).at(-1.0), 0.0);
    }
}
