//! A covariance that is a diagonal and few common errors, and what makes it white.
//!
//! `Sigma = S (1 + V V') S` with `S` the white deviations and `V = S^-1 U` the common errors in units of them. With
//! the thin decomposition `V = Q diag(s) Z'` the symmetric inverse root is
//! `L^-1 = (1 + Q diag(1 / sqrt(1 + s^2) - 1) Q') S^-1`: cost linear in the number of points.

use crate::fit::Whitening;
use nalgebra::{DMatrix, DVector};

/// An error that many points share: its value at each point when it is one standard deviation large (mN).
#[derive(Debug, Clone, PartialEq)]
pub struct Common {
    /// What it is.
    pub name: String,
    /// Shape (mN).
    pub shape_mn: DVector<f64>,
}

/// Covariance of the measured force minus the model's (mN^2).
#[derive(Debug, Clone)]
pub struct Covariance {
    white_mn: DVector<f64>,
    common: Vec<Common>,
    q: DMatrix<f64>,
    /// `1 / sqrt(1 + s^2) - 1`.
    change: DVector<f64>,
    log_determinant: f64,
}

impl Covariance {
    /// From the white deviation of each point (mN), positive, and the common errors.
    pub fn new(white_mn: DVector<f64>, common: Vec<Common>) -> Self {
        let n = white_mn.len();
        let log_white = 2.0 * white_mn.iter().map(|s| s.ln()).sum::<f64>();
        if common.is_empty() {
            let (q, change) = (DMatrix::zeros(n, 0), DVector::zeros(0));
            return Self { white_mn, common, q, change, log_determinant: log_white };
        }
        let columns: Vec<DVector<f64>> = common.iter().map(|c| c.shape_mn.component_div(&white_mn)).collect();
        let svd = DMatrix::from_columns(&columns).svd(true, false);
        let Some(q) = svd.u else { unreachable!("it was asked for") };
        let change = svd.singular_values.map(|s| 1.0 / (1.0 + s * s).sqrt() - 1.0);
        let more: f64 = svd.singular_values.iter().map(|s| (s * s).ln_1p()).sum();
        Self { white_mn, common, q, change, log_determinant: log_white + more }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.white_mn.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.white_mn.is_empty()
    }

    /// White deviation of each point (mN).
    pub fn white_mn(&self) -> &DVector<f64> {
        &self.white_mn
    }

    /// The errors that points share.
    pub fn common(&self) -> &[Common] {
        &self.common
    }

    /// Shapes of the common errors (mN), one column each.
    pub fn common_columns(&self) -> DMatrix<f64> {
        let mut columns = DMatrix::zeros(self.len(), self.common.len());
        for (mut column, common) in columns.column_iter_mut().zip(&self.common) {
            column.copy_from(&common.shape_mn);
        }
        columns
    }

    /// ln det Sigma.
    pub fn log_determinant(&self) -> f64 {
        self.log_determinant
    }

    /// Standard deviation of each point, white and common (mN).
    pub fn total_mn(&self) -> DVector<f64> {
        let at = |i: usize| {
            let common: f64 = self.common.iter().map(|c| c.shape_mn[i].powi(2)).sum();
            (self.white_mn[i].powi(2) + common).sqrt()
        };
        DVector::from_fn(self.len(), |i, _| at(i))
    }

    /// The same with further common errors.
    #[must_use]
    pub fn with(&self, more: Vec<Common>) -> Self {
        let common = self.common.iter().cloned().chain(more).collect();
        Self::new(self.white_mn.clone(), common)
    }
}

impl Whitening for Covariance {
    fn apply(&self, values: &DVector<f64>) -> DVector<f64> {
        let scaled = values.component_div(&self.white_mn);
        let inside = self.q.tr_mul(&scaled).component_mul(&self.change);
        scaled + &self.q * inside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whitening_turns_the_covariance_into_the_unit_matrix() {
        let white = DVector::from_vec(vec![0.5, 1.0, 2.0, 0.7]);
        let shape = |v: [f64; 4]| Common { name: "c".into(), shape_mn: DVector::from_row_slice(&v) };
        // The third is a multiple of the first: the shapes need not be independent.
        let common =
            vec![shape([1.0, 2.0, 3.0, 4.0]), shape([0.0, 1.0, -1.0, 0.5]), shape([2.0, 4.0, 6.0, 8.0])];
        let covariance = Covariance::new(white.clone(), common);
        let u = covariance.common_columns();
        let sigma = DMatrix::from_diagonal(&white.map(|s| s * s)) + &u * u.transpose();
        let half = covariance.apply_columns(&sigma).transpose();
        let unit = covariance.apply_columns(&half);
        assert!((unit - DMatrix::identity(4, 4)).amax() < 1e-10);
        assert!((covariance.log_determinant() - sigma.determinant().ln()).abs() < 1e-9);
        assert!((covariance.total_mn()[2] - sigma[(2, 2)].sqrt()).abs() < 1e-12);
    }

    #[test]
    fn without_common_errors_points_are_divided_by_their_deviation() {
        let covariance = Covariance::new(DVector::from_vec(vec![0.5, 2.0]), vec![]);
        assert_eq!(covariance.apply(&DVector::from_vec(vec![1.0, 1.0])).as_slice(), [2.0, 0.5]);
    }
}
