//! Steps, with what happens within them and at their ends.
// SAFETY of all functions here: as in life.rs.
#![allow(clippy::missing_safety_doc, clippy::too_many_arguments)]

use super::Modes;
use super::abi::{Boolean, ValueReference};
use crate::guard::{ERROR, OK, Status, call, entry_points, write};
use crate::phase::{EVENT, GETTABLE, INTERMEDIATE, Phase, STEP_COMPLETE};
use poropunch::cosimulation::{Leg, Progress};
use poropunch::motion::Stops;
use std::ffi::c_void;

const DO_STEP: &str = "fmi3DoStep";

/// Makes one step. Where the master allows it, the step ends early at a corner of the built-in motion and where contact
/// is made or lost. Never answers `fmi3Discard`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    current_time: f64,
    step_size: f64,
    _no_set_state_prior_to_current_point: Boolean,
    event_handling_needed: *mut Boolean,
    terminate_simulation: *mut Boolean,
    early_return: *mut Boolean,
    last_successful_time: *mut f64,
) -> Status {
    let mut begun = None;
    // SAFETY: see the top of this file.
    let status = unsafe {
        call(instance, DO_STEP, STEP_COMPLETE, |c| {
            // Left so by a failure or a panic.
            c.phase = Phase::Error;
            let modes = c.modes.ok_or("an instance of FMI 2.0")?;
            c.check_end(current_time + step_size)?;
            begun = Some((modes, c.slave.leg(current_time, step_size).map_err(|e| e.to_string())?));
            let answers = [event_handling_needed, terminate_simulation, early_return];
            answers.into_iter().try_for_each(|place| write(place, 0))?;
            write(last_successful_time, current_time)?;
            c.phase = Phase::StepComplete;
            Ok(())
        })
    };
    let Some((modes, mut leg)) = begun.filter(|_| status == OK) else { return ERROR };
    let stops = Stops { events: modes.early_return, steps: modes.intermediate_update.is_some() };
    // SAFETY: see the top of this file. No reference to the instance lives while the master is called back.
    unsafe {
        if modes.gives_displacement && ask(instance, &modes, &mut leg) != OK {
            return ERROR;
        }
        loop {
            let mut made = None;
            let status = call(instance, DO_STEP, STEP_COMPLETE, |c| {
                c.phase = Phase::Error;
                let progress = c.slave.go(&mut leg, stops).map_err(|e| e.to_string())?;
                c.last_time = progress.time;
                c.phase = Phase::StepComplete;
                c.logger.event(|| format!("step to {} s: {:?}", progress.time, progress.reached));
                made = Some(progress);
                Ok(())
            });
            let Some(progress) = made.filter(|_| status == OK) else { return ERROR };
            let mut ends = progress.is_end || stops.events && progress.reached.is_event();
            ends |= tell(instance, &modes, &progress);
            if ends {
                let is_event = modes.events && progress.reached.is_event();
                *event_handling_needed = Boolean::from(is_event);
                *early_return = Boolean::from(!progress.is_end);
                *last_successful_time = progress.time;
                return OK;
            }
        }
    }
}

/// Asks the master for the displacement at the end of the step.
///
/// # Safety
/// As [`call`]; the callback is the master's.
unsafe fn ask(instance: *mut c_void, modes: &Modes, leg: &mut Leg) -> Status {
    let Some(update) = modes.intermediate_update else { return OK };
    let mut asks = false;
    // SAFETY: the caller's promise.
    unsafe {
        let status = call(instance, DO_STEP, STEP_COMPLETE, |c| {
            asks = c.slave.follows_inputs();
            if asks {
                c.phase = Phase::IntermediateUpdate;
                c.modes = Some(Modes { gave_displacement: false, ..*modes });
            }
            Ok(())
        });
        if status != OK || !asks {
            return status;
        }
        update(modes.environment, leg.end(), 1, 0, 0, 0, &mut 0, &mut 0.0);
        call(instance, DO_STEP, INTERMEDIATE, |c| {
            c.phase = Phase::StepComplete;
            if c.modes.is_some_and(|modes| modes.gave_displacement) {
                c.slave.aim(leg);
            }
            Ok(())
        })
    }
}

/// Tells the master how far a step is, which may read variables then; whether it wants to end it here.
///
/// # Safety
/// As [`call`]; the callback is the master's.
unsafe fn tell(instance: *mut c_void, modes: &Modes, progress: &Progress) -> bool {
    let Some(update) = modes.intermediate_update else { return false };
    let may_end = modes.early_return && !progress.is_end;
    let (mut ends, mut at) = (0, progress.time);
    let phase = |phase| {
        // SAFETY: the caller's promise.
        unsafe {
            call(instance, DO_STEP, &[Phase::StepComplete, Phase::IntermediateUpdate], |c| {
                c.phase = phase;
                Ok(())
            })
        }
    };
    phase(Phase::IntermediateUpdate);
    // SAFETY: the callback is the master's; the places live here.
    unsafe { update(modes.environment, progress.time, 0, 1, 1, Boolean::from(may_end), &mut ends, &mut at) };
    phase(Phase::StepComplete);
    may_end && ends != 0
}

entry_points! {
    /// Nothing needs another round; the next corner of the built-in motion is the next event.
    fn fmi3UpdateDiscreteStates(
        discrete_states_need_update: *mut Boolean,
        terminate_simulation: *mut Boolean,
        nominals_changed: *mut Boolean,
        values_changed: *mut Boolean,
        next_event_time_defined: *mut Boolean,
        next_event_time: *mut f64,
    ) in EVENT, |c| {
        let no = [discrete_states_need_update, terminate_simulation, nominals_changed, values_changed];
        no.into_iter().try_for_each(|place| write(place, 0))?;
        let corner = c.slave.next_corner();
        write(next_event_time_defined, Boolean::from(corner.is_some()))?;
        write(next_event_time, corner.unwrap_or_default())
    };

    /// There are no discrete states to evaluate.
    fn fmi3EvaluateDiscreteStates() in EVENT, |_| Ok(());

    /// Not offered (`maxOutputDerivativeOrder` is 0).
    fn fmi3GetOutputDerivatives(
        _references: *const ValueReference,
        n: usize,
        _orders: *const i32,
        _values: *mut f64,
        _n_values: usize,
    ) in GETTABLE, |_| {
        let reason = "this FMU has no output derivatives (maxOutputDerivativeOrder = 0)";
        if n == 0 { Ok(()) } else { Err(reason.to_owned()) }
    };
}
