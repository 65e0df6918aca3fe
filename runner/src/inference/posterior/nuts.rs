//! The No-U-Turn sampler (Hoffman and Gelman 2014) by the crate `nuts-rs`, in straightened variables. Beyond a bound lies the mirror image of
//! what is within it, so that trajectories are reflected there.

use super::straightened::Straightened;
use super::{Density, Method, PosteriorError, Sample, SamplePlan};
use crate::fit::EvaluationFailure;
use nalgebra::DVector;
use nuts_rs::{Chain, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, LogpError, Settings};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::collections::HashMap;
use thiserror::Error;

/// Doublings of a trajectory at most: in variables of unit size a quarter of a turn takes few steps.
const DEEPEST: u64 = 6;

/// Where the density is not to be had.
#[derive(Debug, Error)]
enum Unavailable {
    /// The model fails there: the trajectory ends.
    #[error("the model fails")]
    Fails,
    /// The user asked to stop.
    #[error("{0}")]
    Stops(EvaluationFailure),
}

impl LogpError for Unavailable {
    fn is_recoverable(&self) -> bool {
        matches!(self, Self::Fails)
    }
}

/// The density of z.
struct Whitened<'a> {
    density: &'a mut dyn Density,
    bounds: (Vec<f64>, Vec<f64>),
    to: &'a Straightened,
}

impl HasDims for Whitened<'_> {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        HashMap::from([("unconstrained_parameter".to_owned(), self.to.len() as u64)])
    }
}

impl CpuLogpFunc for Whitened<'_> {
    type LogpError = Unavailable;
    type FlowParameters = ();
    type ExpandedVector = Vec<f64>;

    fn dim(&self) -> usize {
        self.to.len()
    }

    fn logp(&mut self, z: &[f64], gradient: &mut [f64]) -> Result<f64, Unavailable> {
        let z = DVector::from_column_slice(z);
        let (x, directions) = self.to.mirrored(&z, &self.bounds);
        let (value, mut slope) =
            self.density.with_gradient(&x).map_err(Unavailable::Stops)?.ok_or(Unavailable::Fails)?;
        slope.iter_mut().zip(directions).for_each(|(slope, direction)| *slope *= direction);
        gradient.copy_from_slice(self.to.gradient(&z, &slope).as_slice());
        if value.is_finite() { Ok(value) } else { Err(Unavailable::Fails) }
    }

    fn expand_vector<R>(&mut self, _: &mut R, position: &[f64]) -> Result<Vec<f64>, CpuMathError>
    where
        R: nuts_rs::rand::Rng + ?Sized,
    {
        Ok(self.to.mirrored(&DVector::from_column_slice(position), &self.bounds).0)
    }
}

/// A sample by NUTS from a point with a density.
pub fn sample(
    density: &mut dyn Density,
    to: &Straightened,
    start: &DVector<f64>,
    plan: &SamplePlan,
) -> Result<Sample, PosteriorError> {
    let wrong = |e: &dyn std::fmt::Display| PosteriorError::Sampler(e.to_string());
    let bounds = density.bounds();
    let whitened = Whitened { density, bounds: bounds.clone(), to };
    let settings = DiagNutsSettings {
        num_tune: plan.tuning as u64,
        num_draws: plan.draws as u64,
        maxdepth: DEEPEST,
        ..DiagNutsSettings::default()
    };
    let mut random = ChaCha8Rng::seed_from_u64(plan.seed);
    let mut chain = settings.new_chain(0, CpuMath::new(whitened), &mut random).map_err(|e| wrong(&e))?;
    chain.set_position(start.as_slice()).map_err(|e| wrong(&e))?;
    let (mut draws, mut divergent) = (Vec::with_capacity(plan.draws), 0);
    for k in 0..plan.tuning + plan.draws {
        let (z, progress) = chain.draw().map_err(|e| wrong(&e))?;
        if k >= plan.tuning {
            draws.push(to.mirrored(&DVector::from_column_slice(&z), &bounds).0);
            divergent += usize::from(progress.diverging);
        }
    }
    let effective = effective(&draws);
    Ok(Sample { draws, method: Method::Nuts, k_hat: f64::NAN, effective, divergent })
}

/// Independent draws that a chain is worth in its least well mixed variable (Geyer's initial positive sequence).
fn effective(draws: &[Vec<f64>]) -> f64 {
    let n = draws.len();
    let of = |j: usize| {
        let mean = draws.iter().map(|d| d[j]).sum::<f64>() / n as f64;
        let covariance = |lag: usize| {
            (lag..n).map(|i| (draws[i][j] - mean) * (draws[i - lag][j] - mean)).sum::<f64>() / n as f64
        };
        let variance = covariance(0);
        if variance <= 0.0 {
            return n as f64;
        }
        let pairs = (0..n / 2).map(|k| (covariance(2 * k) + covariance(2 * k + 1)) / variance);
        let time = 2.0 * pairs.take_while(|pair| *pair > 0.0).sum::<f64>() - 1.0;
        n as f64 / time.max(1.0)
    };
    (0..draws.first().map_or(0, Vec::len)).map(of).fold(n as f64, f64::min)
}
