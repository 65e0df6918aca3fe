//! The posterior of a fit of the plain model.

use super::{Density, Method, Peak, PosteriorError, Sample, SamplePlan, sample};
use crate::fit::{EvaluationFailure, Problem, SharedErrors};
use crate::inference::parameter::FitParameter;
use crate::inference::problem::ForceProblem;
use crate::inference::{Fit, Setup, Statistics};
use crate::noise::Covariance;
use nalgebra::DVector;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StudentT};

/// A sample in the variables as people count them (SI).
#[derive(Debug, Clone)]
pub struct Posterior {
    /// What the columns are.
    pub terms: Vec<FitParameter>,
    /// Values of each draw.
    pub draws: Vec<Vec<f64>>,
    /// How they were made, and what they are worth.
    pub sample: Sample,
}

/// exp(-chi^2 / 2), with what was known before, within the bounds; the errors of the data as large as the intervals take them.
struct ForceDensity<'a> {
    setup: Setup<'a>,
    problem: SharedErrors<'a, ForceProblem<'a>, Covariance>,
}

impl Density for ForceDensity<'_> {
    fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let (lower, upper) = self.setup.unknowns.bounds();
        (lower.to_vec(), upper.to_vec())
    }

    fn logarithms(&mut self, points: &[Vec<f64>]) -> Result<Vec<f64>, EvaluationFailure> {
        // All are started at once; where the model fails there is no density.
        self.problem.prefetch(points);
        let one = |x: &Vec<f64>| {
            let residual = EvaluationFailure::or_none(self.problem.residual(x))?;
            Ok(residual.map_or(f64::NEG_INFINITY, |r| -0.5 * r.iter().map(|r| r * r).sum::<f64>()))
        };
        points.iter().map(one).collect()
    }

    fn with_gradient(&mut self, x: &[f64]) -> Result<Option<(f64, Vec<f64>)>, EvaluationFailure> {
        let both = EvaluationFailure::or_none(self.problem.with_jacobian(x))?;
        Ok(both.map(|(residual, jacobian)| {
            let residual = DVector::from_vec(residual);
            let gradient = -jacobian.tr_mul(&residual);
            (-0.5 * residual.norm_squared(), gradient.as_slice().to_vec())
        }))
    }
}

/// A sample of the posterior around a fit. What no fit sees - the common height of the specimens - is drawn beside it, from Student's t
/// with the degrees of freedom that it was estimated with.
///
/// # Errors
/// When the user asked to stop, or the density cannot be sampled.
pub fn posterior(
    setup: Setup,
    fit: &Fit,
    statistics: &Statistics,
    plan: &SamplePlan,
) -> Result<Posterior, PosteriorError> {
    let measured = DVector::from_vec(setup.measured_mn());
    let forces = ForceProblem::new(setup, &[]);
    let prior = forces.prior();
    let problem = SharedErrors::new(forces, &statistics.covariance, measured, prior);
    let mut density = ForceDensity { setup, problem };
    let seen = statistics.of_what_a_fit_sees();
    let peak = Peak { mode: &fit.solution.x, covariance: &seen, bends: statistics.bends() };
    let found = sample(&mut density, peak, plan)?;
    let (terms, rows) = setup.unknowns.terms();
    let mut random = ChaCha8Rng::seed_from_u64(plan.seed.wrapping_add(1));
    let unseen = statistics.unseen_shifts();
    let mut draw = |x: &Vec<f64>| {
        let mut x = DVector::from_column_slice(x);
        for (shift, degrees) in &unseen {
            let normal: f64 = StandardNormal.sample(&mut random);
            let t = StudentT::new(*degrees).ok().filter(|_| degrees.is_finite());
            let height = t.map_or(normal, |t| t.sample(&mut random));
            x.axpy(height, shift, 1.0);
        }
        let values = &rows * x;
        terms.iter().zip(values.iter()).map(|(term, x)| term.to_value(*x)).collect()
    };
    let draws = found.draws.iter().map(&mut draw).collect();
    Ok(Posterior { terms, draws, sample: found })
}

impl Posterior {
    /// In words.
    pub fn in_words(&self) -> String {
        let s = &self.sample;
        let k_hat = format!("Pareto k-hat {:.2}", s.k_hat);
        match s.method {
            Method::Importance => format!(
                "{} draws by importance resampling ({k_hat}; worth {:.0} independent ones)",
                s.draws.len(),
                s.effective
            ),
            Method::Nuts => format!(
                "{} draws by NUTS, as importance weights cannot be trusted ({k_hat}); worth {:.0} independent ones, {} divergent",
                s.draws.len(),
                s.effective,
                s.divergent
            ),
        }
    }

    /// Quantile of a term, `p` from 0 to 1.
    pub fn quantile(&self, term: usize, p: f64) -> f64 {
        let mut values: Vec<f64> = self.draws.iter().map(|d| d[term]).collect();
        values.sort_by(f64::total_cmp);
        let place = (p * (values.len().saturating_sub(1)) as f64).round() as usize;
        values.get(place).copied().unwrap_or(f64::NAN)
    }
}
