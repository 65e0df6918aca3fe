//! Generalised least squares: any problem seen through the inverse root of its noise's covariance, with what is
//! known of its variables before the measurement as further residuals.

use super::problem::{EvaluationFailure, Problem};
use nalgebra::{DMatrix, DVector};

/// A linear map that makes correlated noise white: `Cov(apply(noise)) = 1`.
pub trait Whitening {
    /// The whitened vector.
    fn apply(&self, values: &DVector<f64>) -> DVector<f64>;

    /// The whitened columns.
    fn apply_columns(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let whitened: Vec<DVector<f64>> =
            columns.column_iter().map(|c| self.apply(&c.into_owned())).collect();
        DMatrix::from_columns(&whitened)
    }
}

/// Normal knowledge of each variable before the measurement.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Prior {
    /// Mean of each variable.
    pub mean: Vec<f64>,
    /// Standard deviation of each variable.
    pub deviation: Vec<f64>,
}

impl Prior {
    /// `(x - mean) / deviation`.
    pub fn residual(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(self.mean.iter().zip(&self.deviation)).map(|(x, (m, s))| (x - m) / s).collect()
    }

    /// The same knowledge and that of further variables.
    #[must_use]
    pub fn with(&self, mean: f64, deviation: f64) -> Self {
        let mut longer = self.clone();
        longer.mean.push(mean);
        longer.deviation.push(deviation);
        longer
    }
}

/// A problem with whitened residuals, followed by those of the prior.
pub struct Whitened<'a, P, W> {
    problem: P,
    whitening: &'a W,
    prior: Prior,
}

impl<'a, P: Problem, W: Whitening> Whitened<'a, P, W> {
    /// The problem through the whitening; `prior` has one entry per variable.
    pub fn new(problem: P, whitening: &'a W, prior: Prior) -> Self {
        Self { problem, whitening, prior }
    }
}

impl<P: Problem, W: Whitening> Problem for Whitened<'_, P, W> {
    fn dimension(&self) -> usize {
        self.problem.dimension()
    }

    fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
        let raw = DVector::from_vec(self.problem.residual(x)?);
        let mut all = self.whitening.apply(&raw).as_slice().to_vec();
        all.extend(self.prior.residual(x));
        Ok(all)
    }

    fn jacobian(&mut self, x: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
        // The inner problem may difference its own residuals: it must see those, not the whitened ones.
        let inner = self.problem.residual(x)?;
        let whitened = self.whitening.apply_columns(&self.problem.jacobian(x, &inner)?);
        let (data, n) = (whitened.nrows(), x.len());
        debug_assert_eq!(data + n, r.len());
        let mut all = whitened.resize_vertically(data + n, 0.0);
        for (j, deviation) in self.prior.deviation.iter().enumerate() {
            all[(data + j, j)] = 1.0 / deviation;
        }
        Ok(all)
    }

    fn prefetch(&mut self, points: &[Vec<f64>]) {
        self.problem.prefetch(points);
    }

    fn rejected(&mut self, x: &[f64]) {
        self.problem.rejected(x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Bounds, Options, minimise};
    use std::ops::ControlFlow;

    /// Two measurements of one number that share an error, as residuals `x - y`.
    struct Twice;

    impl Problem for Twice {
        fn dimension(&self) -> usize {
            1
        }
        fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
            Ok(vec![x[0] - 1.0, x[0] - 4.0])
        }
        fn jacobian(&mut self, _: &[f64], _: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
            Ok(DMatrix::from_element(2, 1, 1.0))
        }
    }

    /// Lower Cholesky factor of the covariance.
    struct Factor(DMatrix<f64>);

    impl Whitening for Factor {
        fn apply(&self, values: &DVector<f64>) -> DVector<f64> {
            self.0.solve_lower_triangular(values).unwrap()
        }
    }

    #[test]
    fn the_minimum_is_the_generalised_least_squares_estimate() {
        let covariance = DMatrix::from_row_slice(2, 2, &[1.0, 0.8, 0.8, 4.0]);
        let factor = Factor(covariance.clone().cholesky().unwrap().l());
        let prior = Prior { mean: vec![2.0], deviation: vec![0.5] };
        let mut problem = Whitened::new(Twice, &factor, prior);
        let go = &mut |_: &_| ControlFlow::Continue(());
        let found = minimise(&mut problem, &[0.0], &Bounds::none(1), &Options::default(), go).unwrap();
        let weight = covariance.try_inverse().unwrap();
        let ones = DVector::from_element(2, 1.0);
        let y = DVector::from_vec(vec![1.0, 4.0]);
        let precision = ones.dot(&(&weight * &ones)) + 4.0;
        let expected = (ones.dot(&(&weight * y)) + 4.0 * 2.0) / precision;
        assert!((found.x[0] - expected).abs() < 1e-9, "{} {expected}", found.x[0]);
        let curvature = found.jacobian.column(0).norm_squared();
        assert!((curvature - precision).abs() < 1e-9);
    }
}
