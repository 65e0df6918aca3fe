//! The 25 functions common to model exchange and co-simulation (`fmi2Functions.h`).
// SAFETY of all functions here: they are called by an FMI master that keeps the standard's promises on
// pointers (valid or NULL, arrays of the stated length, one thread at a time per component).
#![allow(clippy::missing_safety_doc, clippy::too_many_arguments)]

use super::abi::{Boolean, CO_SIMULATION, CallbackFunctions, ValueReference};
use crate::component::Component;
use crate::content::{boolean, integer, real, string};
use crate::guard::{self, Status, call, entry_points, slice, text, texts, write_each};
use crate::life::life_functions;
use crate::logger::Logger;
use crate::phase::{ANY, GETTABLE, INITIALIZATION, INSTANTIATED, SETTABLE, STEP_COMPLETE};
use crate::states::{self, FmuState, state_functions};
use poropunch::model_description::guid;
use poropunch::variables::Value;
use std::ffi::{c_char, c_int, c_void};
use std::panic::catch_unwind;

/// Platform of the FMI types.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// Version of FMI.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// A new instance, or NULL with the reason logged. `resource_location` is not needed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instance_name: *const c_char,
    kind: c_int,
    fmu_guid: *const c_char,
    _resource_location: *const c_char,
    functions: *const CallbackFunctions,
    _visible: Boolean,
    logging_on: Boolean,
) -> *mut c_void {
    guard::quiet_panics();
    let create = || {
        // SAFETY: see the top of this file. The callbacks are copied: they are only valid during this call.
        let (name, asked, callbacks) =
            unsafe { (text(instance_name), text(fmu_guid), functions.as_ref().copied()?) };
        let logger = Logger::fmi2(callbacks, name.unwrap_or("unnamed"), logging_on != 0);
        let refusal = if kind == CO_SIMULATION {
            guard::refusal(name, asked, guid())
        } else {
            Some("this FMU offers co-simulation only, not model exchange".to_owned())
        };
        if let Some(reason) = refusal {
            logger.error(&format!("fmi2Instantiate: {reason}"));
            return None;
        }
        logger.event(|| "instantiated".to_owned());
        Some(Box::new(Component::new(logger)))
    };
    match catch_unwind(create) {
        Ok(Some(component)) => Box::into_raw(component).cast(),
        _ => std::ptr::null_mut(),
    }
}

life_functions! {
    fmi2SetDebugLogging,
    fmi2FreeInstance,
    /// Start and stop time. The tolerance is not used, as is logged: `solver.tolerance` is a parameter.
    fmi2SetupExperiment,
    |_| Ok(())
}

entry_points! {
    /// Parameters and inputs may still be set until the end of the initialisation.
    fn fmi2EnterInitializationMode() in INSTANTIATED, Component::begin_initialisation;

    /// Builds the model.
    fn fmi2ExitInitializationMode() in INITIALIZATION, Component::initialise;

    /// Ends the simulation with the last frame of the fields, where they are written; results can still be read.
    fn fmi2Terminate() in STEP_COMPLETE, Component::terminate;

    /// Back to the state after `fmi2Instantiate`, from anywhere.
    fn fmi2Reset() in ANY, |c| {
        c.reset();
        Ok(())
    };
}

/// Defines a get and a set function of one type.
macro_rules! access {
    ($get:ident, $set:ident, $c_type:ty, $zero:expr, $from:expr, $to:expr) => {
        entry_points! {
            /// Values of variables: parameters and inputs as set, outputs of the last step.
            fn $get(references: *const ValueReference, n: usize, values: *mut $c_type) in GETTABLE, |c| {
                let read = c.slave.get_each(slice(references, n)?, $from, $zero);
                write_each(values, &read.map_err(|e| e.to_string())?)
            };

            /// Sets parameters and inputs: all of them, or none and an error.
            fn $set(references: *const ValueReference, n: usize, values: *const $c_type) in SETTABLE, |c| {
                let (references, values) = (slice(references, n)?, slice(values, n)?);
                let pairs = references.iter().copied().zip(values.iter().copied().map($to));
                c.slave.set(&pairs.collect::<Vec<_>>()).map_err(|e| e.to_string())
            };
        }
    };
}

access!(fmi2GetReal, fmi2SetReal, f64, Value::Real(0.0), real, Value::Real);
access!(fmi2GetInteger, fmi2SetInteger, c_int, Value::Integer(0), integer, Value::Integer);
access!(fmi2GetBoolean, fmi2SetBoolean, Boolean, Value::Boolean(false), boolean, |v| Value::Boolean(v != 0));

entry_points! {
    /// Values of variables; the texts stay where they are until the next call of this function.
    fn fmi2GetString(
        references: *const ValueReference,
        n: usize,
        values: *mut *const c_char,
    ) in GETTABLE, |c| {
        let asked = Value::Text(String::new());
        c.texts = c.slave.get_each(slice(references, n)?, string, asked).map_err(|e| e.to_string())?;
        write_each(values, &c.texts.iter().map(|text| text.as_ptr()).collect::<Vec<_>>())
    };

    /// Sets parameters: all of them, or none and an error.
    fn fmi2SetString(
        references: *const ValueReference,
        n: usize,
        values: *const *const c_char,
    ) in SETTABLE, |c| {
        let pairs = slice(references, n)?
            .iter()
            .zip(texts(values, n, "text")?)
            .map(|(&r, text)| (r, Value::Text(text.to_owned())));
        c.slave.set(&pairs.collect::<Vec<_>>()).map_err(|e| e.to_string())
    };
}

state_functions! {
    fmi2GetFMUstate, fmi2SetFMUstate, fmi2FreeFMUstate, fmi2SerializedFMUstateSize, fmi2SerializeFMUstate,
    fmi2DeSerializeFMUstate
}

entry_points! {
    /// Not offered (`providesDirectionalDerivative` is false).
    fn fmi2GetDirectionalDerivative(
        _unknowns: *const ValueReference,
        _n_unknown: usize,
        _knowns: *const ValueReference,
        _n_known: usize,
        _dv_known: *const f64,
        _dv_unknown: *mut f64,
    ) in GETTABLE, |_| {
        Err("this FMU has no directional derivatives; sensitivities are ordinary outputs".to_owned())
    };
}
