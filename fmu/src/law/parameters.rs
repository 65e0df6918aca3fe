//! Parameters of the laws, in SI units; `default()` is Table 1 of the paper.

use serde::{Deserialize, Serialize};

/// One Ogden term: `beta_a = mu (ltilde_a^alpha - mean_b ltilde_b^alpha)` (Eqs. 8, 9).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OgdenParameters {
    /// Stress-like coefficient mu (Pa); has the sign of `alpha`.
    pub mu: f64,
    /// Exponent alpha [-].
    pub alpha: f64,
}

impl OgdenParameters {
    /// Shear modulus at small strain, `mu alpha / 2` (Pa).
    pub fn shear_modulus(&self) -> f64 {
        0.5 * self.mu * self.alpha
    }
}

/// One viscous branch: an Ogden spring in series with a dashpot (Eqs. 9, 12).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BranchParameters {
    /// The spring.
    pub ogden: OgdenParameters,
    /// Viscosity eta (Pa s).
    pub eta: f64,
}

impl BranchParameters {
    /// Relaxation time at small strain, `eta / (mu alpha / 2)` (s).
    pub fn relaxation_time(&self) -> f64 {
        self.eta / self.ogden.shear_modulus()
    }
}

/// Constitutive parameters of the biphasic solid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MaterialParameters {
    /// Initial solid volume fraction n0S [-].
    pub n0s: f64,
    /// Volumetric stiffness lambda* (Pa) (Eq. 10).
    pub lambda_star: f64,
    /// Dynamic viscosity of the pore fluid mu_FR (Pa s).
    pub fluid_viscosity: f64,
    /// Initial intrinsic permeability K0 (m^2).
    pub permeability: f64,
    /// Equilibrium response.
    pub equilibrium: OgdenParameters,
    /// Viscous branches, any number.
    pub branches: Vec<BranchParameters>,
}

impl MaterialParameters {
    /// Shear modulus at small strain before anything has relaxed, `sum mu alpha / 2` of all springs (Pa).
    pub fn instantaneous_shear_modulus(&self) -> f64 {
        self.equilibrium.shear_modulus() + self.branches.iter().map(|b| b.ogden.shear_modulus()).sum::<f64>()
    }
}

impl Default for MaterialParameters {
    fn default() -> Self {
        let branch = |mu, alpha, eta| BranchParameters { ogden: OgdenParameters { mu, alpha }, eta };
        Self {
            n0s: 0.032,
            lambda_star: 1e5,
            fluid_viscosity: 0.89e-3,
            permeability: 2.30e-15,
            equilibrium: OgdenParameters { mu: -217.0, alpha: -2.16 },
            branches: vec![branch(-418.0, -13.5, 50.6), branch(-161.0, -2.97, 4680.0)],
        }
    }
}
