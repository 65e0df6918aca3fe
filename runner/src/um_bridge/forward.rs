//! Parameters in, force out, and what their derivatives do to vectors.

use super::Refusal;
use crate::fmi::Fmu;
use crate::pool::{FmuSimulator, ForceCurve, Job, RunFailure, Simulator, Wiring};
use crate::setting::{admissible, number_in, variable_named};
use poropunch::motion::protocol::Protocol;
use poropunch::variables::sensitivities;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Settings that a client sends with a request.
pub type Config = Map<String, Value>;

/// mN per N.
const MILLI: f64 = 1e3;

/// What is asked for: a motion, and the parameters that are its inputs.
#[derive(Debug, Clone)]
pub struct ForwardModel {
    /// Variables of the FMU, the derivatives of the force with them.
    pub wiring: Arc<Wiring>,
    /// Names of the inputs, in the order of the vector.
    pub parameters: Vec<String>,
    /// Values of parameters that are no inputs (SI).
    pub settings: BTreeMap<String, f64>,
    /// Motion of the punch.
    pub protocol: Arc<Protocol>,
    /// Times of the outputs (s).
    pub time_s: Arc<[f64]>,
}

impl ForwardModel {
    /// Whether the FMU has the derivative of the force by every input.
    pub fn has_derivatives(&self) -> bool {
        self.parameters.iter().all(|name| self.wiring.sensitivities.contains_key(name))
    }

    /// The job for an input, with settings that the client sent: numbers are SI, texts have units.
    fn job(&self, input: &[f64], config: &Config, derivatives: bool) -> Result<Job, Refusal> {
        let refused = |error: crate::setting::SettingError| Refusal::InvalidInput(error.to_string());
        let mut parameters = self.settings.clone();
        for (name, value) in config {
            let variable = variable_named(&self.wiring, name).map_err(refused)?;
            let number = match value {
                Value::Number(number) => admissible(variable, number.as_f64().unwrap_or(f64::NAN)),
                Value::String(text) => number_in(variable, text),
                Value::Bool(truth) => number_in(variable, &truth.to_string()),
                _ => {
                    let why = format!(
                        "config: {name} must be a number (SI) or a text with a unit, such as \"2 mm\""
                    );
                    return Err(Refusal::InvalidInput(why));
                }
            };
            parameters.insert(variable.name.clone(), number.map_err(refused)?);
        }
        if input.len() != self.parameters.len() {
            let (given, wanted) = (input.len(), self.parameters.join(", "));
            return Err(Refusal::InvalidInput(format!(
                "input[0] has {given} values; give those of {wanted}"
            )));
        }
        for (name, &value) in self.parameters.iter().zip(input) {
            let variable = variable_named(&self.wiring, name).map_err(refused)?;
            parameters.insert(name.clone(), admissible(variable, value).map_err(refused)?);
        }
        if derivatives {
            parameters.insert(sensitivities::SWITCH.to_owned(), 1.0);
        }
        Ok(Job { parameters, protocol: Arc::clone(&self.protocol), time_s: Arc::clone(&self.time_s) })
    }
}

/// A model with an instance of the FMU: one thread's.
pub struct Worker {
    /// What is asked for.
    pub model: ForwardModel,
    simulator: Box<dyn Simulator>,
    stop: Arc<AtomicBool>,
}

impl Worker {
    /// Instantiates the FMU; raising `stop` ends its runs.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn new(model: &ForwardModel, fmu: &Arc<Fmu>, stop: &Arc<AtomicBool>) -> Result<Self, RunFailure> {
        let simulator = FmuSimulator::new(fmu, &model.wiring, "um-bridge")?;
        Ok(Self::over(model, Box::new(simulator), stop))
    }

    /// The same over any simulator.
    pub fn over(model: &ForwardModel, simulator: Box<dyn Simulator>, stop: &Arc<AtomicBool>) -> Self {
        Self { model: model.clone(), simulator, stop: Arc::clone(stop) }
    }

    fn run(&mut self, job: &Job) -> Result<ForceCurve, Refusal> {
        let stop = Arc::clone(&self.stop);
        let ended = self.simulator.run(job, &|| stop.load(Ordering::Relaxed));
        ended.map_err(|failure| Refusal::ModelError(failure.to_string()))
    }

    /// Force (mN) at the times.
    ///
    /// # Errors
    /// When the input is not admissible or the model cannot make a step.
    pub fn evaluate(&mut self, input: &[f64], config: &Config) -> Result<Vec<f64>, Refusal> {
        let job = self.model.job(input, config, false)?;
        Ok(self.run(&job)?.force_n().iter().map(|force| MILLI * force).collect())
    }

    /// `sens^T J`: the gradient of the force's product with `sens`, one value per input (mN per SI unit).
    ///
    /// # Errors
    /// The same, or when `sens` has another length than the force.
    pub fn gradient(&mut self, input: &[f64], sens: &[f64], config: &Config) -> Result<Vec<f64>, Refusal> {
        check_length("sens", sens, self.model.time_s.len())?;
        let columns = self.jacobian(input, config)?;
        Ok(columns.iter().map(|column| column.iter().zip(sens).map(|(a, b)| a * b).sum()).collect())
    }

    /// `J vec`: the force's change along `vec`, one value per time (mN).
    ///
    /// # Errors
    /// The same, or when `vec` has another length than the input.
    pub fn apply_jacobian(
        &mut self,
        input: &[f64],
        vec: &[f64],
        config: &Config,
    ) -> Result<Vec<f64>, Refusal> {
        check_length("vec", vec, self.model.parameters.len())?;
        let columns = self.jacobian(input, config)?;
        let at = |time: usize| columns.iter().zip(vec).map(|(column, v)| column[time] * v).sum();
        Ok((0..self.model.time_s.len()).map(at).collect())
    }

    /// Derivatives of the force, one column per input (mN per SI unit).
    fn jacobian(&mut self, input: &[f64], config: &Config) -> Result<Vec<Vec<f64>>, Refusal> {
        if !self.model.has_derivatives() {
            return Err(Refusal::UnsupportedFeature);
        }
        let job = self.model.job(input, config, true)?;
        let curve = self.run(&job)?;
        let places =
            self.model.parameters.iter().filter_map(|name| self.model.wiring.sensitivities.get(name));
        let column = |&place: &usize| curve.values[place].iter().map(|d| MILLI * d).collect();
        Ok(places.map(column).collect())
    }
}

fn check_length(name: &str, values: &[f64], wanted: usize) -> Result<(), Refusal> {
    if values.len() == wanted {
        return Ok(());
    }
    Err(Refusal::InvalidInput(format!("{name} has {} values; give {wanted}", values.len())))
}
