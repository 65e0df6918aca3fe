//! The No-U-Turn sampler (Hoffman and Gelman 2014) by the crate `nuts-rs`, in variables without bounds and of unit size.
//!
//! `x = l + (u - l) / (1 + exp(-y))`, `y = y_mode + L z`: z is sampled, `L L'` the Laplace covariance of y.

use super::{Density, Method, Peak, PosteriorError, Sample, SamplePlan, root};
use crate::fit::EvaluationFailure;
use nalgebra::{DMatrix, DVector};
use nuts_rs::{Chain, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, LogpError, Settings};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::collections::HashMap;
use thiserror::Error;

/// A mode nearer to its bound than this part of the range is moved inwards: at the bound y is infinite.
const FROM_BOUND: f64 = 0.02;
/// A variable of which nothing is known fills its range: y then has about this variance (that of the logistic distribution).
const WHOLE_RANGE: f64 = 3.3;
/// The chain starts so far from the optimum, in units of its width.
const BESIDE: f64 = 0.1;
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

/// The change of variables.
#[derive(Clone)]
struct Variables {
    lower: Vec<f64>,
    upper: Vec<f64>,
    centre: DVector<f64>,
    root: DMatrix<f64>,
}

/// The density of z.
struct Whitened<'a> {
    density: &'a mut dyn Density,
    to: Variables,
}

impl Variables {
    fn new(
        (lower, upper): (Vec<f64>, Vec<f64>),
        mode: &[f64],
        covariance: &DMatrix<f64>,
    ) -> Result<Self, PosteriorError> {
        let inside = FROM_BOUND..=1.0 - FROM_BOUND;
        let share =
            |j: usize| ((mode[j] - lower[j]) / (upper[j] - lower[j])).clamp(*inside.start(), *inside.end());
        let n = mode.len();
        let centre = DVector::from_fn(n, |j, _| (share(j) / (1.0 - share(j))).ln());
        // dy / dx, and not more than the whole range.
        let stretch = DVector::from_fn(n, |j, _| {
            let per_x = 1.0 / ((upper[j] - lower[j]) * share(j) * (1.0 - share(j)));
            let variance = covariance[(j, j)] * per_x * per_x;
            per_x * (WHOLE_RANGE / variance).sqrt().min(1.0)
        });
        let covariance = DMatrix::from_fn(n, n, |i, j| stretch[i] * covariance[(i, j)] * stretch[j]);
        Ok(Self { lower, upper, centre, root: root(&covariance)? })
    }

    /// x and its shares of the ranges.
    fn point(&self, z: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let y = &self.centre + &self.root * DVector::from_column_slice(z);
        let shares: Vec<f64> = y.iter().map(|y| 1.0 / (1.0 + (-y).exp())).collect();
        let x = shares.iter().enumerate().map(|(j, s)| self.lower[j] + (self.upper[j] - self.lower[j]) * s);
        (x.collect(), shares)
    }
}

impl HasDims for Whitened<'_> {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        HashMap::from([("unconstrained_parameter".to_owned(), self.to.centre.len() as u64)])
    }
}

impl CpuLogpFunc for Whitened<'_> {
    type LogpError = Unavailable;
    type FlowParameters = ();
    type ExpandedVector = Vec<f64>;

    fn dim(&self) -> usize {
        self.to.centre.len()
    }

    fn logp(&mut self, z: &[f64], gradient: &mut [f64]) -> Result<f64, Unavailable> {
        let (x, shares) = self.to.point(z);
        let (value, slope) =
            self.density.with_gradient(&x).map_err(Unavailable::Stops)?.ok_or(Unavailable::Fails)?;
        let rate = |j: usize| (self.to.upper[j] - self.to.lower[j]) * shares[j] * (1.0 - shares[j]);
        let jacobian: f64 = (0..x.len()).map(|j| rate(j).ln()).sum();
        let along_y = DVector::from_fn(x.len(), |j, _| slope[j] * rate(j) + 1.0 - 2.0 * shares[j]);
        gradient.copy_from_slice(self.to.root.tr_mul(&along_y).as_slice());
        let total = value + jacobian;
        if total.is_finite() { Ok(total) } else { Err(Unavailable::Fails) }
    }

    fn expand_vector<R>(&mut self, _: &mut R, position: &[f64]) -> Result<Vec<f64>, CpuMathError>
    where
        R: nuts_rs::rand::Rng + ?Sized,
    {
        Ok(self.to.point(position).0)
    }
}

/// A sample by NUTS.
pub fn sample(
    density: &mut dyn Density,
    Peak { mode, covariance }: Peak<'_>,
    plan: &SamplePlan,
) -> Result<Sample, PosteriorError> {
    let wrong = |e: &dyn std::fmt::Display| PosteriorError::Sampler(e.to_string());
    let to = Variables::new(density.bounds(), mode, covariance)?;
    let whitened = Whitened { density, to: to.clone() };
    let settings = DiagNutsSettings {
        num_tune: plan.tuning as u64,
        num_draws: plan.draws as u64,
        maxdepth: DEEPEST,
        ..DiagNutsSettings::default()
    };
    let mut random = ChaCha8Rng::seed_from_u64(plan.seed);
    let mut chain = settings.new_chain(0, CpuMath::new(whitened), &mut random).map_err(|e| wrong(&e))?;
    // Beside the optimum: where the gradient vanishes the sampler cannot tell a step.
    chain.set_position(&vec![BESIDE; mode.len()]).map_err(|e| wrong(&e))?;
    let (mut draws, mut divergent) = (Vec::with_capacity(plan.draws), 0);
    for k in 0..plan.tuning + plan.draws {
        let (z, progress) = chain.draw().map_err(|e| wrong(&e))?;
        if k >= plan.tuning {
            draws.push(to.point(&z).0);
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
