//! Runs jobs on one instance of an FMU, reset between jobs.

use super::job::{ForceCurve, Job, RunFailure};
use super::wiring::{Drive, Port, Wiring};
use super::workers::Simulator;
use crate::fmi::{FmiError, Fmu, FmuInstance, ScalarVariable, VariableKind};
use poropunch::motion::protocol::Protocol;
use std::sync::Arc;

/// Without derivatives or velocity, the punch moves at most this part of its reach per step.
const LARGEST_HELD_MOVE: f64 = 5e-3;

/// One FMU instance and how to drive it.
pub struct FmuSimulator {
    fmu: Arc<Fmu>,
    wiring: Arc<Wiring>,
    name: String,
    instance: Option<FmuInstance>,
}

impl FmuSimulator {
    /// Instantiates the FMU.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn new(fmu: &Arc<Fmu>, wiring: &Arc<Wiring>, name: &str) -> Result<Self, RunFailure> {
        let mut simulator =
            Self { fmu: Arc::clone(fmu), wiring: Arc::clone(wiring), name: name.to_owned(), instance: None };
        simulator.instance = Some(simulator.fresh_instance()?);
        Ok(simulator)
    }

    /// An instance in the state after instantiation. One that cannot be reset is replaced.
    fn fresh_instance(&mut self) -> Result<FmuInstance, RunFailure> {
        if let Some(mut instance) = self.instance.take()
            && instance.reset().is_ok()
        {
            return Ok(instance);
        }
        self.fmu.instantiate(&self.name).map_err(|e| RunFailure::Engine(e.to_string()))
    }
}

impl Simulator for FmuSimulator {
    fn run(&mut self, job: &Job, cancelled: &dyn Fn() -> bool) -> Result<ForceCurve, RunFailure> {
        let mut instance = self.fresh_instance()?;
        let result = simulate(&mut instance, &self.wiring, job, cancelled);
        self.instance = Some(instance);
        result
    }
}

fn simulate(
    instance: &mut FmuInstance,
    wiring: &Wiring,
    job: &Job,
    cancelled: &dyn Fn() -> bool,
) -> Result<ForceCurve, RunFailure> {
    let protocol = &job.protocol;
    let start = protocol.start_time();
    set_parameters(instance, wiring, job)?;
    for (reference, text) in &wiring.texts {
        attempt(instance, |i| i.set_string(&[*reference], &[text]))?;
    }
    attempt(instance, |i| i.setup_experiment(start, None))?;
    attempt(instance, FmuInstance::enter_initialization_mode)?;
    set_input(instance, &wiring.input, protocol.displacement(start))?;
    attempt(instance, FmuInstance::exit_initialization_mode)?;

    let mut curve = ForceCurve {
        names: wiring.outputs.iter().map(|p| p.name.clone()).collect(),
        values: vec![Vec::with_capacity(job.time_s.len()); wiring.outputs.len()],
        ..ForceCurve::default()
    };
    let mut time = start;
    for &target in job.time_s.iter() {
        for (until, _) in protocol.breakpoints_between(time, target).iter().copied().chain([(target, 0.0)]) {
            advance(instance, wiring, protocol, time, until, cancelled)?;
            time = until;
        }
        record(instance, wiring, protocol, target, &mut curve)?;
    }
    if !wiring.texts.is_empty() {
        // What the FMU writes ends here.
        attempt(instance, FmuInstance::terminate)?;
    }
    Ok(curve)
}

fn set_parameters(instance: &mut FmuInstance, wiring: &Wiring, job: &Job) -> Result<(), RunFailure> {
    if let Some((source, inputs)) = wiring.follow_input() {
        attempt(instance, |i| set_number(i, source, inputs))?;
    }
    for (name, &value) in &job.parameters {
        let Some(variable) = wiring.parameters.get(name) else {
            return Err(RunFailure::Model(format!("the FMU has no parameter `{name}`")));
        };
        attempt(instance, |i| set_number(i, variable, value))?;
    }
    Ok(())
}

