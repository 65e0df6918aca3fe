//! Effects that the user declares, of any FMU: `NAME=PARAMETER:NULL:SCALE`.

use super::catalogue::largest_within;
use crate::fmi::{ScalarVariable, VariableKind};
use crate::inference::effect::{Effect, Place, Scope, Sign};
use crate::pool::Wiring;
use crate::setting::{SettingError, change_in, number_in, variable_named};
use poropunch::effect::CATALOGUE;
use std::collections::BTreeMap;
use std::sync::Arc;
use thiserror::Error;

/// A declaration that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DeclarationError {
    /// It has another form.
    #[error(
        "--effect {0}: write NAME=PARAMETER:NULL:SCALE, the parameter's value without the effect and how much a plausible effect changes it"
    )]
    Form(String),
    /// Parameter or value.
    #[error("--effect {text}: {problem}")]
    Setting {
        /// The declaration.
        text: String,
        /// What is wrong.
        problem: SettingError,
    },
    /// The name stands for something else.
    #[error("--effect {0}: an effect of this name is asked about already; choose another")]
    Taken(String),
    /// No change at all.
    #[error("--effect {0}: a plausible change of nothing shows nothing; give a scale that is not 0")]
    NoScale(String),
}

/// A declared effect, and the value of its parameter in the plain model.
#[derive(Debug, Clone)]
pub struct Declared {
    /// The effect.
    pub effect: Effect,
    /// Its parameter.
    pub parameter: String,
    /// The parameter's value without the effect, in the FMU's unit.
    pub null: f64,
}

/// Reads the declarations.
///
/// # Errors
/// With the declaration and what is wrong with it.
pub fn declared(wiring: &Wiring, texts: &[String]) -> Result<Vec<Declared>, DeclarationError> {
    let mut all: Vec<Declared> = Vec::new();
    for text in texts {
        let one = one(wiring, text)?;
        let is_taken = CATALOGUE.iter().any(|e| e.name == one.effect.name)
            || all.iter().any(|d| d.effect.name == one.effect.name);
        if is_taken {
            return Err(DeclarationError::Taken(text.clone()));
        }
        all.push(one);
    }
    Ok(all)
}

fn one(wiring: &Wiring, text: &str) -> Result<Declared, DeclarationError> {
    let form = || DeclarationError::Form(text.to_owned());
    let (name, rest) = text.split_once('=').ok_or_else(form)?;
    let [parameter, null, scale] =
        rest.split(':').map(str::trim).collect::<Vec<_>>().try_into().map_err(|_| form())?;
    if name.trim().is_empty() {
        return Err(form());
    }
    let setting = |problem| DeclarationError::Setting { text: text.to_owned(), problem };
    let variable = variable_named(wiring, parameter).map_err(setting)?;
    let null = number_in(variable, null).map_err(setting)?;
    let scale = change_in(variable, scale).map_err(setting)?;
    if scale == 0.0 && variable.kind != VariableKind::Boolean {
        return Err(DeclarationError::NoScale(text.to_owned()));
    }
    Ok(Declared {
        effect: effect(name.trim(), variable, null, scale),
        parameter: variable.name.clone(),
        null,
    })
}

fn effect(name: &str, variable: &ScalarVariable, null: f64, scale: f64) -> Effect {
    let parameter = variable.name.clone();
    let inside = |value: f64| variable.range.contains(value);
    let is_number = variable.kind == VariableKind::Real;
    let sign = match inside(null - scale) {
        _ if !is_number => Sign::Switch,
        true => Sign::Either,
        false => Sign::Positive,
    };
    let admissible = |m: f64| inside(null + m * scale) && (sign != Sign::Either || inside(null - m * scale));
    Effect {
        name: name.to_owned(),
        family: name.to_owned(),
        title: format!("{name} ({parameter})"),
        place: Place::Declared,
        sign,
        scope: Scope::Shared,
        scale,
        unit: variable.unit.clone().unwrap_or_default(),
        largest: largest_within(admissible),
        reveals: format!("any test in which {parameter} differs"),
        differentiable: is_differentiable(&parameter),
        is_a_number: false,
        parameters: vec![parameter.clone()],
        action: Arc::new(move |values: &mut BTreeMap<String, f64>, magnitude| {
            let value = if is_number { null + magnitude * scale } else { scale };
            values.insert(parameter.clone(), value);
        }),
    }
}

/// Whether the model's derivatives may be on while a parameter acts: not with the catalogue's effects that have none.
fn is_differentiable(parameter: &str) -> bool {
    let variants = CATALOGUE.iter().flat_map(|e| e.variants);
    variants.filter(|v| v.settings.iter().any(|s| s.parameter == parameter)).all(|v| v.differentiable)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi::Fmu;
    use crate::pool::wiring::Names;

    fn read(text: &str) -> Result<Declared, DeclarationError> {
        let fmu = Fmu::builtin().unwrap();
        let wiring = Wiring::new(fmu.description(), &Names::default()).unwrap();
        declared(&wiring, &[text.to_owned()]).map(|mut all| all.remove(0))
    }

    #[test]
    fn a_declaration_moves_its_parameter() {
        let d = read("height=geometry.sample_height:10mm:-0.5mm").unwrap();
        assert_eq!((d.parameter.as_str(), d.effect.sign), ("geometry.sample_height", Sign::Either));
        assert!((d.null - 0.01).abs() < 1e-15 && (d.effect.scale + 0.5e-3).abs() < 1e-15);
        let mut values = BTreeMap::new();
        (d.effect.action)(&mut values, 2.0);
        assert!((values["geometry.sample_height"] - 9e-3).abs() < 1e-15);
        // Whatever size is tried, the sample has a height.
        for m in [d.effect.largest, -d.effect.largest] {
            (d.effect.action)(&mut values, m);
            assert!(values["geometry.sample_height"] > 0.0, "{m}: {values:?}");
        }
    }

    #[test]
    fn what_cannot_be_used_is_told() {
        for (text, part) in [
            ("height=geometry.sample_height", "NAME=PARAMETER:NULL:SCALE"),
            ("=geometry.sample_height:10mm:1mm", "NAME=PARAMETER:NULL:SCALE"),
            ("height=geometry.sample_heigth:10mm:1mm", "geometry.sample_height"),
            ("height=geometry.sample_height:10:1mm", "unit"),
            ("height=geometry.sample_height:10mm:0mm", "not 0"),
            ("load_cell_drift=geometry.sample_height:10mm:1mm", "choose another"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(part) && error.contains("--effect"), "{error}");
        }
    }
}
