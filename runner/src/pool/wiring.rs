//! Which variables of an FMU are the punch, the force and the parameters, and in which units.

use crate::fmi::{ModelDescription, ScalarVariable, VariableKind};
use crate::units::{Dimension, Unit};
use poropunch::variables::sensitivities;
use std::collections::BTreeMap;
use thiserror::Error;

/// A variable of the FMU with its factor to SI: `value_si = factor * value_fmu`.
#[derive(Debug, Clone, PartialEq)]
pub struct Port {
    /// Name in the FMU.
    pub name: String,
    /// FMI value reference.
    pub reference: u32,
    /// Multiplies the FMU's value to make it SI.
    pub factor: f64,
}

/// How the punch is moved within a communication step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    /// By the input's time derivative (`fmi2SetRealInputDerivatives`): exact for straight pieces.
    Derivative,
    /// By an input that is the velocity, with its factor to SI: exact for straight pieces.
    Rate {
        /// FMI value reference of the velocity.
        reference: u32,
        /// Multiplies the FMU's value to make it SI.
        factor: f64,
    },
    /// By small steps with the input held at its middle value: an approximation.
    Steps,
}

/// Everything needed to run a job on an FMU.
#[derive(Debug, Clone, PartialEq)]
pub struct Wiring {
    /// The displacement of the punch.
    pub input: Port,
    /// How it is driven.
    pub drive: Drive,
    /// Outputs to record, the force first.
    pub outputs: Vec<Port>,
    /// Place in `outputs` of the force's derivative by each parameter that has one.
    pub sensitivities: BTreeMap<String, usize>,
    /// Settable parameters by name.
    pub parameters: BTreeMap<String, ScalarVariable>,
    /// Texts that every run sets: value references and values. A run that writes files is one of these.
    pub texts: Vec<(u32, String)>,
}

/// What the user asked for, where it is not poropunch's own FMU.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Names {
    /// `NAME`, `NAME:UNIT` or `NAME:FACTOR` of the displacement; `displacement` when absent.
    pub input: Option<String>,
    /// The same for the force; `force` when absent.
    pub output: Option<String>,
    /// Further outputs to record; those that the FMU does not have are left out.
    pub extra: Vec<String>,
    /// Whether to record the derivatives of the force, where the FMU has them.
    pub sensitivities: bool,
    /// Texts that every run sets: names of parameters and values.
    pub texts: Vec<(String, String)>,
}

/// In [`Names::extra`]: every real output but the sensitivities.
pub const ALL: &str = "all";

/// Whether a wanted name means an output: its name, the beginning of it before a dot, or `all`.
pub fn asks_for(wanted: &str, output: &str) -> bool {
    let rest = output.strip_prefix(wanted);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        || (wanted == ALL && !output.starts_with(sensitivities::PREFIX))
}

/// An FMU that does not have what is needed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WiringError {
    /// No such variable.
    #[error("the FMU `{model}` has no {role} called `{name}`; it has {available} (choose with --{option})")]
    NoSuchVariable {
        /// Name of the model.
        model: String,
        /// Input, output.
        role: &'static str,
        /// Name looked for.
        name: String,
        /// What there is.
        available: String,
        /// Option of the command line.
        option: &'static str,
    },
    /// No such text.
    #[error("the FMU `{model}` has no text parameter `{name}`: only poropunch's own FMU writes fields")]
    NoSuchText {
        /// Name of the model.
        model: String,
        /// Name looked for.
        name: String,
    },
    /// A unit that is unknown or of another quantity.
    #[error(
        "unit `{unit}` of `{name}` is not a known unit of {expected:?}; write --{option} {name}:UNIT or {name}:FACTOR"
    )]
    Unit {
        /// Name of the variable.
        name: String,
        /// Unit found.
        unit: String,
        /// What it should measure.
        expected: Dimension,
        /// Option of the command line.
        option: &'static str,
    },
}

