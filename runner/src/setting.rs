//! `name=value[unit]`: how people give parameters, checked against the FMU's description.

use crate::fmi::{Range, ScalarVariable, VariableKind};
use crate::pool::Wiring;
use crate::units::{Unit, UnitError, parse_quantity};
use std::collections::BTreeMap;
use thiserror::Error;

/// A setting that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SettingError {
    /// No equals sign.
    #[error("`{0}` is not of the form NAME=VALUE")]
    NotAnAssignment(String),
    /// No such parameter.
    #[error("the FMU has no parameter `{name}`{hint}")]
    NoSuchParameter {
        /// As written.
        name: String,
        /// What might have been meant.
        hint: String,
    },
    /// A number or unit.
    #[error("{name}: {source}")]
    Unit {
        /// Name of the parameter.
        name: String,
        /// Reason.
        source: UnitError,
    },
    /// A number that may mean two things.
    #[error("{name}: `{value}` has no unit; write for example {name}={value}{example}")]
    NoUnit {
        /// Name of the parameter.
        name: String,
        /// As written.
        value: String,
        /// A unit that would be understood.
        example: String,
    },
    /// A text, which is no number.
    #[error("{name} is a text and cannot be set as a number; fields are written by `simulate --fields PATH`")]
    Text {
        /// Name of the parameter.
        name: String,
    },
    /// Neither true nor false.
    #[error("{name}: `{value}` is neither true nor false")]
    NotABoolean {
        /// Name of the parameter.
        name: String,
        /// As written.
        value: String,
    },
    /// Not a whole number.
    #[error("{name}: `{value}` is not a whole number")]
    NotAnInteger {
        /// Name of the parameter.
        name: String,
        /// As written.
        value: String,
    },
    /// Not one of the items.
    #[error("{name}: `{value}` is not one of {items}")]
    NotAnItem {
        /// Name of the parameter.
        name: String,
        /// As written.
        value: String,
        /// What there is.
        items: String,
    },
    /// Outside the admissible range.
    #[error("{name} = {value}{unit} is outside its bounds [{min}, {max}]{unit}")]
    OutOfRange {
        /// Name of the parameter.
        name: String,
        /// Offending value.
        value: f64,
        /// Smallest admissible value.
        min: f64,
        /// Largest admissible value.
        max: f64,
        /// Unit of the three, after a space; empty for pure numbers.
        unit: String,
    },
}

/// `name=value` into its halves.
pub fn split_assignment(text: &str) -> Option<(&str, &str)> {
    text.split_once('=').map(|(name, value)| (name.trim(), value.trim()))
}

/// The parameter called `name`.
///
/// # Errors
/// When there is none; with the most similar names.
pub fn variable_named<'a>(wiring: &'a Wiring, name: &str) -> Result<&'a ScalarVariable, SettingError> {
    wiring.parameters.get(name).ok_or_else(|| {
        let mut similar: Vec<(f64, &String)> =
            wiring.parameters.keys().map(|k| (strsim::jaro_winkler(k, name), k)).collect();
        similar.sort_by(|a, b| b.0.total_cmp(&a.0));
        let best: Vec<&str> = similar.iter().filter(|s| s.0 > 0.7).take(3).map(|s| s.1.as_str()).collect();
        let hint = match best.is_empty() {
            true => "; `runner simulate --help` lists them".to_owned(),
            false => format!("; did you mean {}?", best.join(" or ")),
        };
        SettingError::NoSuchParameter { name: name.to_owned(), hint }
    })
}

/// `NAME=VALUE UNIT` as it is read, of a value in the FMU's unit.
pub fn written(wiring: &Wiring, name: &str, value: f64) -> String {
    let unit = wiring.parameters.get(name).and_then(|v| v.unit.as_deref()).unwrap_or_default();
    format!("{name}={value} {unit}").trim_end().to_owned()
}

