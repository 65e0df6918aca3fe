//! What is pressed: geometry and material of the plain model.

use crate::error::MakerError;
use serde::{Deserialize, Serialize};

/// Sizes (m).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Geometry {
    /// Radius of the flat punch (m).
    pub punch_radius: f64,
    /// Radius of the sample (m).
    pub sample_radius: f64,
    /// Height of the sample (m).
    pub sample_height: f64,
}

/// An Ogden term, `tau_a = mu (q_a - mean q)`, `q_a = ltilde_a^alpha` (Eqs. 8, 9); `mu alpha / 2` is the shear modulus.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ogden {
    /// mu (Pa), with the sign of alpha.
    pub mu: f64,
    /// alpha [-].
    pub alpha: f64,
}

impl Ogden {
    /// Small-strain shear modulus (Pa).
    pub fn shear_modulus(&self) -> f64 {
        0.5 * self.mu * self.alpha
    }
}

/// A spring and a dashpot in series (Eqs. 9, 12).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Branch {
    /// The spring.
    pub spring: Ogden,
    /// Viscosity eta of the dashpot (Pa s).
    pub eta: f64,
}

impl Branch {
    /// Small-strain relaxation time `eta / (mu alpha / 2)` (s).
    pub fn relaxation_time(&self) -> f64 {
        self.eta / self.spring.shear_modulus()
    }
}

/// The plain model's material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Initial solid volume fraction n0S [-].
    pub solid_fraction: f64,
    /// Volumetric stiffness lambda* (Pa) (Eq. 10).
    pub lambda: f64,
    /// Viscosity of the pore fluid mu_FR (Pa s).
    pub fluid_viscosity: f64,
    /// Initial intrinsic permeability K0 (m^2) (Eq. 11).
    pub permeability: f64,
    /// Equilibrium response (Eq. 8).
    pub equilibrium: Ogden,
    /// Viscous branches, any number.
    pub branches: Vec<Branch>,
}

impl Material {
    /// The paper's Table 1.
    pub fn table1() -> Self {
        Self {
            solid_fraction: 0.032,
            lambda: 1e5,
            fluid_viscosity: 0.89e-3,
            permeability: 2.30e-15,
            equilibrium: Ogden { mu: -217.0, alpha: -2.16 },
            branches: vec![
                Branch { spring: Ogden { mu: -418.0, alpha: -13.5 }, eta: 50.6 },
                Branch { spring: Ogden { mu: -161.0, alpha: -2.97 }, eta: 4680.0 },
            ],
        }
    }

    /// All moduli and viscosities times a factor; the permeability so that all times stay.
    pub fn scale(&mut self, factor: f64) {
        self.lambda *= factor;
        self.permeability /= factor;
        self.equilibrium.mu *= factor;
        for b in &mut self.branches {
            b.spring.mu *= factor;
            b.eta *= factor;
        }
    }

    /// Shear modulus of a sudden deformation (Pa).
    pub fn instantaneous_modulus(&self) -> f64 {
        self.equilibrium.shear_modulus() + self.branches.iter().map(|b| b.spring.shear_modulus()).sum::<f64>()
    }
}

/// A geometry and a material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Specimen {
    /// Sizes.
    pub geometry: Geometry,
    /// Material.
    pub material: Material,
}

impl Specimen {
    /// The paper's meshed sample (10 x 10 mm, punch of 2 mm) of Table 1.
    pub fn table1() -> Self {
        let geometry = Geometry { punch_radius: 2e-3, sample_radius: 10e-3, sample_height: 10e-3 };
        Self { geometry, material: Material::table1() }
    }

    /// Refuses what has no physical sense.
    ///
    /// # Errors
    /// The first such parameter.
    pub fn check(&self) -> Result<(), MakerError> {
        let (g, m) = (&self.geometry, &self.material);
        let rules = [
            (g.punch_radius > 0.0, "the punch's radius is not positive"),
            (g.sample_radius > 1.05 * g.punch_radius, "the sample is no wider than the punch"),
            (g.sample_height > 0.0, "the sample's height is not positive"),
            ((0.0..1.0).contains(&m.solid_fraction), "the solid fraction is not within 0 and 1"),
            (m.lambda > 0.0, "lambda* is not positive"),
            (m.fluid_viscosity > 0.0, "the fluid's viscosity is not positive"),
            (m.permeability > 0.0, "the permeability is not positive"),
            (m.equilibrium.shear_modulus() > 0.0, "the equilibrium's shear modulus is not positive"),
            (
                m.branches.iter().all(|b| b.spring.shear_modulus() > 0.0),
                "a branch's shear modulus is not positive",
            ),
            (m.branches.iter().all(|b| b.eta > 0.0), "a branch's viscosity is not positive"),
        ];
        rules.into_iter().find(|r| !r.0).map_or(Ok(()), |r| Err(MakerError::Invalid(r.1)))
    }
}
