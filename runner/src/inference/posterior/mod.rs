//! A sample of the posterior: what is known of all values together, without taking the model for straight.
//!
//! ```text
//! Fit -> Density (chi^2 with the prior, within the bounds)
//!     -> straightened (variables in which it is nearly a normal one)
//!     -> importance (draws around the optimum, weighed; Pareto k-hat says whether that works)
//!     -> nuts (where it does not) -> Sample
//! ```

mod force;
mod importance;
mod nuts;
mod pareto;
mod straightened;
#[cfg(test)]
mod tests;

pub use force::{Posterior, posterior};

use super::statistics::Bend;
use crate::fit::EvaluationFailure;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use straightened::Straightened;
use thiserror::Error;

/// Above this the variance of the importance weights is not known to be finite enough to trust them (Vehtari, Simpson, Gelman, Yao
/// and Gabry 2024).
pub const TRUSTED_K_HAT: f64 = 0.7;

/// A density that is sampled.
pub trait Density {
    /// Bounds of each variable, lower and upper.
    fn bounds(&self) -> (Vec<f64>, Vec<f64>);

    /// Logarithm of the density at several points within the bounds, up to a constant; minus infinity where there is none.
    ///
    /// # Errors
    /// When the user asked to stop.
    fn logarithms(&mut self, points: &[Vec<f64>]) -> Result<Vec<f64>, EvaluationFailure>;

    /// The same at one point with its gradient; `None` where there is none.
    ///
    /// # Errors
    /// When the user asked to stop.
    fn with_gradient(&mut self, x: &[f64]) -> Result<Option<(f64, Vec<f64>)>, EvaluationFailure>;
}

/// How a sample was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Draws around the optimum, weighed by the density.
    Importance,
    /// The No-U-Turn sampler.
    Nuts,
}

/// How many draws are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SamplePlan {
    /// Draws around the optimum that are weighed.
    pub proposals: usize,
    /// Draws of the sample.
    pub draws: usize,
    /// Draws by which NUTS finds its step.
    pub tuning: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Default for SamplePlan {
    fn default() -> Self {
        Self { proposals: 1000, draws: 500, tuning: 200, seed: 1 }
    }
}

/// The maximum of a density.
#[derive(Debug, Clone, Copy)]
pub struct Peak<'a> {
    /// Where it lies.
    pub mode: &'a [f64],
    /// Inverse of the curvature there.
    pub covariance: &'a DMatrix<f64>,
    /// Where its valley bends.
    pub bends: &'a [Bend],
}

/// Draws of equal weight.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// The variables of each draw.
    pub draws: Vec<Vec<f64>>,
    /// How they were made.
    pub method: Method,
    /// Shape of the tail of the importance weights.
    pub k_hat: f64,
    /// Independent draws that these are worth.
    pub effective: f64,
    /// Trajectories of NUTS that failed.
    pub divergent: usize,
}

/// A sample that could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PosteriorError {
    /// The model failed, or the user asked to stop.
    #[error(transparent)]
    Evaluation(#[from] EvaluationFailure),
    /// The optimum is no maximum, or the sampler cannot start there.
    #[error("the posterior cannot be sampled: {0}")]
    Sampler(String),
}

/// A sample of `density` around its maximum: by importance weights, and by NUTS where those cannot be trusted.
///
/// # Errors
/// When the user asked to stop, or the density cannot be sampled.
pub fn sample(
    density: &mut dyn Density,
    peak: Peak<'_>,
    plan: &SamplePlan,
) -> Result<Sample, PosteriorError> {
    let to = Straightened::new(&peak)?;
    let (weighed, heaviest) = importance::sample(density, &to, plan)?;
    if weighed.k_hat <= TRUSTED_K_HAT {
        return Ok(weighed);
    }
    let found = nuts::sample(density, &to, &heaviest, plan)?;
    Ok(Sample { k_hat: weighed.k_hat, ..found })
}
