//! The covariance of the data at the start of a fit, with the error of the simulation from another mesh and finer time steps.

use super::problem::ForceProblem;
use super::rough::{self, Twin};
use super::setup::{Setup, job};
use crate::fit::EvaluationFailure;
use crate::noise::{
    Common, NoiseModel, Observation, ObservationError, Uncertainty, Weights, noise_model, refinement,
};
use crate::pool::{Priority, Run};
use std::collections::BTreeMap;
use thiserror::Error;

const PRESET: &str = "mesh.preset";
const TOLERANCE: &str = "solver.tolerance";
/// The coarsest preset.
const COARSEST: f64 = 1.0;
/// A tolerance ten times smaller leaves a negligible error.
const TIGHTER: f64 = 0.1;

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
    noise(setup, setup.unknowns.start(), weights, (true, !rough::applies(setup)))
}

/// The same for the computed force at `x`, where a fit that may be led begins; `with_refinement`: with what another mesh and finer steps
/// change there.
///
/// # Errors
/// As [`noise_at_start`].
pub fn noise_at(
    setup: Setup,
    x: &[f64],
    weights: &Weights,
    with_refinement: bool,
) -> Result<NoiseModel, NoiseFailure> {
    noise(setup, x, weights, (with_refinement, Twin::leading(setup, &[]).is_none()))
}

/// `begins_fit`: whether a fit begins with the same runs, and wants their derivatives.
fn noise(
    setup: Setup,
    x: &[f64],
    weights: &Weights,
    (with_refinement, begins_fit): (bool, bool),
) -> Result<NoiseModel, NoiseFailure> {
    let derivatives = begins_fit && ForceProblem::new(setup, &[]).exact_columns() > 0;
    let runs = setup.submit(x, &[], derivatives, Priority::Urgent);
    let is_refined = with_refinement && weights.uncertainty != Uncertainty::None;
    // All at once: they keep two cores busy.
    let others = is_refined.then(|| Refined::begin(setup, x));
    let (reference, refined) = match (Setup::computable_forces_mn(&runs)?, others) {
        (Some(forces), Some(others)) => {
            let refined = others.differences(&forces)?;
            (forces, refined)
        }
        (Some(forces), None) => (forces, vec![]),
        (None, _) => (setup.measured_mn(), vec![]),
    };
    Ok(noise_model(setup.observations, &reference, refined, weights)?)
}

/// Runs with the neighbouring mesh, and with finer steps; none for an FMU without such parameters.
struct Refined {
    neighbour: Option<Vec<Run>>,
    tighter: Option<Vec<Run>>,
    /// Whether the finer steps are the neighbouring mesh's.
    is_coarser: bool,
}

impl Refined {
    /// Starts the runs at `x`.
    fn begin(setup: Setup, x: &[f64]) -> Self {
        let values = setup.unknowns.settings(x);
        let submit = |values: &BTreeMap<String, f64>| -> Vec<Run> {
            let start = |o: &Observation| setup.engine.submit(&job(o, values), Priority::Urgent);
            setup.observations.iter().map(start).collect()
        };
        let (preset, tolerance) = (setup.value(&values, PRESET), setup.value(&values, TOLERANCE));
        // To the next coarser mesh the force changes as much as to the next finer one (0.25 and 0.2 % of the peak for the standard mesh),
        // at a sixth of the cost.
        let neighbour = preset.map(|preset| {
            let other = if preset > COARSEST { preset - 1.0 } else { preset + 1.0 };
            let mut values = values.clone();
            values.insert(PRESET.to_owned(), other);
            values
        });
        // What steps leave depends little on the mesh: the coarser one tells it.
        let is_coarser = preset.is_some_and(|preset| preset > COARSEST);
        let cheaper = neighbour.as_ref().filter(|_| is_coarser).unwrap_or(&values);
        let tighter = tolerance.map(|tolerance| {
            let mut values = cheaper.clone();
            values.insert(TOLERANCE.to_owned(), tolerance * TIGHTER);
            values
        });
        Self { neighbour: neighbour.as_ref().map(submit), tighter: tighter.as_ref().map(submit), is_coarser }
    }

    /// What they change, where the force is `plain` (mN). A run that fails adds nothing.
    fn differences(self, plain: &[f64]) -> Result<Vec<Common>, EvaluationFailure> {
        let forces =
            |runs: Option<Vec<Run>>| runs.map_or(Ok(None), |runs| Setup::computable_forces_mn(&runs));
        let (neighbour, tighter) = (forces(self.neighbour)?, forces(self.tighter)?);
        let with_steps = if self.is_coarser { neighbour.as_deref() } else { Some(plain) };
        let mesh = neighbour.as_deref().and_then(|other| refinement("simulation: mesh", plain, other));
        let steps = with_steps.zip(tighter.as_deref());
        let steps = steps.and_then(|(coarse, fine)| refinement("simulation: time steps", coarse, fine));
        Ok(mesh.into_iter().chain(steps).collect())
    }
}
