//! What the variables are bound to: everything settable, and everything readable.

use crate::fields::FieldSettings;
use crate::law::parameters::{BranchParameters, OgdenParameters};
use crate::law::{MaterialParameter, Spring};
use crate::motion::protocol::Trapezoid;
use crate::{ForceSensitivity, Outputs, Parameters, Statistics};
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
    pub(crate) padded: Parameters,
    /// Where the displacement comes from.
    pub source: ProtocolSource,
    /// The built-in protocol.
    pub trapezoid: Trapezoid,
    /// Where fields are written.
    pub fields: FieldSettings,
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
            fields: FieldSettings::default(),
            displacement: 0.0,
            displacement_rate: 0.0,
        }
    }
}

impl Settings {
    /// Settings that hold these parameters, for reading them by name; absent branches have no place in them.
    pub(crate) fn padding(parameters: &Parameters) -> Self {
        Self { padded: parameters.clone(), ..Self::default() }
    }

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

/// Parameters of a material with all its [`BRANCHES`].
pub(super) const SENSITIVITIES: usize = MaterialParameter::count(BRANCHES);

/// Everything that can be read by name, besides the settings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Readings {
    /// Results.
    pub outputs: Outputs,
    /// Solver statistics.
    pub statistics: Statistics,
    /// Derivatives of the force by the material's parameters; 0 for those of an absent branch.
    pub sensitivities: [ForceSensitivity; SENSITIVITIES],
}

impl Settings {
    /// Derivatives of a model of these settings, with zeros for the absent branches.
    pub fn spread(&self, present: &[ForceSensitivity]) -> [ForceSensitivity; SENSITIVITIES] {
        let mut all = [ForceSensitivity::default(); SENSITIVITIES];
        let is_present = |parameter| match parameter {
            MaterialParameter::Mu(Spring::Branch(b))
            | MaterialParameter::Alpha(Spring::Branch(b))
            | MaterialParameter::Eta(b) => self.padded.material.branches[b].ogden.mu != 0.0,
            _ => true,
        };
        let places = MaterialParameter::all(BRANCHES).filter(|&parameter| is_present(parameter));
        for (parameter, &derivative) in places.zip(present) {
            all[parameter.index()] = derivative;
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_absent_branches_are_zero() {
        let mut settings = Settings::default();
        settings.padded.material.branches[0].ogden.mu = 0.0;
        let one = |force| ForceSensitivity { force, specimen: force, fluid: 0.0 };
        let present: Vec<_> = (1..=MaterialParameter::count(1)).map(|k| one(k as f64)).collect();
        let all = settings.spread(&present);
        assert_eq!(all[MaterialParameter::Alpha(Spring::Equilibrium).index()].force, 6.0);
        assert_eq!(all[MaterialParameter::Mu(Spring::Branch(0)).index()].force, 0.0);
        assert_eq!(all[MaterialParameter::Mu(Spring::Branch(1)).index()].force, 7.0);
        assert_eq!(all[MaterialParameter::Eta(1).index()].force, 9.0);
        assert_eq!(all[MaterialParameter::Eta(2).index()].force, 0.0);
    }
}
