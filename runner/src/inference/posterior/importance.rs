//! Draws from Student's t around the optimum, weighed by the density over that of the proposal, and resampled.

use super::pareto::smoothed;
use super::straightened::Straightened;
use super::{Density, Method, PosteriorError, Sample, SamplePlan};
use nalgebra::DVector;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};

/// Degrees of freedom of the proposal: its tails are heavier than those of any posterior that is nearly normal.
const DEGREES: f64 = 7.0;

/// A sample by importance weights, whatever their k-hat, and the straightened variables of the draw of largest weight.
pub fn sample(
    density: &mut dyn Density,
    to: &Straightened,
    plan: &SamplePlan,
) -> Result<(Sample, DVector<f64>), PosteriorError> {
    let mut random = ChaCha8Rng::seed_from_u64(plan.seed);
    let chi_squared = ChiSquared::new(DEGREES).map_err(|e| PosteriorError::Sampler(e.to_string()))?;
    let (n, (lower, upper)) = (to.len(), density.bounds());
    let mut points = Vec::with_capacity(plan.proposals);
    let mut proposal = Vec::with_capacity(plan.proposals);
    let mut straight = Vec::with_capacity(plan.proposals);
    for _ in 0..plan.proposals {
        let z = DVector::from_fn(n, |_, _| StandardNormal.sample(&mut random));
        let z: DVector<f64> = z * (DEGREES / chi_squared.sample(&mut random)).sqrt();
        proposal.push(-0.5 * (DEGREES + n as f64) * (z.norm_squared() / DEGREES).ln_1p());
        points.push(to.x(&z));
        straight.push(z);
    }
    let is_inside =
        |x: &[f64]| x.iter().zip(lower.iter().zip(&upper)).all(|(x, (l, u))| (l..=u).contains(&x));
    let inside: Vec<usize> = (0..points.len()).filter(|&i| is_inside(&points[i])).collect();
    let asked: Vec<Vec<f64>> = inside.iter().map(|&i| points[i].clone()).collect();
    let mut logarithms = vec![f64::NEG_INFINITY; points.len()];
    for (i, value) in inside.iter().zip(density.logarithms(&asked)?) {
        logarithms[*i] = value - proposal[*i];
    }
    let heaviest = (0..points.len()).max_by(|a, b| logarithms[*a].total_cmp(&logarithms[*b]));
    let Some(heaviest) = heaviest.filter(|i| logarithms[*i].is_finite()) else {
        let nowhere = "the model cannot be computed anywhere near the optimum";
        return Err(PosteriorError::Sampler(nowhere.to_owned()));
    };
    let (weights, k_hat) = smoothed(&logarithms);
    let effective = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
    let draws = resampled(&weights, plan.draws).into_iter().map(|i| points[i].clone()).collect();
    let sample = Sample { draws, method: Method::Importance, k_hat, effective, divergent: 0 };
    Ok((sample, straight.swap_remove(heaviest)))
}

/// Systematic resampling: so many draws, each point as often as its weight says but for less than one.
fn resampled(weights: &[f64], draws: usize) -> Vec<usize> {
    let (mut all, mut sum) = (Vec::with_capacity(draws), 0.0);
    for (i, weight) in weights.iter().enumerate() {
        sum += weight;
        while all.len() < draws && (all.len() as f64 + 0.5) / (draws as f64) < sum {
            all.push(i);
        }
    }
    all
}
