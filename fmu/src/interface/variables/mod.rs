//! The one table of variables: names, units, ranges, starts, descriptions, bounds for identification.
//!
//! The FMU's value references, `modelDescription.xml`, the command line, files and reports all
//! come from [`table`]. To add a variable, add one entry in `table.rs`.

mod enumerations;
pub mod history;
pub mod ports;
mod row;
pub mod sensitivities;
mod settings;
mod table;

pub use crate::unit::Unit;
pub use settings::{BRANCHES, ProtocolSource, Readings, Settings, SettingsError};

use crate::ForceSensitivity;
use crate::effect::EffectParameters;

/// Role of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set before the simulation, fixed afterwards.
    Parameter,
    /// Set by the master at every communication point.
    Input,
    /// Computed.
    Output,
}

/// How a variable may change in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Not after initialisation.
    Fixed,
    /// At communication points only.
    Discrete,
    /// At any time.
    Continuous,
}

/// A value of one of the FMI types (enumerations are integers).
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Real.
    Real(f64),
    /// Integer, or 1-based item of an enumeration.
    Integer(i32),
    /// Boolean.
    Boolean(bool),
    /// String.
    Text(String),
    /// Size of an array.
    Count(u64),
}

impl Value {
    /// Name of its type.
    pub(crate) fn type_name(&self) -> &'static str {
        match self {
            Self::Real(_) => "Real",
            Self::Integer(_) => "Integer",
            Self::Boolean(_) => "Boolean",
            Self::Text(_) => "String",
            Self::Count(_) => "UInt64",
        }
    }
}

/// Named values, numbered from 1.
#[derive(Debug, PartialEq, Eq)]
pub struct Enumeration {
    /// Name of the type.
    pub name: &'static str,
    /// Name and description of each item.
    pub items: &'static [(&'static str, &'static str)],
}

impl Enumeration {
    /// Number of the item called `name`.
    pub fn value_of(&self, name: &str) -> Option<i32> {
        self.items.iter().zip(1..).find(|((item, _), _)| *item == name).map(|(_, value)| value)
    }
}

/// Type of a variable with its admissible range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// Real, in SI units.
    Real {
        /// Unit.
        unit: &'static Unit,
        /// Admissible range, where there is one.
        range: Option<(f64, f64)>,
    },
    /// Integer.
    Integer {
        /// Admissible range, where there is one.
        range: Option<(i32, i32)>,
    },
    /// Boolean.
    Boolean,
    /// String.
    Text,
    /// Enumeration.
    Enumeration(&'static Enumeration),
}

/// How identification treats a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Identification {
    /// Lower bound (the paper's Table 1) (SI).
    pub lower: f64,
    /// Upper bound (the paper's Table 1) (SI).
    pub upper: f64,
    /// Fitted unless the user says otherwise.
    pub free: bool,
}

/// Where a variable lives: readers and, for parameters and inputs, writers.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Binding {
    Real(fn(&Settings) -> f64, fn(&mut Settings, f64)),
    Integer(fn(&Settings) -> i32, fn(&mut Settings, i32)),
    Boolean(fn(&Settings) -> bool, fn(&mut Settings, bool)),
    Text(fn(&Settings) -> &str, fn(&mut Settings, String)),
    /// Number of an item of the enumeration with this place among all.
    Number(usize),
    EffectReal(fn(&EffectParameters) -> f64, fn(&mut EffectParameters, f64)),
    EffectFlag(fn(&EffectParameters) -> bool, fn(&mut EffectParameters, bool)),
    RealOutput(fn(&Readings) -> f64),
    /// Derivative of a force by the parameter at this place: the material's, then the magnitudes of effects.
    Sensitivity(fn(&ForceSensitivity) -> f64, usize),
    IntegerOutput(fn(&Readings) -> i32),
}

/// One row of the table.
#[derive(Debug, Clone, Copy)]
pub struct Variable {
    /// Name, the same in library, FMU, command line and files.
    pub name: &'static str,
    /// What it is, for a person.
    pub description: &'static str,
    /// Role.
    pub causality: Causality,
    /// How it may change.
    pub variability: Variability,
    /// Type, unit, range.
    pub kind: Kind,
    /// Set for material parameters that `identify` can fit.
    pub identification: Option<Identification>,
    binding: Binding,
}

/// Why a value was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VariableError {
    /// No such variable.
    #[error("there is no variable with value reference {0}")]
    Unknown(u32),
    /// Another type was asked for.
    #[error("{name} is not of type {asked}")]
    WrongType {
        /// Name.
        name: String,
        /// Type asked for.
        asked: &'static str,
    },
    /// An array with fewer values than it has elements.
    #[error("{name} has more elements than there are values")]
    TooFew {
        /// Name.
        name: String,
    },
    /// Values that belong to no variable.
    #[error("{given} values for {elements} elements")]
    Count {
        /// Values of the call.
        given: usize,
        /// Elements of its variables.
        elements: usize,
    },
    /// Outputs cannot be set.
    #[error("{0} is an output and cannot be set")]
    ReadOnly(String),
    /// Not a finite number.
    #[error("{name} = {value} is not a finite number")]
    NotFinite {
        /// Name.
        name: String,
        /// Offending value.
        value: f64,
    },
    /// Outside the admissible range.
    #[error("{name} = {value} is outside [{min}, {max}] {unit}")]
    OutOfRange {
        /// Name.
        name: String,
        /// Offending value.
        value: f64,
        /// Smallest admissible value.
        min: f64,
        /// Largest admissible value.
        max: f64,
        /// SI unit, empty for integers.
        unit: &'static str,
    },
}

