//! What the laws of Table 1 leave out.

use super::softening::Softening;

/// Extensions of the laws; the default extends nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extensions {
    /// Factor on all stresses of the skeleton; the permeability is divided by it [-].
    pub amplitude: f64,
    /// Rate r at which moduli and viscosities grow with the time t since the test's start, `exp(r t)` (1/s).
    pub growth_rate: f64,
    /// `1 / tau_0` of Eyring flow (1/Pa); 0: linear dashpots.
    pub inverse_stress: f64,
    /// Exponent of the permeability's dependence on the pore volume [-].
    pub permeability_exponent: f64,
    /// Softening with past strain, where it acts.
    pub softening: Option<Softening>,
}

impl Default for Extensions {
    fn default() -> Self {
        Self {
            amplitude: 1.0,
            growth_rate: 0.0,
            inverse_stress: 0.0,
            permeability_exponent: 0.0,
            softening: None,
        }
    }
}

impl Extensions {
    /// Factor on the moduli at `time` (s) since the test's start; exactly 1 without growth.
    pub fn growth(&self, time: f64) -> f64 {
        (self.growth_rate * time).exp()
    }
}
