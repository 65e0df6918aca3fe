//! Effects: what the plain model leaves out, each with a magnitude that is zero by default.
//!
//! One file per effect holds its parameters, their entries in the variable table, its law and its
//! [`Effect`]: what it is, where it acts, what reveals and what mimics it. The list at the end of this file
//! makes [`CATALOGUE`], [`EffectParameters`] and the table's section of them. At null the model is the plain
//! one, bit for bit.
//!
//! The order in which they act is that of the force's way: specimen, contact, machine, sensor.

mod catalogue;
mod descriptor;

pub use catalogue::{by_name, markdown};
pub use descriptor::{Course, Effect, Place, Setting, Sign, Variant};

use crate::error::ParameterError;
use crate::parameters::{MeshKind, Parameters};
use crate::variables::{Settings, Variable};
use serde::{Deserialize, Serialize};

/// Parameters of an effect that is made of parameters of the plain model.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct NoParameters;

/// Modules, parameters, catalogue and variables of all effects, from the list of their names.
macro_rules! effects {
    ($($name:ident),+ $(,)?) => {
        $(pub mod $name;)+

        /// Parameters of all effects; the default is no effect at all.
        #[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
        pub struct EffectParameters {
            $(#[doc = concat!("Of [`", stringify!($name), "`].")] pub $name: $name::Parameters,)+
        }

        /// All effects.
        pub const CATALOGUE: &[&Effect] = &[$(&$name::EFFECT),+];

        /// Their entries of the variable table.
        pub(crate) const VARIABLES: &[&[Variable]] = &[$($name::VARIABLES),+];
    };
}

effects!(
    third_branch,
    eyring,
    permeability,
    lambda_star,
    softening,
    modulus_drift,
    amplitude,
    slip,
    drained_punch,
    drainage,
    specimen_size,
    adhesion,
    offset,
    compliance,
    load_cell_drift,
    load_cell_lag,
    discretisation,
);

impl EffectParameters {
    /// Checks the ranges that the variable table declares, and what cannot be combined.
    ///
    /// # Errors
    /// Names the first parameter that is not admissible, with the reason.
    pub(crate) fn validate(parameters: &Parameters) -> Result<(), ParameterError> {
        let settings = Settings::padding(parameters);
        for variable in VARIABLES.iter().copied().flatten() {
            variable.validate(&settings)?;
        }
        let effect = &parameters.effect;
        let slips = effect.slip.is_active();
        if slips && !parameters.boundary.bonded_punch {
            return Err(ParameterError::Contradiction(
                "effect.slip.compliance",
                "boundary.bonded_punch = true",
            ));
        }
        if slips && !parameters.indenter.is_plane() {
            // The layer knows where a plane was touched: at rest.
            return Err(ParameterError::Contradiction(
                "effect.slip.compliance",
                "indenter.profile = flat with a sharp edge",
            ));
        }
        if parameters.solver.sensitivities && effect.discretisation.traction {
            return Err(ParameterError::NoSensitivities("effect.discretisation.traction"));
        }
        if parameters.mesh.kind == MeshKind::Paper3d {
            let refused = [
                (effect.eyring.is_active(), "effect.eyring.inverse_stress"),
                (effect.permeability.is_active(), "effect.permeability.exponent"),
                (effect.softening.is_active(), "effect.softening.loss"),
                (effect.modulus_drift.is_active(), "effect.modulus_drift.rate"),
                (effect.amplitude.is_active(), "effect.amplitude.log_factor"),
                (slips, "effect.slip.compliance"),
                (effect.adhesion.is_active(), "effect.adhesion.strength"),
                (effect.compliance.is_active(), "effect.compliance.per_newton"),
            ];
            if let Some((_, name)) = refused.into_iter().find(|(active, _)| *active) {
                return Err(ParameterError::NotIn3d(name));
            }
        }
        Ok(())
    }
}