/// A value for a variable, in the FMU's unit. Where the variable has a unit, the value needs one (0 is 0 in all of them).
///
/// # Errors
/// When it cannot be read, has no unit or is not admissible.
pub fn number_in(variable: &ScalarVariable, text: &str) -> Result<f64, SettingError> {
    let text = text.trim();
    let (name, value) = (variable.name.clone(), text.to_owned());
    let number = match variable.kind {
        VariableKind::Boolean => match text.to_lowercase().as_str() {
            "true" | "1" | "yes" | "on" => 1.0,
            "false" | "0" | "no" | "off" => 0.0,
            _ => return Err(SettingError::NotABoolean { name, value }),
        },
        VariableKind::Enumeration => {
            let items = &variable.items;
            let item = items.iter().find(|(item, _)| item.eq_ignore_ascii_case(text));
            let by_number = || text.parse::<i32>().ok().filter(|n| items.iter().any(|(_, v)| v == n));
            item.map(|(_, v)| *v).or_else(by_number).map(f64::from).ok_or_else(|| {
                let items: Vec<&str> = items.iter().map(|(item, _)| item.as_str()).collect();
                SettingError::NotAnItem { name, value, items: items.join(", ") }
            })?
        }
        VariableKind::Integer => {
            let integer = text.parse::<i32>().map_err(|_| SettingError::NotAnInteger { name, value })?;
            f64::from(integer)
        }
        VariableKind::Real => real_in(variable, text)?,
        VariableKind::String => return Err(SettingError::Text { name }),
    };
    admissible(variable, number)
}

/// A value in the FMU's unit, where the variable may have it.
///
/// # Errors
/// When it is outside the variable's bounds, or no number.
pub fn admissible(variable: &ScalarVariable, number: f64) -> Result<f64, SettingError> {
    if variable.range.contains(number) {
        return Ok(number);
    }
    let Range { min, max } = variable.range;
    let unit = variable.unit.iter().filter(|u| *u != "1").map(|u| format!(" {u}")).collect();
    Err(SettingError::OutOfRange { name: variable.name.clone(), value: number, min, max, unit })
}

/// A change of a variable, as [`number_in`] reads a value; what a value may not be, a change may.
///
/// # Errors
/// When it cannot be read or has no unit.
pub fn change_in(variable: &ScalarVariable, text: &str) -> Result<f64, SettingError> {
    match variable.kind {
        VariableKind::Real => real_in(variable, text.trim()),
        _ => number_in(variable, text),
    }
}

fn real_in(variable: &ScalarVariable, text: &str) -> Result<f64, SettingError> {
    let name = || variable.name.clone();
    let own = variable.unit.as_deref().filter(|unit| *unit != "1");
    let unit = variable.unit.as_deref().and_then(Unit::parse);
    match (text.parse::<f64>().ok().filter(|v| v.is_finite()), own) {
        (Some(value), Some(_)) if value != 0.0 => {
            let example = variable.display_unit.as_deref().or(own).map(behind_number).unwrap_or_default();
            let example = example.to_owned();
            return Err(SettingError::NoUnit { name: name(), value: text.to_owned(), example });
        }
        (Some(value), _) => return Ok(value),
        _ => {}
    }
    // Units that the FMU itself names need no table.
    let display = variable.display_unit.as_deref().map(|unit| (unit, variable.display_factor));
    for (symbol, factor) in display.into_iter().chain(own.map(|unit| (unit, 1.0))) {
        if let Some(value) = number_before(symbol, text) {
            return Ok(value / factor);
        }
    }
    let wrong = |source| SettingError::Unit { name: name(), source };
    let si = parse_quantity(text, unit.map(|u| u.dimension)).map_err(wrong)?;
    Ok(unit.map_or(si, |u| si / u.factor))
}

/// A unit as it stands behind a number: of `1/kPa` the rest, as `11/kPa` is eleven.
fn behind_number(unit: &str) -> &str {
    unit.strip_prefix('1').filter(|per| per.starts_with('/')).unwrap_or(unit)
}

