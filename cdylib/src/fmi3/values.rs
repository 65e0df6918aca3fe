//! Values of variables; those of arrays stand one after the other.
// SAFETY of all functions here: as in life.rs.
#![allow(clippy::missing_safety_doc)]

use super::abi::{Boolean, ValueReference};
use crate::component::Component;
use crate::content::{boolean, count, integer, real, string};
use crate::guard::{Outcome, entry_points, slice, texts, write_each};
use crate::phase::{GETTABLE, Phase, RESIZABLE, SETTABLE};
use poropunch::variables::ports::{BaseType, Port};
use poropunch::variables::{Causality, Value};
use std::ffi::{c_char, c_void};

/// Reads variables of one type.
fn read<T>(
    c: &Component,
    kind: BaseType,
    references: &[ValueReference],
    n: usize,
    from: impl Fn(Value) -> Option<T>,
) -> Result<Vec<T>, String> {
    let values = c.slave.get_ports(kind, references).map_err(|e| e.to_string())?;
    if values.len() != n {
        return Err(format!("room for {n} values of {}", values.len()));
    }
    values.into_iter().map(|value| from(value).ok_or_else(|| "a value of another type".to_owned())).collect()
}

/// Sets variables of one type; within a step only the displacement at its end, which is noted.
fn set(c: &mut Component, kind: BaseType, references: &[ValueReference], values: Vec<Value>) -> Outcome {
    let within = c.phase == Phase::IntermediateUpdate;
    if within && !references.iter().all(|&one| is_continuous_input(one)) {
        return Err("within a step only the displacement can be set".to_owned());
    }
    c.slave.set_ports(kind, references, values).map_err(|e| e.to_string())?;
    if let Some(modes) = c.modes.as_mut().filter(|_| within && !references.is_empty()) {
        modes.gave_displacement = true;
    }
    Ok(())
}

fn is_continuous_input(reference: ValueReference) -> bool {
    Port::by_reference(reference)
        .is_ok_and(|port| port.causality() == Causality::Input && port.is_intermediate())
}

/// Defines a get and a set function of one type.
macro_rules! access {
    ($get:ident, $set:ident, $kind:expr, $settable:expr, $c_type:ty, $from:expr, $to:expr) => {
        entry_points! {
            /// Values of variables: parameters and inputs as set, outputs of the last step.
            fn $get(
                references: *const ValueReference,
                n: usize,
                values: *mut $c_type,
                n_values: usize,
            ) in GETTABLE, |c| {
                write_each(values, &read(c, $kind, slice(references, n)?, n_values, $from)?)
            };

            /// Sets parameters and inputs: all of them, or none and an error.
            fn $set(
                references: *const ValueReference,
                n: usize,
                values: *const $c_type,
                n_values: usize,
            ) in $settable, |c| {
                let values = slice(values, n_values)?.iter().copied().map($to);
                set(c, $kind, slice(references, n)?, values.collect::<Result<_, String>>()?)
            };
        }
    };
}

/// The number of an enumeration's item.
fn item(value: i64) -> Result<Value, String> {
    i32::try_from(value).map(Value::Integer).map_err(|_| format!("{value} is no item of an enumeration"))
}

access!(fmi3GetFloat64, fmi3SetFloat64, BaseType::Float64, SETTABLE, f64, real, |v| Ok(Value::Real(v)));
access!(fmi3GetInt32, fmi3SetInt32, BaseType::Int32, SETTABLE, i32, integer, |v| Ok(Value::Integer(v)));
access!(fmi3GetInt64, fmi3SetInt64, BaseType::Enumeration, SETTABLE, i64, integer, item);
access!(fmi3GetUInt64, fmi3SetUInt64, BaseType::UInt64, RESIZABLE, u64, count, |v| Ok(Value::Count(v)));
access!(fmi3GetBoolean, fmi3SetBoolean, BaseType::Boolean, SETTABLE, Boolean, boolean, |v| {
    Ok(Value::Boolean(v != 0))
});

entry_points! {
    /// Values of variables; the texts stay where they are until the next call of this function.
    fn fmi3GetString(
        references: *const ValueReference,
        n: usize,
        values: *mut *const c_char,
        n_values: usize,
    ) in GETTABLE, |c| {
        c.texts = read(c, BaseType::String, slice(references, n)?, n_values, string)?;
        write_each(values, &c.texts.iter().map(|text| text.as_ptr()).collect::<Vec<_>>())
    };

    /// Sets parameters: all of them, or none and an error.
    fn fmi3SetString(
        references: *const ValueReference,
        n: usize,
        values: *const *const c_char,
        n_values: usize,
    ) in SETTABLE, |c| {
        let values = texts(values, n_values, "text")?.into_iter().map(|v| Value::Text(v.to_owned()));
        set(c, BaseType::String, slice(references, n)?, values.collect())
    };
}
