//! Effects: what the plain model leaves out, each with a magnitude that is zero by default.
//!
//! Declarations only: one file per effect holds its parameters and its [`Effect`]: what it is, where it acts, what
//! reveals and what mimics it. The list in this file makes [`CATALOGUE`], [`EffectParameters`] and [`PARAMETERS`] of
//! them. The laws stand in the rooms where they act, which know nothing of effects; `builder.rs` alone knows both. At
//! null the model is the plain one, bit for bit.
//!
//! The order in which they act is that of the force's way: specimen, contact, machine, sensor.

mod descriptor;
mod parameter;

pub use descriptor::{Course, Effect, Place, Setting, Sign, Variant};
pub use parameter::{Access, Parameter};
use serde::{Deserialize, Serialize};

/// Parameters of an effect that is made of parameters of the plain model.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct NoParameters;

/// Modules, parameters, catalogue and variables of all effects, from the list of their names.
macro_rules! effects {
    (@type $name:ident) => { $name::Parameters };
    (@type $name:ident $none:ident) => { $none };
    (@rows $name:ident) => { $name::PARAMETERS };
    (@rows $name:ident $none:ident) => { &[] };
    ($($name:ident $(: $none:ident)?),+ $(,)?) => {
        $(pub mod $name;)+

        /// Parameters of all effects; the default is no effect at all.
        #[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
        pub struct EffectParameters {
            $(#[doc = concat!("Of [`", stringify!($name), "`].")] pub $name: effects!(@type $name $($none)?),)+
        }

        /// All effects.
        pub const CATALOGUE: &[&Effect] = &[$(&$name::EFFECT),+];

        /// Their parameters, effect by effect.
        pub const PARAMETERS: &[&[Parameter]] = &[$(effects!(@rows $name $($none)?)),+];
    };
}

effects!(
    third_branch: NoParameters,
    eyring,
    permeability,
    lambda_star: NoParameters,
    softening,
    modulus_drift,
    amplitude,
    slip,
    drained_punch: NoParameters,
    drainage: NoParameters,
    specimen_size: NoParameters,
    adhesion,
    offset,
    compliance,
    load_cell_drift,
    load_cell_lag,
    discretisation,
);

/// The effect called `name`.
pub fn by_name(name: &str) -> Option<&'static Effect> {
    CATALOGUE.iter().copied().find(|effect| effect.name == name)
}
