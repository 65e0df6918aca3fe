//! What the variables are bound to: everything settable, and everything readable.

use super::history::History;
use super::{Binding, Causality, Kind, Variable, VariableError, table};
use crate::interface::recording::FieldSettings;
use crate::law::parameters::{BranchParameters, OgdenParameters};
use crate::law::{Magnitude, MaterialParameter, Spring};
use crate::motion::protocol::Trapezoid;
use crate::parameters::validate_branch;
use crate::{ForceSensitivity, Outputs, ParameterError, Parameters, Statistics};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Variables that are enumerations.
pub const CHOICES: usize = 7;

/// Viscous branches that have variables. A branch with `mu = 0` is absent.
pub const BRANCHES: usize = 4;

/// An unused branch: `mu = 0`; alpha and eta are what a user starts from when switching it on.
const ABSENT: BranchParameters =
    BranchParameters { ogden: OgdenParameters { mu: 0.0, alpha: -3.0 }, eta: 1e3 };

/// Where the punch's displacement comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ProtocolSource {
    /// The inputs `displacement` and `displacement_rate`.
    Inputs,
    /// The built-in trapezoid, from its parameters: a run without any setting gives a force.
    #[default]
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
    /// The user's own motion.
    pub history: History,
    /// Where fields are written.
    pub fields: FieldSettings,
    /// Numbers of the enumerations' items, in the table's order, where they were set as integers; else 0.
    pub(crate) numbers: [i32; CHOICES],
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
            history: History::default(),
            fields: FieldSettings::default(),
            numbers: [0; CHOICES],
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

    /// The settings with every enumeration at the item whose number was set.
    pub fn chosen(&self) -> Self {
        let mut chosen = self.clone();
        for (variable, &number) in enumerations().zip(&self.numbers).filter(|(_, number)| **number != 0) {
            if let Binding::Integer(_, set) = variable.binding {
                set(&mut chosen, number);
            }
        }
        chosen
    }

    /// Checks everything that can be set, however it came here: ranges, and the viscous branches by their
    /// numbers in the table.
    ///
    /// # Errors
    /// Names the first variable that is not admissible.
    pub fn validate(&self) -> Result<(), SettingsError> {
        if self.padded.material.branches.len() != BRANCHES {
            return Err(SettingsError::Branches);
        }
        let readings = Readings::default();
        for variable in table().iter().filter(|v| v.causality != Causality::Output) {
            variable.check(&variable.get(self, &readings))?;
        }
        self.history.validate()?;
        Ok(self.validate_branches()?)
    }

    /// Checks the viscous branches that are present; errors name them by their numbers in the table.
    ///
    /// # Errors
    /// Names the first that is not admissible.
    pub fn validate_branches(&self) -> Result<(), ParameterError> {
        let mut present = (1..).zip(&self.padded.material.branches).filter(|(_, b)| b.ogden.mu != 0.0);
        present.try_for_each(|(number, branch)| validate_branch(number, branch))
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
/// The same and the magnitudes of effects.
pub(super) const ALL_SENSITIVITIES: usize = SENSITIVITIES + Magnitude::ALL.len();

/// Everything that can be read by name, besides the settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Readings {
    /// Results.
    pub outputs: Outputs,
    /// Solver statistics.
    pub statistics: Statistics,
    /// Derivatives of the force by the material's parameters, 0 for those of an absent branch, then by the magnitudes of effects.
    pub sensitivities: [ForceSensitivity; ALL_SENSITIVITIES],
}

impl Default for Readings {
    fn default() -> Self {
        let sensitivities = [ForceSensitivity::default(); ALL_SENSITIVITIES];
        Self { outputs: Outputs::default(), statistics: Statistics::default(), sensitivities }
    }
}

impl Settings {
    /// Derivatives of a model of these settings, with zeros for the absent branches.
    pub fn spread(&self, present: &[ForceSensitivity]) -> [ForceSensitivity; ALL_SENSITIVITIES] {
        let mut all = [ForceSensitivity::default(); ALL_SENSITIVITIES];
        let is_present = |parameter| match parameter {
            MaterialParameter::Mu(Spring::Branch(b))
            | MaterialParameter::Alpha(Spring::Branch(b))
            | MaterialParameter::Eta(b) => self.padded.material.branches[b].ogden.mu != 0.0,
            _ => true,
        };
        let places = MaterialParameter::all(BRANCHES).filter(|&parameter| is_present(parameter));
        let places = places.map(MaterialParameter::index).chain(SENSITIVITIES..ALL_SENSITIVITIES);
        for (place, &derivative) in places.zip(present) {
            all[place] = derivative;
        }
        all
    }
}