impl Variable {
    /// The present value.
    pub fn get(&self, settings: &Settings, readings: &Readings) -> Value {
        match self.binding {
            Binding::Real(get, _) => Value::Real(get(settings)),
            Binding::Integer(get, _) => Value::Integer(get(settings)),
            Binding::Boolean(get, _) => Value::Boolean(get(settings)),
            Binding::Text(get, _) => Value::Text(get(settings).to_owned()),
            Binding::EffectReal(get, _) => Value::Real(get(&settings.padded.effect)),
            Binding::EffectFlag(get, _) => Value::Boolean(get(&settings.padded.effect)),
            Binding::Number(choice) => Value::Integer(settings.numbers[choice]),
            Binding::RealOutput(get) => Value::Real(get(readings)),
            Binding::Sensitivity(get, parameter) => Value::Real(get(&readings.sensitivities[parameter])),
            Binding::IntegerOutput(get) => Value::Integer(get(readings)),
        }
    }

    /// Sets a parameter or an input.
    ///
    /// # Errors
    /// When the variable is an output, the type is another one, or the value is not admissible;
    /// the settings are then unchanged.
    pub fn set(&self, settings: &mut Settings, value: Value) -> Result<(), VariableError> {
        self.check(&value)?;
        match (self.binding, value) {
            (Binding::Real(_, set), Value::Real(v)) => set(settings, v),
            (Binding::Integer(_, set), Value::Integer(v)) => set(settings, v),
            (Binding::Boolean(_, set), Value::Boolean(v)) => set(settings, v),
            (Binding::Text(_, set), Value::Text(v)) => set(settings, v),
            (Binding::EffectReal(_, set), Value::Real(v)) => set(&mut settings.padded.effect, v),
            (Binding::EffectFlag(_, set), Value::Boolean(v)) => set(&mut settings.padded.effect, v),
            (Binding::Number(choice), Value::Integer(v)) => settings.numbers[choice] = v,
            (Binding::RealOutput(_) | Binding::Sensitivity(..) | Binding::IntegerOutput(_), _) => {
                return Err(VariableError::ReadOnly(self.name.to_owned()));
            }
            (_, value) => return Err(self.wrong_type(&value)),
        }
        Ok(())
    }

    /// Start value: that of `Parameters::default()`; outputs start at rest.
    pub fn start(&self) -> Value {
        self.get(&Settings::default(), &Readings::default())
    }

    /// The start value as a number (Booleans: 0 or 1; texts are none).
    pub fn start_number(&self) -> f64 {
        match self.start() {
            Value::Real(v) => v,
            Value::Integer(v) => f64::from(v),
            Value::Boolean(v) => f64::from(u8::from(v)),
            Value::Text(_) => f64::NAN,
            Value::Count(v) => v as f64,
        }
    }

    /// Usual size of a Real (SI), never 0: the start value of a parameter, or what its unit usually measures.
    pub fn nominal(&self) -> f64 {
        let usual = self.unit().map_or(1.0, |unit| unit.nominal);
        match self.binding {
            Binding::Sensitivity(..) => sensitivities::parameter_of(self.name)
                .and_then(by_name)
                .map_or(usual, |(_, p)| crate::unit::NEWTON.nominal / p.nominal()),
            _ if self.start_number() != 0.0 => self.start_number().abs(),
            _ => usual,
        }
    }

    /// Unit of a Real.
    pub fn unit(&self) -> Option<&'static Unit> {
        match self.kind {
            Kind::Real { unit, .. } => Some(unit),
            _ => None,
        }
    }

    fn check(&self, value: &Value) -> Result<(), VariableError> {
        let (number, (min, max), unit) = match (self.kind, value) {
            (Kind::Real { .. }, &Value::Real(v)) if !v.is_finite() => {
                return Err(VariableError::NotFinite { name: self.name.to_owned(), value: v });
            }
            (Kind::Real { unit, range: Some(range) }, &Value::Real(v)) => (v, range, unit.symbol),
            (Kind::Integer { range: Some((min, max)) }, &Value::Integer(v)) => {
                (f64::from(v), (f64::from(min), f64::from(max)), "")
            }
            (Kind::Enumeration(e), &Value::Integer(v)) => (f64::from(v), (1.0, e.items.len() as f64), ""),
            _ => return Ok(()),
        };
        if (min..=max).contains(&number) {
            return Ok(());
        }
        Err(VariableError::OutOfRange { name: self.name.to_owned(), value: number, min, max, unit })
    }

    pub(crate) fn wrong_type(&self, asked: &Value) -> VariableError {
        VariableError::WrongType { name: self.name.to_owned(), asked: asked.type_name() }
    }
}

/// All variables; the index is the FMI value reference.
pub fn table() -> &'static [Variable] {
    &table::TABLE
}

/// Value reference and variable called `name`.
pub fn by_name(name: &str) -> Option<(u32, &'static Variable)> {
    (0..).zip(table()).find(|(_, variable)| variable.name == name)
}

/// Variable with a value reference.
///
/// # Errors
/// When there is none.
pub fn by_reference(reference: u32) -> Result<&'static Variable, VariableError> {
    table().get(reference as usize).ok_or(VariableError::Unknown(reference))
}

/// The parameters that `identify` can fit, in the table's order.
pub fn identifiable() -> impl Iterator<Item = (&'static Variable, Identification)> {
    table().iter().filter_map(|variable| Some((variable, variable.identification?)))
}
