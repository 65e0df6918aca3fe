//! The same variables as FMI 3.0 offers them: rows of the table whose names differ in an index only are one array.
//!
//! `material.branch[1].mu` to `material.branch[4].mu` are the array `material.branch.mu`. Value references are those of
//! the table, an array's is that of its first row; what only arrays can hold follows behind the table.

use super::history::MOST_POINTS;
use super::sensitivities::PREFIX;
use super::settings::SENSITIVITIES;
use super::{
    Binding, Causality, Kind, Readings, Settings, Value, Variability, Variable, VariableError, table,
};

/// Structural parameter: number of points of the history.
pub const POINTS: &str = "protocol.points";

/// Forces whose derivatives are outputs: rows of the matrix.
const SENSITIVE: usize = 3;

/// Type of a variable in FMI 3.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BaseType {
    /// `Float64`.
    Float64,
    /// `Int32`.
    Int32,
    /// `Enumeration`: passed as an Int64.
    Enumeration,
    /// `UInt64`.
    UInt64,
    /// `Boolean`.
    Boolean,
    /// `String`.
    String,
}

impl BaseType {
    /// The name in `modelDescription.xml`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Float64 => "Float64",
            Self::Int32 => "Int32",
            Self::Enumeration => "Enumeration",
            Self::UInt64 => "UInt64",
            Self::Boolean => "Boolean",
            Self::String => "String",
        }
    }
}

/// A variable of FMI 3.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Port {
    /// A row of the table, or the array that begins with it.
    Row(u32),
    /// The independent variable (s).
    Time,
    /// Derivatives of the forces by the material's parameters: a matrix.
    Sensitivities,
    /// Number of points of the history.
    Points,
    /// Times of the history (s).
    HistoryTime,
    /// Displacements of the history (m).
    HistoryDisplacement,
}

/// What stands behind the table.
const SPECIAL: [Port; 5] =
    [Port::Time, Port::Sensitivities, Port::Points, Port::HistoryTime, Port::HistoryDisplacement];

/// A name without its index.
fn stem(name: &str) -> (&str, &str) {
    let head = name.split_once('[').map(|(head, rest)| (head, rest.split_once(']')));
    match head {
        Some((head, Some((_, tail)))) => (head, tail),
        _ => (name, ""),
    }
}

fn row(reference: u32) -> Option<&'static Variable> {
    table().get(reference as usize)
}

