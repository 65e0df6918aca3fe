//! The parameters of effects, as whoever sets them by name sees them.

use super::EffectParameters;
use crate::unit::Unit;

/// One parameter of an effect.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Name in the variable table, `effect.<effect>.<parameter>`.
    pub name: &'static str,
    /// What it is, for a person.
    pub description: &'static str,
    /// Where it is, and which values it takes.
    pub access: Access,
}

/// Reader and writer of a parameter.
#[derive(Debug, Clone, Copy)]
pub enum Access {
    /// A number.
    Real {
        /// Its unit.
        unit: &'static Unit,
        /// Admissible values (SI).
        range: (f64, f64),
        /// Reader.
        get: fn(&EffectParameters) -> f64,
        /// Writer.
        set: fn(&mut EffectParameters, f64),
    },
    /// A switch.
    Flag {
        /// Reader.
        get: fn(&EffectParameters) -> bool,
        /// Writer.
        set: fn(&mut EffectParameters, bool),
    },
}

/// A parameter that is a number: name, description, unit, range and the field that holds it.
macro_rules! real {
    ($name:literal, $description:literal, $unit:expr, $range:expr, $($field:ident).+ $(,)?) => {
        $crate::effect::Parameter {
            name: $name,
            description: $description,
            access: $crate::effect::Access::Real {
                unit: $unit,
                range: $range,
                get: |e| e.$($field).+,
                set: |e, v| e.$($field).+ = v,
            },
        }
    };
}

/// A parameter that is a switch: name, description and the field that holds it.
macro_rules! flag {
    ($name:literal, $description:literal, $($field:ident).+ $(,)?) => {
        $crate::effect::Parameter {
            name: $name,
            description: $description,
            access: $crate::effect::Access::Flag {
                get: |e| e.$($field).+,
                set: |e, v| e.$($field).+ = v,
            },
        }
    };
}

pub(super) use {flag, real};
