//! Identification: fits the plain model's unknowns to measurements, and says what the result is worth.
//!
//! ```text
//! FitSettings -> Observations + Unknowns -> noise at the start -> search -> Identification -> FitReport
//! ```

pub mod nuisance;
pub mod profiles;
pub mod report;
pub mod settings;

pub use nuisance::{Corrected, Nuisances, identify_with_zeros};
pub use settings::{FitSettings, JacobianSource, SettingsError};

use crate::engine::Engine;
use crate::fit::{EvaluationFailure, FitError, IterationRecord};
use crate::inference::fit::search;
use crate::inference::robust::{Robust, robust};
use crate::inference::rough::{self, search_roughly};
use crate::inference::setup::job;
use crate::inference::{FitFailure, Found, NoiseFailure, SearchPlan, Setup, noise_at_start};
use crate::noise::{Covariance, NoiseModel, Observation, ObservationError, Weights};
use crate::pool::{ForceCurve, Priority, Run};
use poropunch::variables::sensitivities;
use std::collections::BTreeMap;
use std::sync::Arc;
use thiserror::Error;

/// What a fit gives.
#[derive(Debug)]
pub struct Identification {
    /// The best fit and the fate of each start.
    pub found: Found,
    /// Noise of the fitted tests.
    pub noise: NoiseModel,
    /// Points that count less in a robust fit.
    pub far_points: Option<usize>,
    /// Values of all parameters that were set, at the solution [FMU's units].
    pub values: BTreeMap<String, f64>,
}

/// An identification that cannot be made.
#[derive(Debug, Error)]
pub enum IdentificationError {
    /// A measurement, or its noise.
    #[error(transparent)]
    Observation(#[from] ObservationError),
    /// The fit.
    #[error(transparent)]
    Fit(#[from] FitError),
}

impl From<NoiseFailure> for IdentificationError {
    fn from(failure: NoiseFailure) -> Self {
        match failure {
            NoiseFailure::Observation(error) => error.into(),
            NoiseFailure::Evaluation(failure) => FitFailure::from(failure).into(),
        }
    }
}

impl From<EvaluationFailure> for IdentificationError {
    fn from(failure: EvaluationFailure) -> Self {
        FitFailure::from(failure).into()
    }
}

impl From<FitFailure> for IdentificationError {
    fn from(failure: FitFailure) -> Self {
        Self::Fit(match failure {
            FitFailure::Fit(error) => error,
            FitFailure::Evaluation(EvaluationFailure::Failed(reason)) => FitError::StartFailed(reason),
            FitFailure::Evaluation(EvaluationFailure::Interrupted) => FitError::Interrupted,
        })
    }
}

/// Fits, and where asked for once more with points that lie far off counting less; `observe` sees each accepted step with the index of
/// its start. A stop asked of the engine ends the fit at its best point.
///
/// # Errors
/// When no start can be evaluated, or the noise cannot be told.
pub fn identify(
    setup: Setup,
    weights: &Weights,
    plan: &SearchPlan,
    is_robust: bool,
    observe: &mut dyn FnMut(usize, &IterationRecord),
) -> Result<Identification, IdentificationError> {
    let noise = noise_at_start(setup, weights)?;
    let found = searched(setup, &noise.covariance, plan, observe)?;
    concluded(setup, noise, found, plan, is_robust)
}

/// The best fit of all starts.
fn searched(
    setup: Setup,
    covariance: &Covariance,
    plan: &SearchPlan,
    observe: &mut dyn FnMut(usize, &IterationRecord),
) -> Result<Found, FitFailure> {
    let by = if rough::applies(setup) { search_roughly } else { search };
    by(setup, covariance, plan, observe)
}

/// The robust fit where it was asked for, and what all parameters are.
fn concluded(
    setup: Setup,
    noise: NoiseModel,
    mut found: Found,
    plan: &SearchPlan,
    is_robust: bool,
) -> Result<Identification, IdentificationError> {
    let mut far_points = None;
    if is_robust && found.fit.solution.stop.converged() {
        let covariance = found.fit.covariance.clone();
        let Robust { fit, far } = robust(setup, &covariance, found.fit, plan.evaluations)?;
        (found.fit, found.twin, far_points) = (fit, None, Some(far));
    }
    let values = setup.unknowns.settings(&found.fit.solution.x);
    Ok(Identification { found, noise, far_points, values })
}

/// Curves of the tests with given parameter values, by runs with or without derivatives; those that failed say why.
pub fn curves(
    engine: &Engine,
    observations: &[Observation],
    values: &BTreeMap<String, f64>,
    derivatives: bool,
) -> Vec<Result<Arc<ForceCurve>, String>> {
    let mut values = values.clone();
    if derivatives {
        values.insert(sensitivities::SWITCH.to_owned(), 1.0);
    }
    let start = |o: &Observation| engine.submit(&job(o, &values), Priority::Urgent);
    let runs: Vec<Run> = observations.iter().map(start).collect();
    runs.iter().map(|run| run.wait().map_err(|e| e.to_string())).collect()
}
