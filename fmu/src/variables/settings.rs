//! What the variables are bound to: everything settable, and everything readable.

use crate::parameters::{BranchParameters, OgdenParameters};
use crate::protocol::Trapezoid;
use crate::{Outputs, Parameters, Statistics};
use serde::{Deserialize, Serialize};

/// Viscous branches that have variables. A branch with `mu = 0` is absent.
pub const BRANCHES: usize = 4;

/// An unused branch: `mu = 0`; alpha and eta are what a user starts from when switching it on.
const ABSENT: BranchParameters =
    BranchParameters { ogden: OgdenParameters { mu: 0.0, alpha: -3.0 }, eta: 1e3 };

/// Where the punch's displacement comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ProtocolSource {
    /// The inputs `displacement` and `displacement_rate`.
    #[default]
    Inputs,
    /// The built-in trapezoid, from its parameters.
    Trapezoid,
}

/// Everything that can be set by name: parameters and inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Always holds [`BRANCHES`] branches; see [`Settings::parameters`].
    pub(super) padded: Parameters,
    /// Where the displacement comes from.
    pub source: ProtocolSource,
    /// The built-in protocol.
    pub trapezoid: Trapezoid,
    /// Input: displacement of the punch (m).
    pub displacement: f64,
    /// Input: velocity of the punch (m/s).
    pub displacement_rate: f64,
}

impl Default for Settings {
    fn default() -> Self {
        let mut padded = Parameters::default();
        padded.material.branches.resize(BRANCHES, ABSENT);
        Self {
            padded,
            source: ProtocolSource::default(),
            trapezoid: Trapezoid::default(),
            displacement: 0.0,
            displacement_rate: 0.0,
        }
    }
}

impl Settings {
    /// The model's parameters, without the absent branches.
    pub fn parameters(&self) -> Parameters {
        let mut parameters = self.padded.clone();
        parameters.material.branches.retain(|branch| branch.ogden.mu != 0.0);
        parameters
    }

    pub(super) fn branch<const I: usize>(&self) -> &BranchParameters {
        &self.padded.material.branches[I]
    }

    pub(super) fn branch_mut<const I: usize>(&mut self) -> &mut BranchParameters {
        &mut self.padded.material.branches[I]
    }
}

/// Everything that can be read by name, besides the settings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Readings {
    /// Results.
    pub outputs: Outputs,
    /// Solver statistics.
    pub statistics: Statistics,
}
