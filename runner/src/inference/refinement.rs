//! The covariance of the data at the start of a fit, with the error of the simulation from another mesh and finer time steps.

use super::problem::ForceProblem;
use super::setup::{Setup, job};
use crate::fit::EvaluationFailure;
use crate::noise::{
    Common, NoiseModel, Observation, ObservationError, Uncertainty, Weights, noise_model, refinement,
};
use crate::pool::{Priority, Run};
use thiserror::Error;

const PRESET: &str = "mesh.preset";
const TOLERANCE: &str = "solver.tolerance";
/// The coarsest preset.
const COARSEST: f64 = 1.0;
/// A tolerance ten times smaller leaves a negligible error.
const TIGHTER: f64 = 0.1;

/// A parameter's new value from its old one.
type Change = fn(f64) -> f64;

/// A covariance that cannot be made.
#[derive(Debug, Error)]
pub enum NoiseFailure {
    /// The uncertainty that was asked for.
    #[error(transparent)]
    Observation(#[from] ObservationError),
    /// The user asked to stop.
    #[error(transparent)]
    Evaluation(#[from] EvaluationFailure),
}

/// Noise of the tests for the computed force where a fit starts; errors in proportion to it grow with what the fit computes. Where
/// the model fails there, the measured force stands for it.
///
/// # Errors
/// When the uncertainty asked for needs what a file does not have, or the user asked to stop.
pub fn noise_at_start(setup: Setup, weights: &Weights) -> Result<NoiseModel, NoiseFailure> {
    noise_at(setup, setup.unknowns.start(), weights, true)
}

/// The same for the computed force at `x`; `with_refinement`: with what another mesh and finer steps change there.
///
/// # Errors
/// As [`noise_at_start`].
pub fn noise_at(
    setup: Setup,
    x: &[f64],
    weights: &Weights,
    with_refinement: bool,
) -> Result<NoiseModel, NoiseFailure> {
    // With derivatives: the fit begins with the same runs.
    let derivatives = ForceProblem::new(setup, &[]).exact_columns() > 0;
    let runs = setup.submit(x, &[], derivatives, Priority::Urgent);
    let (reference, refined) = match Setup::computable_forces_mn(&runs)? {
        Some(forces) if with_refinement && weights.uncertainty != Uncertainty::None => {
            let refined = refined(setup, x, &forces)?;
            (forces, refined)
        }
        Some(forces) => (forces, vec![]),
        None => (setup.measured_mn(), vec![]),
    };
    Ok(noise_model(setup.observations, &reference, refined, weights)?)
}

/// Differences that the neighbouring mesh and finer steps make at `x`, where the force is `plain` (mN); none for an FMU without such
/// parameters. A run that fails adds nothing.
fn refined(setup: Setup, x: &[f64], plain: &[f64]) -> Result<Vec<Common>, EvaluationFailure> {
    let changes: [(&str, &str, Change); 2] = [
        // To the next coarser mesh the force changes as much as to the next finer one (0.25 and 0.2 % of the peak for the standard mesh),
        // at a sixth of the cost.
        ("mesh", PRESET, |preset| if preset > COARSEST { preset - 1.0 } else { preset + 1.0 }),
        ("time steps", TOLERANCE, |tolerance| tolerance * TIGHTER),
    ];
    let started = changes.iter().filter_map(|(name, parameter, change)| {
        let mut values = setup.unknowns.settings(x);
        let value = setup.value(&values, parameter)?;
        if change(value) == value {
            return None;
        }
        values.insert((*parameter).to_owned(), change(value));
        let start = |o: &Observation| setup.engine.submit(&job(o, &values), Priority::Urgent);
        Some((*name, setup.observations.iter().map(start).collect::<Vec<Run>>()))
    });
    // All at once: they keep two cores busy.
    let started: Vec<(&str, Vec<Run>)> = started.collect();
    let mut all = Vec::new();
    for (name, runs) in started {
        if let Some(fine) = Setup::computable_forces_mn(&runs)? {
            all.extend(refinement(&format!("simulation: {name}"), plain, &fine));
        }
    }
    Ok(all)
}
