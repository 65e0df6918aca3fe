//! The force without noise, as all of the data and a model with its effects tell it: what predictions are compared with.
//!
//! What was measured is known; what of it is noise is not. The model's variables, the errors of its simulation and of its effects' form, and
//! the errors of the measurement share what is left of the data, each as much as all points together say. What the first three have is
//! force, the rest is noise.

use super::confirming::Refit;
use super::normal_equations::NormalEquations;
use crate::data::random::Random;
use crate::inference::effect::{Candidate, is_continuous};
use crate::inference::fit::Fit;
use crate::noise::{Common, Covariance, Observation, form_errors};
use nalgebra::{DMatrix, DVector};

/// Seed of the draws.
const SEED: u64 = 17;
/// Number of draws of a noise.
pub const DRAWS: usize = 400;

/// Draws of measured minus true force (mN, all points), where the effects of a refit are what was found, and nature's law deviates from
/// theirs by the part `form`.
pub fn draws_of_noise_mn(
    refit: &Refit,
    observations: &[Observation],
    candidates: &[Candidate],
    form: f64,
) -> Vec<DVector<f64>> {
    let fit = &refit.fit;
    let magnitudes = refit.members.iter().filter(|k| is_continuous(&candidates[**k]));
    let columns = fit.jacobian_mn.columns_range(fit.parameters..);
    let changes = magnitudes.zip(columns.column_iter()).zip(fit.magnitudes());
    // A number has no other form.
    let laws = changes.filter(|((k, _), _)| !candidates[**k].effect.is_a_number);
    let form =
        laws.flat_map(|((_, column), magnitude)| form_errors(observations, &(column * *magnitude), form));
    TrueForce::new(fit, form.collect()).map_or_else(Vec::new, |force| force.noise_mn(DRAWS))
}

/// The posterior of what the measured force has beside the true one.
pub struct TrueForce {
    /// Measured minus computed at the optimum (mN).
    gap_mn: DVector<f64>,
    /// What each unknown adds to the force (mN); zero for errors of the measurement.
    force_mn: DMatrix<f64>,
    known: NormalEquations,
}

impl TrueForce {
    /// Of a fit, whose effects may have another form than nature's by `form`; `None` where the normal equations cannot be solved.
    pub fn new(fit: &Fit, form: Vec<Common>) -> Option<Self> {
        let covariance: Covariance = fit.covariance.with(form);
        let (points, variables) = fit.jacobian_mn.shape();
        let common = covariance.common();
        let mut force_mn = DMatrix::zeros(points, variables + common.len());
        force_mn.columns_mut(0, variables).copy_from(&fit.jacobian_mn);
        let mut all = force_mn.clone();
        for (k, c) in common.iter().enumerate() {
            all.set_column(variables + k, &c.shape_mn);
            if c.of_model {
                force_mn.set_column(variables + k, &c.shape_mn);
            }
        }
        let known = NormalEquations::new(fit, all, covariance.white_mn())?;
        Some(Self { gap_mn: fit.gap_mn.clone(), force_mn, known })
    }

    /// Draws of measured minus true force (mN, all points).
    pub fn noise_mn(&self, count: usize) -> Vec<DVector<f64>> {
        let mut random = Random::new(SEED);
        let mean = self.known.solve(&self.gap_mn);
        let upper = self.known.precision.l().transpose();
        let mut draw = || {
            let normal = DVector::from_fn(mean.len(), |_, _| random.normal());
            let beside = upper.solve_upper_triangular(&normal)?;
            Some(&self.gap_mn - &self.force_mn * (&mean + beside))
        };
        (0..count).filter_map(|_| draw()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Prior, Solution};
    use crate::inference::Linearised;

    const POINTS: usize = 50;

    /// A constant fitted to a constant of 2, an error of the measurement or of the model in the second half, and no other noise.
    fn second_half(of_model: bool) -> f64 {
        let half = DVector::from_fn(POINTS, |i, _| f64::from(u8::from(i >= POINTS / 2)));
        let error = Common { of_model, ..Common::additive("half".into(), half.clone() * 3.0) };
        let gap_mn = half;
        let jacobian_mn = DMatrix::from_element(POINTS, 1, 1.0);
        let covariance = Covariance::new(DVector::from_element(POINTS, 0.01), vec![error]);
        let prior = Prior { mean: vec![0.0], deviation: vec![1e3] };
        let linear = Linearised::new(&jacobian_mn / 0.01, &(&gap_mn / 0.01));
        let solution = Solution::at_once(vec![2.0], gap_mn.as_slice().to_vec(), jacobian_mn.clone());
        let is_at_minimum = true;
        let fit =
            Fit { solution, linear, gap_mn, jacobian_mn, parameters: 1, prior, covariance, is_at_minimum };
        let draws = TrueForce::new(&fit, vec![]).unwrap().noise_mn(200);
        draws.iter().map(|noise| noise[POINTS - 1]).sum::<f64>() / 200.0
    }

    #[test]
    fn errors_of_the_measurement_are_noise_and_errors_of_the_model_are_force() {
        assert!((second_half(false) - 1.0).abs() < 0.01);
        assert!(second_half(true).abs() < 0.01);
    }
}
