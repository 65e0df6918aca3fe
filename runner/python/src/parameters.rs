//! Parameters by name: what there is, and values of them.

use poropunch::variables::{Causality, Kind, Settings, Value, by_name, table};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use runner::pool::Wiring;
use runner::setting::{admissible, number_in, variable_named};
use std::collections::BTreeMap;

/// Name, SI unit (none for what is no Real), start value, smallest and largest value, items, description of every parameter.
type Row = (String, Option<String>, f64, Option<f64>, Option<f64>, Vec<String>, String);

/// One row for every parameter but the texts, in the order of the variable table.
#[pyfunction]
pub fn parameters() -> Vec<Row> {
    let numbers = table().iter().filter(|v| v.causality == Causality::Parameter && v.kind != Kind::Text);
    let row = |v: &poropunch::variables::Variable| {
        let range = match v.kind {
            Kind::Real { range, .. } => range,
            Kind::Integer { range } => range.map(|(min, max)| (f64::from(min), f64::from(max))),
            _ => None,
        };
        let items = match v.kind {
            Kind::Enumeration(e) => e.items.iter().map(|(item, _)| (*item).to_owned()).collect(),
            Kind::Boolean => vec!["false".to_owned(), "true".to_owned()],
            _ => Vec::new(),
        };
        let unit = v.unit().map(|unit| unit.symbol.to_owned());
        let (min, max) = (range.map(|r| r.0), range.map(|r| r.1));
        (v.name.to_owned(), unit, v.start_number(), min, max, items, v.description.to_owned())
    };
    numbers.map(row).collect()
}

/// Values by name, SI: numbers are SI, texts are read as on the command line ("2 mm", "coarse").
pub fn values(wiring: &Wiring, given: &Bound<'_, PyDict>) -> PyResult<BTreeMap<String, f64>> {
    let mut values = BTreeMap::new();
    for (name, value) in given {
        let name: String =
            name.extract().map_err(|_| PyTypeError::new_err("names of parameters are texts"))?;
        let refused = |error: runner::setting::SettingError| PyValueError::new_err(error.to_string());
        let variable = variable_named(wiring, &name).map_err(refused)?;
        let number = if let Ok(text) = value.cast::<PyString>() {
            number_in(variable, &text.to_cow()?)
        } else if let Ok(truth) = value.cast::<PyBool>() {
            number_in(variable, if truth.is_true() { "true" } else { "false" })
        } else {
            admissible(variable, value.extract().map_err(|_| not_a_value(&name))?)
        };
        values.insert(variable.name.clone(), number.map_err(refused)?);
    }
    check(&values).map_err(PyValueError::new_err)?;
    Ok(values)
}

fn not_a_value(name: &str) -> PyErr {
    PyTypeError::new_err(format!("{name}: give a number (SI) or a text with a unit, such as \"2 mm\""))
}

/// Whether the model can be built from such values: what concerns several of them at a time, too.
fn check(values: &BTreeMap<String, f64>) -> Result<(), String> {
    let mut settings = Settings::default();
    for (name, &number) in values {
        let Some((_, variable)) = by_name(name) else { continue };
        let value = match variable.kind {
            Kind::Real { .. } => Value::Real(number),
            Kind::Integer { .. } | Kind::Enumeration(_) if number.fract() == 0.0 => {
                Value::Integer(number as i32)
            }
            Kind::Boolean => Value::Boolean(number != 0.0),
            _ => return Err(format!("{name}: {number} is not a whole number")),
        };
        variable.set(&mut settings, value).map_err(|error| error.to_string())?;
    }
    let settings = settings.chosen();
    settings.validate_branches().map_err(|error| error.to_string())?;
    settings.parameters().validate().map_err(|error| error.to_string())
}
