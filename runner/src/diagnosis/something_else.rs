//! The competitor that stands for everything outside the catalogue: a smooth error of any shape.
//!
//! A Gaussian process over the cycle and the logarithm of the time since touch, as hat functions with independent
//! normal heights of deviation `a`, of which only what no refit absorbs counts: `y ~ N(0, P + a^2 B B')` with
//! `B = P inv(L) hats`. Its evidence against no gap is `a^2 v'(1 + a^2 G)^-1 v - ln det(1 + a^2 G)`, `v = B'y`,
//! `G = B'B`, averaged over `a`.

use super::unsure_noise::{UnsureNoise, twice_log_sum};
use crate::inference::Linearised;
use crate::noise::{Covariance, Observation, hats};
use nalgebra::{DMatrix, DVector};

/// Hats per decade of time.
const PER_DECADE: f64 = 2.0;
/// Deviations that are averaged over (mN): from next to nothing to a gap that everybody sees.
const DEVIATIONS_MN: [f64; 7] = [0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6];

/// What a smooth error explains of a residual.
#[derive(Debug, Clone)]
pub struct SomethingElse {
    /// Twice the log evidence against no gap.
    pub evidence: f64,
    /// Squared size of the smooth part of the residual, in units of the noise.
    pub explained: f64,
    /// The smooth part itself, whitened.
    pub smooth: DVector<f64>,
}

/// Of the residual of a fit.
pub fn something_else(
    observations: &[Observation],
    fit: &Linearised,
    covariance: &Covariance,
) -> SomethingElse {
    let total: usize = observations.iter().map(Observation::len).sum();
    let mut columns: Vec<DVector<f64>> = Vec::new();
    let mut before = 0;
    for o in observations {
        for hat in (0..o.cycles.len()).flat_map(|c| hats(o, c, PER_DECADE)) {
            let mut d = DVector::zeros(total);
            d.rows_mut(before, o.len()).copy_from(&hat);
            columns.push(fit.signature(covariance, &d).s);
        }
        before += o.len();
    }
    let (b, y) = (DMatrix::from_columns(&columns), &fit.residual);
    let found = of_columns(&b, y);
    let evidence = |square, product: &_| Heights::of(square, product).evidence;
    let change = UnsureNoise::around(fit, covariance).change_of_evidence(&b, y, &evidence);
    SomethingElse { evidence: found.evidence + change, ..found }
}

/// What a residual tells of the columns' heights.
struct Heights {
    /// Twice the log evidence.
    evidence: f64,
    /// Most likely.
    heights: DVector<f64>,
}

impl Heights {
    /// From the products of the columns with each other and with the residual.
    fn of(square: DMatrix<f64>, product: &DVector<f64>) -> Self {
        let eigen = square.symmetric_eigen();
        let v = eigen.eigenvectors.tr_mul(product);
        let at = |a: f64| -> f64 {
            let one = |(g, v): (&f64, &f64)| {
                let g = g.max(0.0);
                a * a * v * v / (1.0 + a * a * g) - (a * a * g).ln_1p()
            };
            eigen.eigenvalues.iter().zip(v.iter()).map(one).sum()
        };
        let all = DEVIATIONS_MN.map(at);
        let (best, _) = DEVIATIONS_MN
            .iter()
            .zip(all)
            .fold((0.0, f64::NEG_INFINITY), |top, (a, e)| if e > top.1 { (*a, e) } else { top });
        let evidence = twice_log_sum(all.iter().copied()) - 2.0 * (DEVIATIONS_MN.len() as f64).ln();
        let heights = DVector::from_fn(v.len(), |k, _| {
            best * best * v[k] / (1.0 + best * best * eigen.eigenvalues[k].max(0.0))
        });
        Self { evidence, heights: &eigen.eigenvectors * heights }
    }
}

fn of_columns(b: &DMatrix<f64>, y: &DVector<f64>) -> SomethingElse {
    let Heights { evidence, heights } = Heights::of(b.tr_mul(b), &b.tr_mul(y));
    let smooth = b * heights;
    SomethingElse { evidence, explained: smooth.norm_squared(), smooth }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;

    fn columns() -> DMatrix<f64> {
        DMatrix::from_fn(60, 6, |i, k| (1.0 - (i as f64 / 10.0 - k as f64).abs()).max(0.0) * 30.0)
    }

    #[test]
    fn a_smooth_error_is_told_from_noise() {
        let b = columns();
        for seed in 0..50 {
            let mut random = Random::new(seed);
            let noise = DVector::from_fn(60, |_, _| random.normal());
            let nothing = of_columns(&b, &noise);
            assert!(nothing.evidence < 6.0, "{}", nothing.evidence);
            let gap = noise + b.column(2) * 0.2 - b.column(4) * 0.15;
            let something = of_columns(&b, &gap);
            assert!(something.evidence > 30.0, "{}", something.evidence);
            let truth = b.column(2) * 0.2 - b.column(4) * 0.15;
            assert!((something.smooth - &truth).norm() < 0.3 * truth.norm());
        }
    }

    #[test]
    fn the_evidence_of_one_hat_is_that_of_a_normal_magnitude() {
        let b = DMatrix::from_element(1, 1, 2.0);
        let y = DVector::from_element(1, 3.0);
        let density = |v: f64| (-0.5 * 9.0 / v).exp() / v.sqrt();
        let mean: f64 = DEVIATIONS_MN.iter().map(|a| density(1.0 + 4.0 * a * a)).sum::<f64>() / 7.0;
        let expected = 2.0 * (mean / density(1.0)).ln();
        assert!((of_columns(&b, &y).evidence - expected).abs() < 1e-9);
    }
}