/// Moves the punch along one straight piece of the protocol.
fn advance(
    instance: &mut FmuInstance,
    wiring: &Wiring,
    protocol: &Protocol,
    from: f64,
    to: f64,
    cancelled: &dyn Fn() -> bool,
) -> Result<(), RunFailure> {
    if to <= from {
        return Ok(());
    }
    let (begin, end) = (protocol.displacement(from), protocol.displacement(to));
    let velocity = (end - begin) / (to - from);
    let pieces = match wiring.drive {
        Drive::Steps => {
            let reach = protocol.points().iter().fold(f64::MIN_POSITIVE, |r, p| r.max(p.1.abs()));
            ((end - begin).abs() / (LARGEST_HELD_MOVE * reach)).ceil().max(1.0)
        }
        _ => 1.0,
    };
    let step = (to - from) / pieces;
    let mut time = from;
    for piece in 1..=pieces as usize {
        if cancelled() {
            return Err(RunFailure::Cancelled);
        }
        let next = if piece as f64 == pieces { to } else { from + piece as f64 * step };
        match wiring.drive {
            Drive::Derivative => {
                set_input(instance, &wiring.input, protocol.displacement(time))?;
                let (references, rate) = ([wiring.input.reference], [velocity / wiring.input.factor]);
                attempt(instance, |i| i.set_input_derivatives(&references, &[1], &rate))?;
            }
            Drive::Rate { reference, factor } => {
                set_input(instance, &wiring.input, protocol.displacement(time))?;
                attempt(instance, |i| i.set_real(&[reference], &[velocity / factor]))?;
            }
            Drive::Steps => {
                set_input(instance, &wiring.input, protocol.displacement(0.5 * (time + next)))?;
            }
        }
        attempt(instance, |i| i.do_step(time, next - time))?;
        time = next;
    }
    Ok(())
}

fn record(
    instance: &mut FmuInstance,
    wiring: &Wiring,
    protocol: &Protocol,
    time: f64,
    curve: &mut ForceCurve,
) -> Result<(), RunFailure> {
    curve.time_s.push(time);
    curve.displacement_m.push(protocol.displacement(time));
    let references: Vec<u32> = wiring.outputs.iter().map(|p| p.reference).collect();
    let read = attempt(instance, |i| i.get_real(&references))?;
    for ((series, port), value) in curve.values.iter_mut().zip(&wiring.outputs).zip(read) {
        if !value.is_finite() {
            let name = &port.name;
            return Err(RunFailure::Model(format!("output `{name}` is not a finite number at {time} s")));
        }
        series.push(port.factor * value);
    }
    Ok(())
}

fn set_input(instance: &mut FmuInstance, input: &Port, displacement_m: f64) -> Result<(), RunFailure> {
    attempt(instance, |i| i.set_real(&[input.reference], &[displacement_m / input.factor]))
}

/// Sets a variable of any type to a number (Booleans: 0 or 1).
fn set_number(instance: &mut FmuInstance, variable: &ScalarVariable, value: f64) -> Result<(), FmiError> {
    let reference = [variable.value_reference];
    match variable.kind {
        VariableKind::Real => instance.set_real(&reference, &[value]),
        VariableKind::Boolean => instance.set_boolean(&reference, &[value != 0.0]),
        VariableKind::Integer | VariableKind::Enumeration => {
            instance.set_integer(&reference, &[value as i32])
        }
        VariableKind::String => Err(FmiError::NotSupported("set texts as numbers")),
    }
}

/// A call whose failure is the model's answer where it says so itself (`fmi2Discard`, `fmi2Error`), with what the FMU
/// logged; after a fatal error, or one of the loader, another try may succeed.
fn attempt<T>(
    instance: &mut FmuInstance,
    call: impl FnOnce(&mut FmuInstance) -> Result<T, FmiError>,
) -> Result<T, RunFailure> {
    call(instance).map_err(|error| match error {
        error if error.is_verdict() => RunFailure::Model(error.to_string()),
        other => RunFailure::Engine(other.to_string()),
    })
}
