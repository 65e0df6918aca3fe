//! What makes a row of the table.

use super::{Binding, Causality, Enumeration, Identification, Kind, Variability, Variable};
use crate::effect::{Access, Parameter};
use crate::unit::Unit;

pub(super) const fn variable(
    name: &'static str,
    description: &'static str,
    kind: Kind,
    binding: Binding,
) -> Variable {
    let (causality, variability) = match binding {
        Binding::RealOutput(_) | Binding::Sensitivity(..) => (Causality::Output, Variability::Continuous),
        Binding::IntegerOutput(_) => (Causality::Output, Variability::Discrete),
        _ => (Causality::Parameter, Variability::Fixed),
    };
    Variable { name, description, causality, variability, kind, identification: None, binding }
}

/// A parameter or input that is a number, admissible from `min` to `max`.
pub(super) const fn real(
    name: &'static str,
    description: &'static str,
    binding: Binding,
    unit: &'static Unit,
    (min, max): (f64, f64),
) -> Variable {
    variable(name, description, Kind::Real { unit, range: Some((min, max)) }, binding)
}

/// A switch.
pub(super) const fn flag(name: &'static str, description: &'static str, binding: Binding) -> Variable {
    variable(name, description, Kind::Boolean, binding)
}

/// An item of an enumeration.
pub(super) const fn choice(
    name: &'static str,
    description: &'static str,
    binding: Binding,
    names: &'static Enumeration,
) -> Variable {
    variable(name, description, Kind::Enumeration(names), binding)
}

/// A whole number.
pub(super) const fn integer(
    name: &'static str,
    description: &'static str,
    binding: Binding,
    min: i32,
    max: i32,
) -> Variable {
    variable(name, description, Kind::Integer { range: Some((min, max)) }, binding)
}

/// A text.
pub(super) const fn text(name: &'static str, description: &'static str, binding: Binding) -> Variable {
    variable(name, description, Kind::Text, binding)
}

/// A result.
pub(super) const fn output(
    name: &'static str,
    description: &'static str,
    binding: Binding,
    unit: &'static Unit,
) -> Variable {
    variable(name, description, Kind::Real { unit, range: None }, binding)
}

/// What the solver counts.
pub(super) const fn count(name: &'static str, description: &'static str, binding: Binding) -> Variable {
    variable(name, description, Kind::Integer { range: None }, binding)
}

/// The row of an effect's parameter.
pub(super) const fn of_effect(parameter: &Parameter) -> Variable {
    let (kind, binding) = match parameter.access {
        Access::Real { unit, range, get, set } => {
            (Kind::Real { unit, range: Some(range) }, Binding::EffectReal(get, set))
        }
        Access::Flag { get, set } => (Kind::Boolean, Binding::EffectFlag(get, set)),
    };
    variable(parameter.name, parameter.description, kind, binding)
}

/// FMI integers have 32 bits.
pub(super) fn saturate(count: u64) -> i32 {
    i32::try_from(count).unwrap_or(i32::MAX)
}

impl Variable {
    /// Bounds of Table 1 (SI).
    pub(super) const fn fitted(mut self, lower: f64, upper: f64) -> Self {
        self.identification = Some(Identification { lower, upper, free: true });
        self
    }

    pub(super) const fn input(mut self, variability: Variability) -> Self {
        self.causality = Causality::Input;
        self.variability = variability;
        self
    }
}

/// A section of the table, row by row: the description as a comment, then `name: kind(what the kind takes)`. The name, after the
/// section's prefix, is that of the field of the section's place that holds the value; a name for which that is not so tells it in
/// square brackets.
macro_rules! section {
    ($prefix:literal, $place:tt: $(
        $(#[doc = $line:literal])+
        $name:ident $([$field:ident])?: $kind:ident $(($($argument:expr),*))? $(.$and:ident($($with:expr),*))?;
    )+) => {
        &[$(
            $kind(
                concat!($prefix, stringify!($name)),
                // Every line of a comment begins with a space.
                concat!($($line),+).trim_ascii_start(),
                binding!($kind, $place, $name $([$field])?),
                $($($argument),*)?
            )$(.$and($($with),*))?
        ),+]
    };
}

/// Reader and writer of a field.
macro_rules! binding {
    ($kind:ident, $place:tt, $name:ident [$field:ident]) => { binding!($kind, $place, $field) };
    (real, ($($place:ident).*), $field:ident) => {
        Binding::Real(|s| s.$($place.)*$field, |s, v| s.$($place.)*$field = v)
    };
    (flag, ($($place:ident).*), $field:ident) => {
        Binding::Boolean(|s| s.$($place.)*$field, |s, v| s.$($place.)*$field = v)
    };
    (choice, ($($place:ident).*), $field:ident) => {
        Binding::Integer(|s| s.$($place.)*$field as i32 + 1, |s, v| s.$($place.)*$field = Choice::of_number(v))
    };
    (integer, ($($place:ident).*), $field:ident) => {
        // The range lets through what fits.
        Binding::Integer(|s| s.$($place.)*$field as i32, |s, v| s.$($place.)*$field = v as _)
    };
    (text, ($($place:ident).*), $field:ident) => {
        Binding::Text(|s| &s.$($place.)*$field, |s, v| s.$($place.)*$field = v)
    };
    (output, ($($place:ident).*), $field:ident) => { Binding::RealOutput(|r| r.$($place.)*$field) };
    (count, ($($place:ident).*), $field:ident) => { Binding::IntegerOutput(|r| saturate(r.$($place.)*$field)) };
}

pub(super) use {binding, section};
