//! Robust fits: a point that lies far from the rest counts less (Huber's loss by reweighting).
//!
//! A point whose difference, beyond what the errors that many points share account for, is `r > 2` of its white deviations has its
//! deviation raised by `sqrt(r / 2)`: its pull on the fit no longer grows with its distance.

use super::fit::{Fit, FitFailure, refit};
use super::setup::Setup;
use super::statistics::white_residual;
use crate::data::estimate::deviation_of_sizes;
use crate::noise::Covariance;

/// Differences beyond so many deviations count less; of normal noise one of twenty-two.
const FAR: f64 = 2.0;
/// Rounds of reweighting at most; each changes the weights less than the one before.
const ROUNDS: usize = 6;
/// Weights that change by less are settled.
const SETTLED: f64 = 0.05;

/// A robust fit.
#[derive(Debug, Clone)]
pub struct Robust {
    /// The fit, with the raised deviations in its covariance.
    pub fit: Fit,
    /// Points that count less.
    pub far: usize,
}

/// From a fit by least squares with `covariance`.
///
/// # Errors
/// When the user asked to stop, or the model fails at the fit.
pub fn robust(
    setup: Setup,
    covariance: &Covariance,
    fit: Fit,
    evaluations: usize,
) -> Result<Robust, FitFailure> {
    let mut factors = vec![1.0; fit.gap_mn.len()];
    let mut fit = fit;
    for _ in 0..ROUNDS {
        // In units of the deviations that the noise gave.
        let own = white_residual(&fit);
        let sizes: Vec<f64> = own.iter().zip(&factors).map(|(r, f)| (r * f).abs()).collect();
        let spread = deviation_of_sizes(&mut sizes.clone());
        let unit = if covariance.is_known() { spread.max(1.0) } else { spread.max(f64::MIN_POSITIVE) };
        let next: Vec<f64> = sizes.iter().map(|r| (r / (FAR * unit)).max(1.0).sqrt()).collect();
        let change = next.iter().zip(&factors).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        if change < SETTLED {
            break;
        }
        factors = next;
        let start = fit.solution.x.clone();
        let earlier = fit.solution.iterations;
        fit = refit(setup, &covariance.with_white_times(&factors), &start, evaluations)?;
        fit.solution.go_on_from(earlier);
    }
    let far = factors.iter().filter(|f| **f > 1.0).count();
    Ok(Robust { fit, far })
}