impl Port {
    /// All of them, in the order of their value references.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..table().len() as u32).map(Self::Row).filter(|port| port.is_offered()).chain(SPECIAL)
    }

    /// The variable with a value reference.
    ///
    /// # Errors
    /// When there is none.
    pub fn by_reference(reference: u32) -> Result<Self, VariableError> {
        let special = || SPECIAL.get((reference as usize).checked_sub(table().len())?).copied();
        let port = if row(reference).is_some() { Some(Self::Row(reference)) } else { special() };
        port.filter(|port| port.is_offered()).ok_or(VariableError::Unknown(reference))
    }

    /// The variable called `name`.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::all().find(|port| port.name() == name)
    }

    /// Its value reference.
    pub fn reference(self) -> u32 {
        match self {
            Self::Row(reference) => reference,
            special => {
                let place = SPECIAL.iter().position(|&port| port == special).unwrap_or_default();
                (table().len() + place) as u32
            }
        }
    }

    /// Not the integer twins of the enumerations, which every FMI 3.0 master can set, and not what an array holds.
    fn is_offered(self) -> bool {
        let Self::Row(reference) = self else { return true };
        let Some(variable) = row(reference) else { return false };
        !matches!(variable.binding, Binding::Number(_)) && self.rows().next() == Some(reference)
    }

    /// Rows of the table that are its elements, in their order.
    pub fn rows(self) -> impl Iterator<Item = u32> {
        let all = table().len() as u32;
        let (candidates, wanted) = match self {
            Self::Row(reference) => match row(reference).map(|variable| variable.name) {
                Some(name) if name.contains('[') => (0..all, Some(stem(name))),
                _ => (reference..reference + 1, None),
            },
            Self::Sensitivities => {
                let first = (0..all).find(|&r| row(r).is_some_and(|v| v.name.starts_with(PREFIX)));
                let first = first.unwrap_or_default();
                (first..first + (SENSITIVE * SENSITIVITIES) as u32, None)
            }
            _ => (0..0, None),
        };
        candidates
            .filter(move |&r| wanted.is_none_or(|wanted| row(r).is_some_and(|v| stem(v.name) == wanted)))
    }

    /// Whether it is an array.
    pub fn is_array(self) -> bool {
        match self {
            Self::Row(reference) => row(reference).is_some_and(|variable| variable.name.contains('[')),
            Self::Time | Self::Points => false,
            Self::Sensitivities | Self::HistoryTime | Self::HistoryDisplacement => true,
        }
    }

    /// Sizes of an array that nothing changes; empty for a scalar and for the history, which has [`POINTS`].
    pub fn shape(self) -> Vec<usize> {
        match self {
            Self::Sensitivities => vec![SENSITIVE, SENSITIVITIES],
            Self::Row(_) if self.is_array() => vec![self.rows().count()],
            _ => Vec::new(),
        }
    }

    /// Whether its size is [`POINTS`].
    pub fn is_history(self) -> bool {
        matches!(self, Self::HistoryTime | Self::HistoryDisplacement)
    }

    /// The row that it is, or that an array's elements are like.
    pub fn variable(self) -> Option<&'static Variable> {
        if let Self::Row(reference) = self { row(reference) } else { None }
    }

    /// Name.
    pub fn name(self) -> String {
        match self {
            Self::Row(_) => {
                let (head, tail) = stem(self.variable().map_or("", |variable| variable.name));
                format!("{head}{tail}")
            }
            Self::Time => "time".to_owned(),
            Self::Sensitivities => format!("{PREFIX}matrix"),
            Self::Points => POINTS.to_owned(),
            Self::HistoryTime => "protocol.history.time".to_owned(),
            Self::HistoryDisplacement => "protocol.history.displacement".to_owned(),
        }
    }

    /// What it is, for a person.
    pub fn description(self) -> String {
        let text = match self {
            Self::Row(_) => {
                let text = self.variable().map_or("", |variable| variable.description);
                return text.replace("viscous branch 1", "each viscous branch").replace("fmi2", "fmi3");
            }
            Self::Time => "Time",
            Self::Sensitivities => {
                "All other sensitivity.*.material.* as one matrix, in SI units: rows are force, force_solid and \
                 force_fluid, columns are n0s, lambda_star, fluid_viscosity, permeability, equilibrium.mu, \
                 equilibrium.alpha, then mu, alpha and eta of each viscous branch; 0 unless solver.sensitivities is set"
            }
            Self::Points => {
                "Points of protocol.history, set in configuration mode; from 2 on the punch follows the history instead \
                 of protocol.source"
            }
            Self::HistoryTime => {
                "Times of the punch's own displacement history since the start of the run, increasing"
            }
            Self::HistoryDisplacement => {
                "Displacements of the punch's own history: it moves at constant velocity from one to the next and rests \
                 after the last"
            }
        };
        text.to_owned()
    }

    /// Type.
    pub fn base_type(self) -> BaseType {
        match self.variable().map(|variable| variable.kind) {
            Some(Kind::Integer { .. }) => BaseType::Int32,
            Some(Kind::Boolean) => BaseType::Boolean,
            Some(Kind::Text) => BaseType::String,
            Some(Kind::Enumeration(_)) => BaseType::Enumeration,
            None if self == Self::Points => BaseType::UInt64,
            Some(Kind::Real { .. }) | None => BaseType::Float64,
        }
    }

    /// Role; the number of points is a structural parameter and the time the independent variable.
    pub fn causality(self) -> Causality {
        match self {
            Self::Row(_) => self.variable().map_or(Causality::Output, |variable| variable.causality),
            Self::Time | Self::Sensitivities => Causality::Output,
            Self::Points | Self::HistoryTime | Self::HistoryDisplacement => Causality::Parameter,
        }
    }

    /// How it may change.
    pub fn variability(self) -> Variability {
        match (self.variable(), self.causality()) {
            (Some(variable), _) => variable.variability,
            (None, Causality::Parameter) => Variability::Fixed,
            (None, _) => Variability::Continuous,
        }
    }

    /// What may be read, and the displacement be given, within a communication step.
    pub fn is_intermediate(self) -> bool {
        self.variability() == Variability::Continuous && self != Self::Time
    }

    /// Appends the present value or values; `time` is the independent variable's (s).
    pub fn read(self, settings: &Settings, readings: &Readings, time: f64, values: &mut Vec<Value>) {
        match self {
            Self::Time => values.push(Value::Real(time)),
            Self::Points => values.push(Value::Count(settings.history.points() as u64)),
            Self::HistoryTime => values.extend(settings.history.time.iter().map(|&v| Value::Real(v))),
            Self::HistoryDisplacement => {
                values.extend(settings.history.displacement.iter().map(|&v| Value::Real(v)));
            }
            Self::Row(_) | Self::Sensitivities => {
                values.extend(self.rows().filter_map(row).map(|variable| variable.get(settings, readings)));
            }
        }
    }

    /// Sets it to the first of `values`, which it takes away: as many as it has elements.
    ///
    /// # Errors
    /// When it cannot be set, there are too few values, or one of them is not admissible.
    pub fn write(
        self,
        settings: &mut Settings,
        values: &mut impl Iterator<Item = Value>,
    ) -> Result<(), VariableError> {
        let too_few = || VariableError::TooFew { name: self.name() };
        let mut next = || values.next().ok_or_else(too_few);
        match self {
            Self::Time | Self::Sensitivities => return Err(VariableError::ReadOnly(self.name())),
            Self::Points => match next()? {
                Value::Count(points) => settings.history.resize(points)?,
                value => return Err(wrong_type(self, &value)),
            },
            Self::Row(_) => {
                for variable in self.rows().filter_map(row) {
                    variable.set(settings, next()?)?;
                }
            }
            Self::HistoryTime | Self::HistoryDisplacement => {
                let mut numbers = Vec::with_capacity(settings.history.points());
                for _ in 0..settings.history.points() {
                    match next()? {
                        Value::Real(value) if value.is_finite() => numbers.push(value),
                        Value::Real(value) => {
                            return Err(VariableError::NotFinite { name: self.name(), value });
                        }
                        value => return Err(wrong_type(self, &value)),
                    }
                }
                let history = &mut settings.history;
                let place =
                    if self == Self::HistoryTime { &mut history.time } else { &mut history.displacement };
                *place = numbers;
            }
        }
        Ok(())
    }
}