/// The variables that are enumerations, in the table's order.
pub(super) fn enumerations() -> impl Iterator<Item = &'static Variable> {
    table().iter().filter(|variable| matches!(variable.kind, Kind::Enumeration(_)))
}

/// Settings that nobody could have set.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SettingsError {
    /// Another number of viscous branches than the table has.
    #[error("another number of viscous branches")]
    Branches,
    /// A history that is none.
    #[error("a displacement history without points, or with numbers that are none")]
    History,
    /// A value out of its range.
    #[error(transparent)]
    Variable(#[from] VariableError),
    /// A viscous branch.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::variables::{Value, by_name};

    /// Every enumeration has its integer twin, with the same items, at the place that its name says.
    #[test]
    fn a_number_chooses_the_item() {
        assert_eq!(enumerations().count(), CHOICES);
        for variable in enumerations() {
            let (_, twin) = by_name(&format!("{}_number", variable.name)).unwrap();
            let Kind::Enumeration(e) = variable.kind else { unreachable!() };
            assert_eq!(twin.kind, Kind::Integer { range: Some((0, e.items.len() as i32)) });
            for number in 1..=e.items.len() as i32 {
                let (mut by_number, mut by_item) = (Settings::default(), Settings::default());
                twin.set(&mut by_number, Value::Integer(number)).unwrap();
                variable.set(&mut by_item, Value::Integer(number)).unwrap();
                let chosen = Settings { numbers: [0; CHOICES], ..by_number.chosen() };
                assert_eq!(chosen, by_item, "{} = {number}", twin.name);
                assert_eq!(twin.get(&by_number, &Readings::default()), Value::Integer(number));
            }
        }
    }

    #[test]
    fn a_branch_is_named_by_its_number_in_the_table() {
        let mut settings = Settings::default();
        settings.padded.material.branches[3].ogden.mu = 1e9;
        let error = settings.validate_branches().unwrap_err().to_string();
        assert!(error.starts_with("material.branch[4]: mu = 1000000000 Pa"), "{error}");
    }

    #[test]
    fn settings_that_nobody_could_have_set_are_refused() {
        assert_eq!(Settings::default().validate(), Ok(()));
        let mut cycles = Settings::default();
        cycles.trapezoid.cycles = i32::MAX;
        assert!(
            cycles.validate().unwrap_err().to_string().starts_with("protocol.cycles = 2147483647 is outside")
        );
        let mut number = Settings::default();
        number.numbers[0] = -1;
        assert!(number.validate().is_err());
        let input = Settings { displacement: f64::NAN, ..Settings::default() };
        assert!(input.validate().is_err());
        let mut branches = Settings::default();
        branches.padded.material.branches.clear();
        assert_eq!(branches.validate(), Err(SettingsError::Branches));
    }

    #[test]
    fn derivatives_of_absent_branches_are_zero() {
        let mut settings = Settings::default();
        settings.padded.material.branches[0].ogden.mu = 0.0;
        let one = |force| ForceSensitivity { force, specimen: force, fluid: 0.0 };
        let count = MaterialParameter::count(1) + Magnitude::ALL.len();
        let present: Vec<_> = (1..=count).map(|k| one(k as f64)).collect();
        let all = settings.spread(&present);
        assert_eq!(all[MaterialParameter::Alpha(Spring::Equilibrium).index()].force, 6.0);
        assert_eq!(all[MaterialParameter::Mu(Spring::Branch(0)).index()].force, 0.0);
        assert_eq!(all[MaterialParameter::Mu(Spring::Branch(1)).index()].force, 7.0);
        assert_eq!(all[MaterialParameter::Eta(1).index()].force, 9.0);
        assert_eq!(all[MaterialParameter::Eta(2).index()].force, 0.0);
        assert_eq!(all[SENSITIVITIES..].iter().map(|s| s.force).collect::<Vec<_>>()[..2], [10.0, 11.0]);
    }
}
