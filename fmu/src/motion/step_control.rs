//! Lengths of the steps: the first one after a change of velocity or a touch, and those that follow from the error.

use crate::solver::parameters::SolverParameters;
use libm::cbrt;

/// A step grows by at most this factor.
const MAX_GROWTH: f64 = 2.0;
/// A step shrinks, after an excessive error, by at most this factor.
const MAX_SHRINK: f64 = 0.25;
/// Ratio of the error to the misfit of the extrapolation: 0.04 for an SDIRK2 step, and up to this for the
/// interpolation between its ends.
const ERROR_CONSTANT: f64 = 0.1;
/// A step is repeated when its estimated error exceeds the tolerance by this factor.
const REJECT: f64 = 8.0;
/// Where a communication point follows close behind a touch, the first step is still this fraction of the free one.
const LEAST_FIRST: f64 = 0.125;
/// A slower punch stands still (m/s): hosts that trap floating-point exceptions see no division by zero, not even
/// one that the optimiser makes before its condition.
pub(super) const STANDING: f64 = 1e-30;
/// A smaller error of a step is none.
const NO_ERROR: f64 = 1e-12;

/// Estimated error of a step over the tolerance, from the misfit of the extrapolation and the scale of what it predicts.
pub(super) fn error(misfit: f64, scale: f64, tolerance: f64) -> f64 {
    ERROR_CONSTANT * misfit / (scale * tolerance)
}

/// Whether a step of this error is repeated.
pub(super) fn is_excessive(error: f64) -> bool {
    error > REJECT
}

/// Ratio of its length when it is.
pub(super) fn shrinkage(error: f64) -> f64 {
    (0.8 / cbrt(error)).max(MAX_SHRINK)
}

/// Ratio of the next step to one of this error, where it is known.
pub(super) fn growth(error: Option<f64>) -> f64 {
    error.map_or(MAX_GROWTH, |e| (0.9 / cbrt(e.max(NO_ERROR))).clamp(MAX_SHRINK, MAX_GROWTH))
}

/// Length of the first step (s) after the velocity changed by `change` (m/s), or after a touch at that velocity,
/// `left` (s) before a communication point.
///
/// Half of what is left, for between the first two nodes there is only a line; but where next to nothing is left
/// after a touch, not so short that many steps had to grow out of it.
pub(super) fn first_step(solver: &SolverParameters, change: f64, left: f64, is_touch: bool) -> f64 {
    let free = solver.initial_increment / change.max(STANDING);
    let least = if is_touch && change > STANDING { LEAST_FIRST * free } else { 0.0 };
    free.min((0.5 * left).max(least))
}
