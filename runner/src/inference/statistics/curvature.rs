//! Covariance of the variables through roots: a covariance itself cancels where two of them trade off.

use crate::fit::Whitening;
use nalgebra::{DMatrix, DVector};

/// SVD of the whitened design with the prior's rows below it.
pub(super) struct Curvature {
    u: DMatrix<f64>,
    v_t: DMatrix<f64>,
    inverse: DVector<f64>,
    rows: usize,
}

impl Curvature {
    pub(super) fn new(design: &DMatrix<f64>, deviations: &[f64]) -> Self {
        let (m, n) = design.shape();
        let mut stacked = design.clone().resize_vertically(m + n, 0.0);
        for (j, deviation) in deviations.iter().enumerate() {
            stacked[(m + j, j)] = 1.0 / deviation;
        }
        let svd = stacked.svd(true, true);
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { unreachable!("both sides were asked for") };
        Self { u, v_t, inverse: svd.singular_values.map(|s| 1.0 / s), rows: m }
    }

    pub(super) fn back(&self, along: DVector<f64>) -> DVector<f64> {
        self.v_t.tr_mul(&along.component_mul(&self.inverse))
    }

    /// Shift of the variables by a whitened shift of the data.
    pub(super) fn shift(&self, whitened: &DVector<f64>) -> DVector<f64> {
        self.back(self.u.rows(0, self.rows).tr_mul(whitened))
    }

    /// Columns of what the white part of the data's errors contributes.
    pub(super) fn white<W: Whitening>(&self, covariance: &W) -> Vec<DVector<f64>> {
        let u = self.u.rows(0, self.rows);
        let parts: Vec<DVector<f64>> =
            u.column_iter().map(|column| covariance.white_part(&column.into_owned())).collect();
        let svd = DMatrix::from_columns(&parts).svd(false, true);
        let Some(v_t) = svd.v_t else { unreachable!("it was asked for") };
        let root = |(row, size): (_, &f64)| self.back(nalgebra::RowDVector::transpose(&row) * *size);
        v_t.row_iter().map(|r| r.into_owned()).zip(svd.singular_values.iter()).map(root).collect()
    }

    /// Columns of what the prior contributes.
    pub(super) fn prior(&self, deviations: &[f64]) -> Vec<DVector<f64>> {
        let one = |(j, _): (usize, &f64)| self.back(self.u.row(self.rows + j).transpose());
        deviations.iter().enumerate().map(one).collect()
    }
}

pub(super) fn correlation(root: &DMatrix<f64>) -> DMatrix<f64> {
    let covariance = root * root.transpose();
    DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        match (i == j, scale > 0.0) {
            (true, _) => 1.0,
            (false, true) => (covariance[(i, j)] / scale).clamp(-1.0, 1.0),
            (false, false) => 0.0,
        }
    })
}