/// The number in front of a unit; none where something else stands there.
fn number_before(unit: &str, text: &str) -> Option<f64> {
    let apart = |number: &&str| number.ends_with(char::is_whitespace);
    let whole = text.strip_suffix(unit).filter(|number| behind_number(unit) == unit || apart(number));
    let number = whole.or_else(|| text.strip_suffix(behind_number(unit)))?;
    number.trim().parse::<f64>().ok().filter(|v| v.is_finite())
}

/// A value for people, as [`number_in`] reads it: in the display unit, items and truth by their names.
pub fn shown(variable: &ScalarVariable, value: f64) -> (String, String) {
    // Avoids 9.999999e-1 after the change of unit.
    let short = |v: f64| {
        let rounded: f64 = format!("{v:.9e}").parse().unwrap_or(v);
        let plain = rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs());
        if plain { format!("{rounded}") } else { format!("{rounded:e}") }
    };
    let unit = |unit: &Option<String>| unit.clone().filter(|u| u != "1").unwrap_or_default();
    match variable.kind {
        VariableKind::Boolean => ((value != 0.0).to_string(), String::new()),
        VariableKind::Enumeration => {
            let item = variable.items.iter().find(|(_, number)| f64::from(*number) == value);
            (item.map_or_else(|| short(value), |(name, _)| name.clone()), String::new())
        }
        _ if variable.display_unit.is_some() => {
            (short(value * variable.display_factor), unit(&variable.display_unit))
        }
        _ => (short(value), unit(&variable.unit)),
    }
}

/// Values of several `NAME=VALUE[UNIT]`, in the FMU's units. A later one overrides an earlier one.
///
/// # Errors
/// The first that cannot be used.
pub fn settings_from(wiring: &Wiring, texts: &[String]) -> Result<BTreeMap<String, f64>, SettingError> {
    let one =
        |text: &String| assignment(wiring, text).map(|(variable, value)| (variable.name.clone(), value));
    texts.iter().map(one).collect()
}

/// The variable and the value of one `NAME=VALUE[UNIT]`.
///
/// # Errors
/// As [`settings_from`].
pub fn assignment<'a>(wiring: &'a Wiring, text: &str) -> Result<(&'a ScalarVariable, f64), SettingError> {
    let (name, value) =
        split_assignment(text).ok_or_else(|| SettingError::NotAnAssignment(text.to_owned()))?;
    let variable = variable_named(wiring, name)?;
    Ok((variable, number_in(variable, value)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::Fmu;
    use crate::pool::wiring::Names;

    /// The one of `1/kPa` is no digit of the number, nor is the last digit of the number that one.
    #[test]
    fn a_number_per_something_is_read_whole() {
        let fmu = Fmu::builtin().unwrap();
        let wiring = Wiring::new(fmu.description(), &Names::default()).unwrap();
        let read = |value: &str| {
            let text = format!("effect.eyring.inverse_stress={value}");
            settings_from(&wiring, &[text]).map(|found| found["effect.eyring.inverse_stress"])
        };
        for (text, per_kpa) in
            [("11/kPa", 11.0), ("4 1/kPa", 4.0), ("4/kPa", 4.0), ("1/kPa", 1.0), ("1 1/kPa", 1.0)]
        {
            approx::assert_relative_eq!(read(text).unwrap(), 1e-3 * per_kpa);
        }
        approx::assert_relative_eq!(read("0.02/Pa").unwrap(), 0.02);
        let error = read("11").unwrap_err().to_string();
        assert!(error.contains("write for example effect.eyring.inverse_stress=11/kPa"), "{error}");
    }

    #[test]
    fn what_is_written_is_read_again() {
        let fmu = Fmu::builtin().unwrap();
        let wiring = Wiring::new(fmu.description(), &Names::default()).unwrap();
        for (name, variable) in &wiring.parameters {
            let Some(value) = variable.start_number().filter(|_| variable.kind != VariableKind::Boolean)
            else {
                continue;
            };
            let read = settings_from(&wiring, &[written(&wiring, name, value)]).unwrap();
            let error = (read[name] - value).abs();
            assert!(error <= 1e-12 * value.abs(), "{name}: {} for {value}", read[name]);
        }
    }
}
