//! The 9 functions of co-simulation (`fmi2Functions.h`).
// SAFETY of all functions here: as in common.rs.
#![allow(clippy::missing_safety_doc)]

use super::abi::{Boolean, ValueReference};
use crate::guard::{ERROR, OK, Outcome, Status, call, slice, write};
use crate::phase::{AFTER_START, ANY, Phase, SETTABLE, STEP_COMPLETE};
use std::ffi::{c_char, c_int, c_void};

/// Sets the velocity of the punch for the next step: first derivative of `displacement`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    component: *mut c_void,
    references: *const ValueReference,
    n: usize,
    orders: *const c_int,
    values: *const f64,
) -> Status {
    // SAFETY: see the top of this file.
    unsafe {
        call(component, "fmi2SetRealInputDerivatives", SETTABLE, |c| {
            let (references, orders, values) = (slice(references, n)?, slice(orders, n)?, slice(values, n)?);
            for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
                c.slave.set_input_derivative(reference, order, value).map_err(|e| e.to_string())?;
            }
            Ok(())
        })
    }
}

/// Not offered (`maxOutputDerivativeOrder` is 0).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    component: *mut c_void,
    _references: *const ValueReference,
    n: usize,
    _orders: *const c_int,
    _values: *mut f64,
) -> Status {
    // SAFETY: see the top of this file.
    unsafe {
        call(component, "fmi2GetRealOutputDerivatives", AFTER_START, |_| {
            let reason = "this FMU has no output derivatives (maxOutputDerivativeOrder = 0)";
            if n == 0 { Ok(()) } else { Err(reason.to_owned()) }
        })
    }
}

/// Makes one step. Never answers `fmi2Discard`: masters loop on it for ever.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    component: *mut c_void,
    current_time: f64,
    step_size: f64,
    _no_set_state_prior_to_current_point: Boolean,
) -> Status {
    // SAFETY: see the top of this file.
    unsafe {
        call(component, "fmi2DoStep", STEP_COMPLETE, |c| {
            // Left so by a failure or a panic.
            c.phase = Phase::Error;
            c.check_end(current_time + step_size)?;
            c.slave.step(current_time, step_size).map_err(|e| e.to_string())?;
            c.last_time = current_time + step_size;
            c.phase = Phase::StepComplete;
            c.logger.event(|| format!("step to {} s", c.last_time));
            Ok(())
        })
    }
}

/// Steps are synchronous: there is never one to cancel.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(component: *mut c_void) -> Status {
    // SAFETY: see the top of this file.
    unsafe {
        call(component, "fmi2CancelStep", ANY, |_| {
            Err("no step is in progress: fmi2DoStep never returns fmi2Pending".to_owned())
        })
    }
}

const DO_STEP_STATUS: c_int = 0;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

fn no_status(kind: c_int) -> Outcome {
    Err(format!("status {kind} is not of this type, or only exists for asynchronous steps"))
}

/// Status of the last step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(component: *mut c_void, kind: c_int, value: *mut Status) -> Status {
    // SAFETY: see the top of this file.
    unsafe {
        call(component, "fmi2GetStatus", AFTER_START, |c| {
            if kind != DO_STEP_STATUS {
                return no_status(kind);
            }
            write(value, if c.phase == Phase::Error { ERROR } else { OK })
        })
    }
}

/// End of the last successful step (s).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(component: *mut c_void, kind: c_int, value: *mut f64) -> Status {
    // SAFETY: see the top of this file.
    unsafe {
        call(component, "fmi2GetRealStatus", AFTER_START, |c| {
            if kind != LAST_SUCCESSFUL_TIME {
                return no_status(kind);
            }
            write(value, c.last_time)
        })
    }
}

/// There is no such status.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(
    component: *mut c_void,
    kind: c_int,
    _value: *mut c_int,
) -> Status {
    // SAFETY: see the top of this file.
    unsafe { call(component, "fmi2GetIntegerStatus", AFTER_START, |_| no_status(kind)) }
}

/// Whether the slave wants to end: never.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    component: *mut c_void,
    kind: c_int,
    value: *mut Boolean,
) -> Status {
    // SAFETY: see the top of this file.
    unsafe {
        call(component, "fmi2GetBooleanStatus", AFTER_START, |_| {
            if kind != TERMINATED {
                return no_status(kind);
            }
            write(value, 0)
        })
    }
}

/// There is no such status.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(
    component: *mut c_void,
    kind: c_int,
    _value: *mut *const c_char,
) -> Status {
    // SAFETY: see the top of this file.
    unsafe { call(component, "fmi2GetStringStatus", AFTER_START, |_| no_status(kind)) }
}
