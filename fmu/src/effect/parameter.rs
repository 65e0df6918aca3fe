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

/// Declares the parameters of an effect: the struct that holds them, their start values and how they are set by name. A row is
/// `name: real(unit, range) = start` or `name: flag = start`; its comment is the parameter's description.
macro_rules! parameters {
    ($(#[doc = $what:literal])+ $effect:ident: $(
        $(#[doc = $line:literal])+
        $field:ident: $kind:ident $(($unit:ident, $range:expr))? = $start:literal;
    )+) => {
        $(#[doc = $what])+
        #[derive(Debug, Clone, Copy, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        pub struct Parameters {
            $(
                $(#[doc = $line])+
                $(#[doc = concat!("([`", stringify!($unit), "`](crate::unit::", stringify!($unit), ")).")])?
                pub $field: $crate::effect::parameter::access!(@type $kind),
            )+
        }

        impl Default for Parameters {
            fn default() -> Self {
                Self { $($field: $start),+ }
            }
        }

        pub(super) const PARAMETERS: &[$crate::effect::Parameter] = &[$($crate::effect::Parameter {
            name: concat!("effect.", stringify!($effect), ".", stringify!($field)),
            // Every line of a comment begins with a space.
            description: concat!($($line),+).trim_ascii_start(),
            access: $crate::effect::parameter::access!($kind, $effect.$field $(, $unit, $range)?),
        }),+];
    };
}

/// Reader and writer of a field, and its type.
macro_rules! access {
    (@type real) => {
        f64
    };
    (@type flag) => {
        bool
    };
    (real, $effect:ident.$field:ident, $unit:ident, $range:expr) => {
        $crate::effect::Access::Real {
            unit: &$unit,
            range: $range,
            get: |e| e.$effect.$field,
            set: |e, v| e.$effect.$field = v,
        }
    };
    (flag, $effect:ident.$field:ident) => {
        $crate::effect::Access::Flag { get: |e| e.$effect.$field, set: |e, v| e.$effect.$field = v }
    };
}

pub(super) use {access, parameters};
