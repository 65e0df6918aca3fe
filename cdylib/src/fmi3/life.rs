//! Life of an instance, its states and messages.
// SAFETY of all functions here: they are called by an FMI master that keeps the standard's promises on
// pointers (valid or NULL, arrays of the stated length, one thread at a time per instance).
#![allow(clippy::missing_safety_doc, clippy::too_many_arguments)]

use super::Modes;
use super::abi::{Boolean, IntermediateUpdate, LogMessage, ValueReference};
use crate::component::Component;
use crate::guard::{self, Status, call, entry_points, slice, text, texts};
use crate::life::life_functions;
use crate::logger::Logger;
use crate::phase::{ANY, CONFIGURATION, EVENT, INITIALIZATION, INSTANTIATED, Phase, RUNNING, STEP_COMPLETE};
use crate::states::{self, FmuState, state_functions};
use poropunch::model_description::fmi3::instantiation_token;
use poropunch::variables::by_name;
use std::ffi::{c_char, c_void};
use std::panic::catch_unwind;

/// Version of FMI.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// A new instance, or NULL with the reason logged. `resource_path` is not needed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    instance_name: *const c_char,
    token: *const c_char,
    _resource_path: *const c_char,
    _visible: Boolean,
    logging_on: Boolean,
    event_mode_used: Boolean,
    early_return_allowed: Boolean,
    intermediate_variables: *const ValueReference,
    n: usize,
    environment: *mut c_void,
    log: Option<LogMessage>,
    intermediate_update: Option<IntermediateUpdate>,
) -> *mut c_void {
    guard::quiet_panics();
    let create = || {
        let logger = Logger::fmi3(log, environment, logging_on != 0);
        // SAFETY: see the top of this file.
        let (name, asked, wanted) =
            unsafe { (text(instance_name), text(token), slice(intermediate_variables, n)) };
        let refusal = guard::refusal(name, asked, instantiation_token()).or(wanted.as_ref().err().cloned());
        if let Some(reason) = refusal {
            logger.error(&format!("fmi3InstantiateCoSimulation: {reason}"));
            return None;
        }
        let displacement = by_name("displacement").map(|(reference, _)| reference);
        let mut component = Box::new(Component::new(logger));
        component.modes = Some(Modes {
            events: event_mode_used != 0,
            early_return: early_return_allowed != 0,
            intermediate_update,
            gives_displacement: wanted.is_ok_and(|all| all.iter().any(|&one| Some(one) == displacement)),
            gave_displacement: false,
            environment,
        });
        component.logger.event(|| "instantiated".to_owned());
        Some(component)
    };
    match catch_unwind(std::panic::AssertUnwindSafe(create)) {
        Ok(Some(component)) => Box::into_raw(component).cast(),
        _ => std::ptr::null_mut(),
    }
}

/// Not offered: NULL.
fn refuse(log: Option<LogMessage>, environment: *mut c_void, kind: &str) -> *mut c_void {
    guard::quiet_panics();
    let say = || {
        let reason = format!("this FMU offers co-simulation only, not {kind}");
        Logger::fmi3(log, environment, false).error(&reason);
    };
    let _ = catch_unwind(std::panic::AssertUnwindSafe(say));
    std::ptr::null_mut()
}

/// Defines instantiations that answer NULL and log why.
macro_rules! refused {
    ($($name:ident, $kind:literal, ($($more:ty),*);)+) => {
        $(/// Not offered: NULL.
        #[unsafe(no_mangle)]
        pub extern "C" fn $name(
            _instance_name: *const c_char,
            _token: *const c_char,
            _resource_path: *const c_char,
            _visible: Boolean,
            _logging_on: Boolean,
            environment: *mut c_void,
            log: Option<LogMessage>,
            $(_: $more),*
        ) -> *mut c_void {
            refuse(log, environment, $kind)
        })+
    };
}

refused! {
    fmi3InstantiateModelExchange, "model exchange", ();
    fmi3InstantiateScheduledExecution, "scheduled execution", (*const c_void, *const c_void, *const c_void);
}

life_functions! {
    fmi3SetDebugLogging,
    fmi3FreeInstance,
    /// Start and stop time; the tolerance is not used. Parameters and inputs may still be set until the end of the
    /// initialisation.
    fmi3EnterInitializationMode,
    Component::begin_initialisation
}

entry_points! {
    /// Builds the model; with events, the event mode follows.
    fn fmi3ExitInitializationMode() in INITIALIZATION, Component::initialise;

    /// Sizes of arrays may be set.
    fn fmi3EnterConfigurationMode() in INSTANTIATED, |c| {
        c.phase = Phase::Configuration;
        Ok(())
    };

    /// Back to where parameters are set.
    fn fmi3ExitConfigurationMode() in CONFIGURATION, |c| {
        c.phase = Phase::Instantiated;
        Ok(())
    };

    /// Discrete inputs may change at this instant.
    fn fmi3EnterEventMode() in STEP_COMPLETE, |c| {
        if !c.modes.is_some_and(|modes| modes.events) {
            return Err("the instance was made without event mode".to_owned());
        }
        c.phase = Phase::Event;
        Ok(())
    };

    /// Ready to step.
    fn fmi3EnterStepMode() in EVENT, |c| {
        c.phase = Phase::StepComplete;
        Ok(())
    };

    /// Ends the simulation with the last frame of the fields, where they are written; results can still be read.
    fn fmi3Terminate() in RUNNING, Component::terminate;

    /// Back to the state after the instantiation, from anywhere.
    fn fmi3Reset() in ANY, |c| {
        c.reset();
        Ok(())
    };
}

state_functions! {
    fmi3GetFMUState, fmi3SetFMUState, fmi3FreeFMUState, fmi3SerializedFMUStateSize, fmi3SerializeFMUState,
    fmi3DeserializeFMUState
}
