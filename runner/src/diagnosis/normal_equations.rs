//! What some points tell of a fit's variables and of the errors that points share.
//!
//! Around its optimum a model is linear: `measured - model = J delta + U u + white noise`, with the prior of the parameters on `delta` and
//! `u` standard normal.

use crate::inference::fit::Fit;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Of `[delta; u]`, by points that are fitted.
pub struct NormalEquations {
    /// Rows of the fitted points.
    rows: DMatrix<f64>,
    /// Of the fitted points (1/mN^2).
    weights: DVector<f64>,
    /// Precision times mean of what is known before.
    shift: DVector<f64>,
    /// Precision after.
    pub normal: DMatrix<f64>,
    /// The same, factorised.
    pub precision: Cholesky<f64, Dyn>,
    /// Share of the variance before that is left after.
    pub left: Vec<f64>,
}

impl NormalEquations {
    /// Of a fit, by points whose `rows` have the derivatives by the variables (mN) and then the shapes of the shared errors (mN), and that
    /// have these white deviations (mN); `None` where they cannot be solved.
    pub fn new(fit: &Fit, rows: DMatrix<f64>, white_mn: &DVector<f64>) -> Option<Self> {
        let weights = white_mn.map(|s| s.powi(-2));
        let known = (0..rows.ncols()).map(|j| fit.known_before(j));
        let (before, shift): (Vec<f64>, Vec<f64>) =
            known.map(|(precision, mean)| (precision, precision * mean)).unzip();
        let before = DVector::from_vec(before);
        let mut normal = rows.tr_mul(&scaled_rows(&rows, &weights));
        normal.set_diagonal(&(normal.diagonal() + &before));
        let precision = normal.clone().cholesky()?;
        let left = precision.inverse().diagonal().component_mul(&before).as_slice().to_vec();
        Some(Self { rows, weights, shift: DVector::from_vec(shift), normal, precision, left })
    }

    /// The mean, where the fitted points have `gap_mn` measured minus model at the optimum.
    pub fn solve(&self, gap_mn: &DVector<f64>) -> DVector<f64> {
        let weighted = gap_mn.component_mul(&self.weights);
        self.precision.solve(&(self.rows.tr_mul(&weighted) + &self.shift))
    }
}

/// Each row times its factor.
pub fn scaled_rows(matrix: &DMatrix<f64>, factors: &DVector<f64>) -> DMatrix<f64> {
    let mut scaled = matrix.clone();
    scaled.column_iter_mut().for_each(|mut column| column.component_mul_assign(factors));
    scaled
}
