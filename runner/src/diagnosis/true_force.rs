//! The force without noise, as all of the data and a model with its effects tell it: what predictions are compared with.
//!
//! What was measured is known; what of it is noise is not. The model's variables, the errors of its simulation and of its effects' form, and
//! the errors of the measurement share what is left of the data, each as much as all points together say. What the first three have is
//! force, the rest is noise. Where the size of errors is not known - it was estimated from few specimens, or is that of an error of the
//! simulation or of a form - it is drawn with them (Gibbs' sampler for Student's t; Geweke 1993).

use super::confirming::Refit;
use super::normal_equations::NormalEquations;
use crate::inference::effect::Candidate;
use crate::inference::fit::Fit;
use crate::noise::{Common, Covariance, Observation};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};

/// Seed of the draws.
const SEED: u64 = 17;
/// Number of draws of a noise.
pub const DRAWS: usize = 400;
/// Draws before the first that counts: far more than the few after which a variance has forgotten where it began.
const FORGOTTEN: usize = 50;
/// What is known of the size of the simulation's errors, and of a form's, before the data: what one other program, and one other law, had.
const DEGREES_OF_MODEL: f64 = 1.0;

/// Draws of measured minus true force (mN, all points), where the effects of a refit are what was found, and nature's law deviates from
/// theirs by the part `form`.
pub fn draws_of_noise_mn(
    refit: &Refit,
    observations: &[Observation],
    candidates: &[Candidate],
    form: f64,
) -> Vec<DVector<f64>> {
    let changes = refit.active(candidates).into_iter().zip(refit.changes_mn(candidates));
    let forms: Vec<_> = changes
        .filter_map(|(c, change_mn)| Some(c.effect.errors_of_form(observations, &change_mn?, form)))
        .filter(|errors| !errors.is_empty())
        .collect();
    TrueForce::new(&refit.fit, &forms).map_or_else(Vec::new, |force| force.noise_mn(DRAWS))
}

/// The posterior of what the measured force has beside the true one.
pub struct TrueForce {
    /// Measured minus computed at the optimum (mN).
    gap_mn: DVector<f64>,
    /// What each unknown adds to the force (mN); zero for errors of the measurement.
    force_mn: DMatrix<f64>,
    known: NormalEquations,
    /// Places among the unknowns of errors that have one size, and how well it is known (degrees of freedom).
    sizes: Vec<(Vec<usize>, f64)>,
}

impl TrueForce {
    /// Of a fit, each of whose effects may have another form than nature's by these errors, of one size; `None` where the normal equations
    /// cannot be solved.
    pub fn new(fit: &Fit, forms: &[Vec<Common>]) -> Option<Self> {
        let covariance: Covariance = fit.covariance.with(forms.concat());
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
        // Each of the measurement's errors has its own size, all of the simulation's have one.
        let before = fit.covariance.common();
        let (of_model, measured): (Vec<_>, Vec<_>) =
            before.iter().zip(variables..).partition(|(c, _)| c.of_model);
        let estimated = measured.iter().filter(|(c, _)| c.degrees.is_finite());
        let mut sizes: Vec<_> = estimated.map(|(c, k)| (vec![*k], c.degrees)).collect();
        sizes.push((of_model.iter().map(|(_, k)| *k).collect(), DEGREES_OF_MODEL));
        let mut next = variables + before.len();
        for form in forms {
            sizes.push(((next..next + form.len()).collect(), DEGREES_OF_MODEL));
            next += form.len();
        }
        Some(Self { gap_mn: fit.gap_mn.clone(), force_mn, known, sizes })
    }

    /// Draws of measured minus true force (mN, all points).
    pub fn noise_mn(&self, count: usize) -> Vec<DVector<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let normal = &self.known.normal;
        let mut at = self.known.solve(&self.gap_mn);
        let right = normal * &at;
        let mut draw = || {
            let mut precision = normal.clone();
            for (places, degrees) in &self.sizes {
                let square: f64 = places.iter().map(|&k| at[k] * at[k]).sum();
                let likely = ChiSquared::new(degrees + places.len() as f64).ok()?;
                let inverse_variance = likely.sample(&mut random) / (degrees + square);
                places.iter().for_each(|&k| precision[(k, k)] += inverse_variance - 1.0);
            }
            let precision = precision.cholesky()?;
            let beside = DVector::from_fn(right.len(), |_, _| StandardNormal.sample(&mut random));
            at = precision.solve(&right) + precision.l().transpose().solve_upper_triangular(&beside)?;
            Some(&self.gap_mn - &self.force_mn * &at)
        };
        (0..FORGOTTEN + count).filter_map(|_| draw()).skip(FORGOTTEN).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Prior, Solution};
    use crate::inference::Linearised;
    use crate::inference::fit::End;

    const POINTS: usize = 50;

    /// A constant fitted with little white noise, and an error of this shape (mN), where `gap_mn` is measured beyond the model: draws of the
    /// noise at the last point (mN).
    fn last_draws(gap_mn: &DVector<f64>, error: Common) -> Vec<f64> {
        let gap_mn = gap_mn.clone();
        let jacobian_mn = DMatrix::from_element(POINTS, 1, 1.0);
        let covariance = Covariance::new(DVector::from_element(POINTS, 0.01), vec![error]);
        let prior = Prior { mean: vec![0.0], deviation: vec![1e3] };
        let linear = Linearised::new(&jacobian_mn / 0.01, &(&gap_mn / 0.01));
        let solution = Solution::at_once(vec![2.0], gap_mn.as_slice().to_vec(), jacobian_mn.clone());
        let end = End::Minimum;
        let fit = Fit { solution, linear, gap_mn, jacobian_mn, parameters: 1, prior, covariance, end };
        let draws = TrueForce::new(&fit, &[]).unwrap().noise_mn(DRAWS);
        draws.iter().map(|noise| noise[POINTS - 1]).collect()
    }

    #[test]
    fn errors_of_the_measurement_are_noise_and_errors_of_the_model_are_force() {
        let half = DVector::from_fn(POINTS, |i, _| f64::from(u8::from(i >= POINTS / 2)));
        let mean = |of_model: bool| {
            let error = Common { of_model, ..Common::additive("half".into(), &half * 3.0) };
            last_draws(&half, error).iter().sum::<f64>() / DRAWS as f64
        };
        assert!((mean(false) - 1.0).abs() < 0.01);
        assert!(mean(true).abs() < 0.01);
    }

    /// Nothing tells an error that all points share from the constant: it is as likely as before.
    #[test]
    fn an_error_of_estimated_size_is_as_likely_as_student_s_t_says() {
        let beyond = |degrees: f64| {
            let shape_mn = DVector::from_element(POINTS, 3.0);
            let error = Common { degrees, ..Common::additive("height".into(), shape_mn) };
            let draws = last_draws(&DVector::zeros(POINTS), error);
            draws.iter().filter(|mn| mn.abs() > 2.92 * 3.0).count() as f64 / DRAWS as f64
        };
        // 0.1 with two degrees of freedom, 0.0035 of a normal one; four standard errors of the first.
        assert!((beyond(2.0) - 0.1).abs() < 0.06, "{}", beyond(2.0));
        assert!(beyond(f64::INFINITY) < 0.02, "{}", beyond(f64::INFINITY));
    }
}
