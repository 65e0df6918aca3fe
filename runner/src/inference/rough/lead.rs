//! The way to where a fit by the model asked for begins.

use super::correction::{Goal, corrected, difference_mn};
use super::twin::Twin;
use crate::fit::{EvaluationFailure, IterationRecord, Solution, minimise};
use crate::inference::effect::Candidate;
use crate::inference::fit::{Fit, FitFailure, problem};
use crate::inference::problem::ForceProblem;
use crate::inference::setup::Setup;
use crate::noise::Covariance;
use crate::pool::Priority;
use std::ops::ControlFlow;

/// Where a rougher model leads.
pub(in crate::inference) struct Led {
    /// Parameters and magnitudes, and the chi^2 that is expected there.
    pub solution: Solution,
    /// chi^2 of the model asked for where it began.
    pub chi_square_before: f64,
    /// The rougher model, corrected where it led, if that is a minimum of it.
    pub twin: Option<Twin>,
}

/// The roughest model, corrected at parameters and magnitudes `x`; none where there is none, or one of the two fails there.
///
/// # Errors
/// When the user asked to stop.
pub fn leading_at(setup: Setup, active: &[&Candidate], x: &[f64]) -> Result<Option<Twin>, EvaluationFailure> {
    let Some(twin) = Twin::leading(setup, active) else { return Ok(None) };
    let offset_mn = difference_mn(setup, twin.setup(setup), active, x)?;
    Ok(offset_mn.map(|offset_mn| Twin { offset_mn, ..twin }))
}

/// The model on the coarsest mesh, corrected at a fit of the plain model asked for; none where there is none, or it fails there.
///
/// # Errors
/// When the user asked to stop.
pub fn coarser_at(
    setup: Setup,
    candidates: &[Candidate],
    plain: &Fit,
) -> Result<Option<Twin>, EvaluationFailure> {
    let Some(twin) = Twin::coarser(setup, candidates) else { return Ok(None) };
    let problem = ForceProblem::new(twin.setup(setup), &[]);
    let runs = problem.submit(plain.x(), problem.exact_columns() > 0, Priority::Urgent);
    let coarse_mn = Setup::computable_forces_mn(&runs)?;
    let measured_mn = setup.measured_mn();
    let asked_mn = measured_mn.iter().zip(plain.gap_mn.iter()).map(|(measured, gap)| measured - gap);
    let offset_mn = coarse_mn.map(|coarse_mn| asked_mn.zip(coarse_mn).map(|(a, c)| a - c).collect());
    Ok(offset_mn.map(|offset_mn| Twin { offset_mn, ..twin }))
}

/// Where a fit by the roughest model ends, which is corrected at the start and again until it foresees the model asked for; none where
/// one of them fails.
///
/// # Errors
/// When the user asked to stop.
pub(in crate::inference) fn lead(
    setup: Setup,
    active: &[&Candidate],
    covariance: &Covariance,
    start: &[f64],
    goal: Goal,
    watch: &mut dyn FnMut(&IterationRecord) -> ControlFlow<()>,
) -> Result<Option<Led>, EvaluationFailure> {
    let Some(twin) = leading_at(setup, active, start)? else { return Ok(None) };
    let mut problem = problem(twin.setup(setup), active, covariance);
    let led = minimise(&mut problem, start, goal.bounds, goal.options, watch).map_err(FitFailure::from);
    let led = led.and_then(|first| {
        let chi_square_before = first.iterations.first().map_or(f64::INFINITY, |record| record.chi_square);
        let (solution, twin) = corrected(setup, (&twin, active), covariance, goal, first, watch)?;
        Ok(Led { solution, chi_square_before, twin })
    });
    match led {
        _ if setup.engine.is_stopped() => Err(EvaluationFailure::Interrupted),
        led => Ok(led.ok()),
    }
}
