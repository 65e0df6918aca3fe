//! The way to where a fit by the model asked for begins.

use super::correction::{corrected, difference_mn};
use super::twin::Twin;
use crate::fit::{Bounds, EvaluationFailure, IterationRecord, Options, minimise};
use crate::inference::effect::Candidate;
use crate::inference::fit::{FitFailure, problem};
use crate::inference::setup::Setup;
use crate::noise::Covariance;
use std::ops::ControlFlow;

/// Where a rougher model leads.
pub(in crate::inference) struct Led {
    /// Parameters and magnitudes.
    pub x: Vec<f64>,
    /// chi^2 of the model asked for where it began.
    pub chi_square_before: f64,
    /// chi^2 that is expected where it led.
    pub chi_square: f64,
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

/// Where a fit by the roughest model ends, which is corrected at the start and again until it foresees the model asked for; none where
/// one of them fails.
///
/// # Errors
/// When the user asked to stop.
pub(in crate::inference) fn lead(
    setup: Setup,
    active: &[&Candidate],
    covariance: &Covariance,
    (start, bounds): (&[f64], &Bounds),
    options: &Options,
    watch: &mut dyn FnMut(&IterationRecord) -> ControlFlow<()>,
) -> Result<Option<Led>, EvaluationFailure> {
    let Some(twin) = leading_at(setup, active, start)? else { return Ok(None) };
    let mut problem = problem(twin.setup(setup), active, covariance);
    let led = minimise(&mut problem, start, bounds, options, watch).map_err(FitFailure::from);
    let led = led.and_then(|first| {
        let chi_square_before = first.iterations.first().map_or(f64::INFINITY, |record| record.chi_square);
        let (last, _) = corrected(setup, (&twin, active), covariance, bounds, first, options, watch)?;
        Ok(Led { x: last.x, chi_square_before, chi_square: last.chi_square })
    });
    match led {
        _ if setup.engine.is_stopped() => Err(EvaluationFailure::Interrupted),
        led => Ok(led.ok()),
    }
}