fn wrong_type(port: Port, value: &Value) -> VariableError {
    VariableError::WrongType { name: port.name(), asked: value.type_name() }
}

/// Bounds of the number of points.
pub const POINTS_RANGE: (u64, u64) = (1, MOST_POINTS);

#[cfg(test)]
mod tests {
    use super::super::by_name;
    use super::*;

    #[test]
    fn every_row_is_in_one_scalar_or_array_but_the_twins() {
        let mut seen = vec![0; table().len()];
        for port in Port::all() {
            assert_eq!(Port::by_reference(port.reference()), Ok(port));
            assert_eq!(Port::by_name(&port.name()), Some(port));
            if port != Port::Sensitivities {
                port.rows().for_each(|r| seen[r as usize] += 1);
            }
        }
        for (variable, times) in table().iter().zip(seen) {
            let twin = matches!(variable.binding, Binding::Number(_));
            assert_eq!(times, usize::from(!twin), "{}", variable.name);
        }
        let second = by_name("material.branch[2].mu").unwrap().0;
        assert_eq!(Port::by_reference(second), Err(VariableError::Unknown(second)));
    }

    #[test]
    fn elements_of_an_array_are_alike() {
        for port in Port::all().filter(|port| matches!(port, Port::Row(_)) && port.is_array()) {
            let first = port.variable().unwrap();
            for variable in port.rows().filter_map(row) {
                assert_eq!(variable.kind, first.kind, "{}", variable.name);
                assert_eq!(variable.causality, first.causality);
            }
        }
        let mu = Port::by_name("material.branch.mu").unwrap();
        assert_eq!(mu.shape(), [4]);
        assert_eq!(mu.rows().map(|r| row(r).unwrap().name).nth(1), Some("material.branch[2].mu"));
        let names = ["sensitivity.force.material.n0s", "sensitivity.force_fluid.material.branch[4].eta"];
        let matrix: Vec<u32> = Port::Sensitivities.rows().collect();
        assert_eq!([matrix[0], matrix[53]], names.map(|name| by_name(name).unwrap().0));
    }
}