impl Wiring {
    /// Finds the variables in a description.
    ///
    /// # Errors
    /// When input or output are missing, or their unit is not understood.
    pub fn new(description: &ModelDescription, names: &Names) -> Result<Self, WiringError> {
        let input = find_port(description, names.input.as_deref(), Role::INPUT)?;
        let force = find_port(description, names.output.as_deref(), Role::OUTPUT)?;
        let mut outputs = vec![force];
        let mut extra = Vec::new();
        let real = description.variables.iter().filter(|v| v.kind == VariableKind::Real);
        for v in real.filter(|v| v.causality == "output" && v.name != outputs[0].name) {
            if names.extra.iter().any(|name| asks_for(name, &v.name)) {
                let factor = v.unit.as_deref().and_then(Unit::parse).map_or(1.0, |u| u.factor);
                extra.push(Port { name: v.name.clone(), reference: v.value_reference, factor });
            }
        }
        outputs.extend(extra);
        let drive = drive(description, &input);
        let settable = |v: &&ScalarVariable| v.causality == "parameter";
        let parameters = description.variables.iter().filter(settable);
        let parameters: BTreeMap<_, _> = parameters.map(|v| (v.name.clone(), v.clone())).collect();
        let mut found = BTreeMap::new();
        let switched = parameters.get(sensitivities::SWITCH).is_some_and(|v| v.kind == VariableKind::Boolean);
        // The magnitudes of effects have a switch of their own, which no run sets.
        let known = |name: &&String| names.sensitivities && switched && !sensitivities::is_of_effect(name);
        for parameter in parameters.keys().filter(known) {
            let name = sensitivities::name(&outputs[0].name, parameter);
            if let Some(v) = description.variables.iter().find(|v| v.name == name) {
                found.insert(parameter.clone(), outputs.len());
                let factor = outputs[0].factor;
                outputs.push(Port { name, reference: v.value_reference, factor });
            }
        }
        let text = |(name, value): &(String, String)| {
            let known = parameters.get(name).filter(|v| v.kind == VariableKind::String);
            let missing =
                || WiringError::NoSuchText { model: description.model_name.clone(), name: name.clone() };
            known.map(|v| (v.value_reference, value.clone())).ok_or_else(missing)
        };
        let texts = names.texts.iter().map(text).collect::<Result<_, _>>()?;
        Ok(Self { input, drive, outputs, sensitivities: found, parameters, texts })
    }

    /// What makes poropunch's FMU, which presses by a protocol of its own unless told otherwise, follow the input.
    pub fn follow_input(&self) -> Option<(&ScalarVariable, f64)> {
        let source = self.parameters.get("protocol.source")?;
        let (_, number) = source.items.iter().find(|(item, _)| item == "inputs")?;
        Some((source, f64::from(*number)))
    }

    /// What a run's result depends on besides the FMU and the job.
    pub fn identity(&self) -> String {
        format!("{:?} {:?} {:?} {:?}", self.input, self.drive, self.outputs, self.texts)
    }
}

struct Role {
    name: &'static str,
    default: &'static str,
    dimension: Dimension,
}

impl Role {
    const INPUT: Self = Self { name: "input", default: "displacement", dimension: Dimension::Length };
    const OUTPUT: Self = Self { name: "output", default: "force", dimension: Dimension::Force };
}

fn find_port(description: &ModelDescription, asked: Option<&str>, role: Role) -> Result<Port, WiringError> {
    let asked = asked.unwrap_or(role.default);
    let real = |v: &&ScalarVariable| v.causality == role.name && v.kind == VariableKind::Real;
    let candidates: Vec<&ScalarVariable> = description.variables.iter().filter(real).collect();
    // A name may hold colons itself, so the whole is tried first.
    let whole = candidates.iter().find(|v| v.name == asked).map(|v| (*v, None));
    let split = || {
        let (name, unit) = asked.rsplit_once(':')?;
        candidates.iter().find(|v| v.name == name).map(|v| (*v, Some(unit)))
    };
    let Some((variable, given)) = whole.or_else(split) else {
        let available: Vec<&str> = candidates.iter().map(|v| v.name.as_str()).collect();
        return Err(WiringError::NoSuchVariable {
            model: description.model_name.clone(),
            role: role.name,
            name: asked.to_owned(),
            available: if available.is_empty() { "none".into() } else { available.join(", ") },
            option: role.name,
        });
    };
    let factor = match given.or(variable.unit.as_deref()) {
        None => 1.0,
        Some(unit) => factor(unit, role.dimension).ok_or_else(|| WiringError::Unit {
            name: variable.name.clone(),
            unit: unit.to_owned(),
            expected: role.dimension,
            option: role.name,
        })?,
    };
    Ok(Port { name: variable.name.clone(), reference: variable.value_reference, factor })
}

fn factor(unit: &str, dimension: Dimension) -> Option<f64> {
    let number = unit.parse::<f64>().ok().filter(|f| f.is_finite() && *f != 0.0);
    number.or_else(|| Unit::parse(unit).filter(|u| u.dimension == dimension).map(|u| u.factor))
}

fn drive(description: &ModelDescription, input: &Port) -> Drive {
    if description.capabilities.interpolate_inputs {
        return Drive::Derivative;
    }
    let rate_name = format!("{}_rate", input.name);
    let rate = description.variables.iter().find(|v| v.name == rate_name && v.causality == "input");
    match rate {
        // A velocity without a unit of its own goes with the displacement's.
        Some(v) => {
            let unit = v.unit.as_deref().and_then(|u| factor(u, Dimension::Speed));
            Drive::Rate { reference: v.value_reference, factor: unit.unwrap_or(input.factor) }
        }
        None => Drive::Steps,
    }
}
