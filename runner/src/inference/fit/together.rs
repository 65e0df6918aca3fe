//! One set of values for tests that run with different settings, such as another punch.

use super::{FitFailure, options};
use crate::fit::{EvaluationFailure, Problem, SharedErrors, minimise};
use crate::inference::effect::Candidate;
use crate::inference::problem::ForceProblem;
use crate::inference::setup::Setup;
use crate::noise::Covariance;
use nalgebra::{DMatrix, DVector};

/// Residuals of all parts, one after the other.
struct Together<'a> {
    parts: Vec<SharedErrors<'a, ForceProblem<'a>, Covariance>>,
    /// How many each part has.
    rows: Vec<usize>,
}

impl Problem for Together<'_> {
    fn dimension(&self) -> usize {
        self.parts.first().map_or(0, Problem::dimension)
    }

    fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
        let all: Vec<Vec<f64>> =
            self.parts.iter_mut().map(|part| part.residual(x)).collect::<Result<_, _>>()?;
        self.rows = all.iter().map(Vec::len).collect();
        Ok(all.concat())
    }

    fn jacobian(&mut self, x: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
        let mut all = DMatrix::zeros(r.len(), x.len());
        let mut before = 0;
        for (part, &rows) in self.parts.iter_mut().zip(&self.rows) {
            all.rows_mut(before, rows).copy_from(&part.jacobian(x, &r[before..before + rows])?);
            before += rows;
        }
        Ok(all)
    }

    fn prefetch(&mut self, points: &[Vec<f64>]) {
        self.parts.iter_mut().for_each(|part| part.prefetch(points));
    }

    fn rejected(&mut self, x: &[f64]) {
        self.parts.iter_mut().for_each(|part| part.rejected(x));
    }
}

/// Least chi^2 of the model with the effects `active` over all of these tests. What is known of the values before counts once.
///
/// # Errors
/// When the model fails at the start, or the user asked to stop before it was evaluated.
pub fn least_chi_square<'a>(
    tests: &[(Setup<'a>, &'a Covariance)],
    active: &[&'a Candidate],
    start: &[f64],
    evaluations: usize,
) -> Result<f64, FitFailure> {
    let Some((first, _)) = tests.first() else { return Ok(0.0) };
    let bounds = ForceProblem::new(*first, active).bounds()?;
    let mut parts = Vec::new();
    for &(setup, covariance) in tests {
        let forces = ForceProblem::new(setup, active);
        let prior = if parts.is_empty() { forces.prior() } else { forces.prior().flat() };
        parts.push(SharedErrors::new(forces, covariance, DVector::from_vec(setup.measured_mn()), prior));
    }
    let mut problem = Together { parts, rows: vec![] };
    let mut watch = |_: &_| first.engine.going_on();
    Ok(minimise(&mut problem, start, &bounds, &options(*first, evaluations), &mut watch)?.chi_square)
}
