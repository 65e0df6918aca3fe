//! The 9 functions of co-simulation (`fmi2Functions.h`).
// SAFETY of all functions here: as in common.rs.
#![allow(clippy::missing_safety_doc)]

use super::abi::{Boolean, ValueReference};
use crate::guard::{ERROR, OK, Outcome, Status, entry_points, slice, write};
use crate::phase::{AFTER_START, ANY, Phase, SETTABLE, STEP_COMPLETE};
use std::ffi::{c_char, c_int, c_void};

entry_points! {
    /// Sets the velocity of the punch for the next step: first derivative of `displacement`.
    fn fmi2SetRealInputDerivatives(
        references: *const ValueReference,
        n: usize,
        orders: *const c_int,
        values: *const f64,
    ) in SETTABLE, |c| {
        let (references, orders, values) = (slice(references, n)?, slice(orders, n)?, slice(values, n)?);
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            c.slave.set_input_derivative(reference, order, value).map_err(|e| e.to_string())?;
        }
        Ok(())
    };

    /// Not offered (`maxOutputDerivativeOrder` is 0).
    fn fmi2GetRealOutputDerivatives(
        _references: *const ValueReference,
        n: usize,
        _orders: *const c_int,
        _values: *mut f64,
    ) in AFTER_START, |_| {
        let reason = "this FMU has no output derivatives (maxOutputDerivativeOrder = 0)";
        if n == 0 { Ok(()) } else { Err(reason.to_owned()) }
    };

    /// Makes one step. Never answers `fmi2Discard`: masters loop on it for ever.
    fn fmi2DoStep(
        current_time: f64,
        step_size: f64,
        _no_set_state_prior_to_current_point: Boolean,
    ) in STEP_COMPLETE, |c| {
        // Left so by a failure or a panic.
        c.phase = Phase::Error;
        c.check_end(current_time + step_size)?;
        c.slave.step(current_time, step_size).map_err(|e| e.to_string())?;
        c.last_time = current_time + step_size;
        c.phase = Phase::StepComplete;
        c.logger.event(|| format!("step to {} s", c.last_time));
        Ok(())
    };

    /// Steps are synchronous: there is never one to cancel.
    fn fmi2CancelStep() in ANY, |_| {
        Err("no step is in progress: fmi2DoStep never returns fmi2Pending".to_owned())
    };
}

const DO_STEP_STATUS: c_int = 0;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

fn no_status(kind: c_int) -> Outcome {
    Err(format!("status {kind} is not of this type, or only exists for asynchronous steps"))
}

entry_points! {
    /// Status of the last step.
    fn fmi2GetStatus(kind: c_int, value: *mut Status) in AFTER_START, |c| {
        if kind != DO_STEP_STATUS {
            return no_status(kind);
        }
        write(value, if c.phase == Phase::Error { ERROR } else { OK })
    };

    /// End of the last successful step (s).
    fn fmi2GetRealStatus(kind: c_int, value: *mut f64) in AFTER_START, |c| {
        if kind != LAST_SUCCESSFUL_TIME {
            return no_status(kind);
        }
        write(value, c.last_time)
    };

    /// There is no such status.
    fn fmi2GetIntegerStatus(kind: c_int, _value: *mut c_int) in AFTER_START, |_| no_status(kind);

    /// Whether the slave wants to end: never.
    fn fmi2GetBooleanStatus(kind: c_int, value: *mut Boolean) in AFTER_START, |_| {
        if kind != TERMINATED {
            return no_status(kind);
        }
        write(value, 0)
    };

    /// There is no such status.
    fn fmi2GetStringStatus(kind: c_int, _value: *mut *const c_char) in AFTER_START, |_| no_status(kind);
}
