//! What every evaluation of the model needs, and runs of all tests at given unknowns.

use super::effect::Candidate;
use super::unknowns::Unknowns;
use crate::engine::Engine;
use crate::fit::EvaluationFailure;
use crate::noise::Observation;
use crate::pool::{ForceCurve, Job, Priority, Run, RunFailure};
use poropunch::variables::sensitivities;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What every evaluation needs.
#[derive(Clone, Copy)]
pub struct Setup<'a> {
    /// Runs the model.
    pub engine: &'a Engine,
    /// What was measured.
    pub observations: &'a [Observation],
    /// What is fitted besides the effects.
    pub unknowns: &'a Unknowns,
    /// Finite-difference step of a variable (relative, of log variables) where the FMU offers no derivative.
    pub step: f64,
    /// Added to the force that the model computes (mN), at the points of all tests; empty: nothing.
    pub offset_mn: &'a [f64],
}

/// Usual finite-difference step: a hundredth, far above the error of a run and small against any curvature.
pub const STEP: f64 = 0.01;

/// Curves of all tests.
pub type Curves = Vec<Arc<ForceCurve>>;

impl<'a> Setup<'a> {
    /// With the usual step.
    pub fn new(engine: &'a Engine, observations: &'a [Observation], unknowns: &'a Unknowns) -> Self {
        Self { engine, observations, unknowns, step: STEP, offset_mn: &[] }
    }

    /// Values of a test's run, and those before the effects were applied.
    pub fn values(
        &self,
        x: &[f64],
        active: &[(&Candidate, f64)],
        test: usize,
    ) -> (BTreeMap<String, f64>, BTreeMap<String, f64>) {
        let plain = self.unknowns.settings(x);
        let mut values = plain.clone();
        for (candidate, magnitude) in active {
            // An effect on a parameter that nobody set starts from the FMU's own value.
            for name in &candidate.effect.parameters {
                if let Some(value) = self.value(&values, name) {
                    values.insert(name.clone(), value);
                }
            }
            candidate.apply(&mut values, test, *magnitude);
        }
        (values, plain)
    }

    /// Starts the runs of all tests at variables `x` with effects of given magnitudes.
    pub fn submit(
        &self,
        x: &[f64],
        active: &[(&Candidate, f64)],
        derivatives: bool,
        priority: Priority,
    ) -> Vec<Run> {
        let run = |(test, observation): (usize, &Observation)| {
            let (mut values, _) = self.values(x, active, test);
            if derivatives {
                values.insert(sensitivities::SWITCH.to_owned(), 1.0);
            }
            self.engine.submit(&job(observation, &values), priority)
        };
        self.observations.iter().enumerate().map(run).collect()
    }

    /// Force of all tests, test by test (mN).
    ///
    /// # Errors
    /// When a run fails.
    pub fn forces_mn(runs: &[Run]) -> Result<Vec<f64>, EvaluationFailure> {
        let curves = runs.iter().map(wait).collect::<Result<Curves, _>>()?;
        Ok(curves.iter().flat_map(|c| c.force_n().iter().map(|f| f * 1e3).collect::<Vec<_>>()).collect())
    }

    /// The same, `None` where the model fails at these parameters.
    ///
    /// # Errors
    /// When the user asked to stop.
    pub fn computable_forces_mn(runs: &[Run]) -> Result<Option<Vec<f64>>, EvaluationFailure> {
        EvaluationFailure::or_none(Self::forces_mn(runs))
    }

    /// Value that a parameter has among those that are set: theirs, or the FMU's own.
    pub fn value(&self, values: &BTreeMap<String, f64>, name: &str) -> Option<f64> {
        let start = || self.engine.wiring().parameters.get(name).and_then(|v| v.start_number());
        values.get(name).copied().or_else(start)
    }

    /// Measured force of all tests (mN).
    pub fn measured_mn(&self) -> Vec<f64> {
        self.observations.iter().flat_map(Observation::force_mn).collect()
    }

    /// Whether the FMU computes the derivatives by every variable.
    pub fn is_differentiable(&self) -> bool {
        let (u, recorded) = (self.unknowns, &self.engine.wiring().sensitivities);
        let has = |j| u.slopes(u.start(), j).iter().all(|(name, _)| recorded.contains_key(name));
        (0..u.len()).all(has)
    }
}

/// The run that predicts a test with the given parameter values (SI).
pub fn job(observation: &Observation, parameters: &BTreeMap<String, f64>) -> Job {
    Job {
        parameters: parameters.clone(),
        protocol: Arc::clone(&observation.protocol),
        time_s: Arc::clone(&observation.time_s),
    }
}

/// The curve of a run, or why the evaluation failed.
///
/// # Errors
/// When the run failed or was cancelled.
pub fn wait(run: &Run) -> Result<Arc<ForceCurve>, EvaluationFailure> {
    run.wait().map_err(|failure| match failure {
        RunFailure::Cancelled => EvaluationFailure::Interrupted,
        other => EvaluationFailure::Failed(other.to_string()),
    })
}
