//! Noise of which a part has an unknown size: what a few specimens differ by was estimated from them, and may be larger or smaller.
//!
//! A residual that no refit absorbs is normal, of covariance `P + (r - 1) C C'`, where `C = P inv(L) U` are the whitened errors of one
//! uncertain size and `r` is their variance over what it was taken for, a scaled inverse of chi^2. Averaged over `r` it is Student's t
//! along `C`, and normal beside it.

use crate::inference::Linearised;
use crate::inference::fit::Fit;
use crate::noise::{Covariance, UncertainSize};
use nalgebra::{DMatrix, DVector, DVectorView};

/// Errors of one size, beside white noise of unit deviation.
#[derive(Debug, Clone)]
struct Part {
    /// Whitened shapes of which a refit has taken what it can: orthogonal to each other, each as long as its part of the deviation there.
    columns: DMatrix<f64>,
    size: UncertainSize,
}

/// The parts of the noise whose sizes are unknown, around a fit.
#[derive(Debug, Clone, Default)]
pub struct UnsureNoise(Vec<Part>);

/// Squared lengths below this are rounding.
const ROUNDING: f64 = 1e-10;
/// Variances that are averaged over, over what they were taken for: from a tenth to a thousand times, by a fifth of a decade.
const LEAST_DECADE: f64 = -1.0;
const PER_DECADE: usize = 5;
const DECADES: usize = 4;

impl UnsureNoise {
    /// Around a linearised fit with this covariance.
    pub fn around(linear: &Linearised, covariance: &Covariance) -> Self {
        let part = |size: UncertainSize| {
            let shapes = size.places.iter().map(|k| &covariance.common()[*k].shape_mn);
            let columns: Vec<_> = shapes.map(|shape| linear.signature(covariance, shape).s).collect();
            let columns = orthogonal(&DMatrix::from_columns(&columns));
            Part { columns, size }
        };
        let parts = covariance.uncertain_sizes().into_iter().map(part);
        Self(parts.filter(|part| part.columns.ncols() > 0).collect())
    }

    /// Around a fit.
    pub fn of(fit: &Fit) -> Self {
        Self::around(&fit.linear, &fit.covariance)
    }

    /// Twice the log density of a residual, less that of a normal one of the sizes that were taken.
    pub fn excuse(&self, residual: &DVector<f64>) -> f64 {
        self.0.iter().map(|part| part.averaged(residual, &|_| 0.0)).sum()
    }

    /// What the unknown sizes change in twice the log evidence for `columns` of normal heights: `evidence` is that of the products of
    /// the columns with each other and with the residual.
    pub fn change_of_evidence(
        &self,
        columns: &DMatrix<f64>,
        residual: &DVector<f64>,
        evidence: &dyn Fn(DMatrix<f64>, &DVector<f64>) -> f64,
    ) -> f64 {
        let (square, with_residual) = (columns.tr_mul(columns), columns.tr_mul(residual));
        let usual = evidence(square.clone(), &with_residual);
        let one = |part: &Part| {
            let across = part.columns.tr_mul(columns);
            let along = part.columns.tr_mul(residual);
            let at = |ratio: f64| {
                let taken =
                    part.columns.column_iter().map(|c| (ratio - 1.0) / (1.0 + (ratio - 1.0) * length(&c)));
                let taken = DVector::from_iterator(along.len(), taken);
                let weighed = DMatrix::from_diagonal(&taken) * &across;
                evidence(
                    &square - across.tr_mul(&weighed),
                    &(&with_residual - across.tr_mul(&along.component_mul(&taken))),
                )
            };
            part.averaged(residual, &at) - part.averaged(residual, &|_| 0.0) - usual
        };
        self.0.iter().map(one).sum()
    }

    /// Covariances of these whitened unit vectors' scores by each part, with its size.
    pub fn covariances(&self, units: &DMatrix<f64>) -> Vec<(DMatrix<f64>, &UncertainSize)> {
        let parts = self.0.iter().map(|Part { columns, size }| {
            let along = units.tr_mul(columns);
            (&along * along.transpose(), size)
        });
        parts.collect()
    }
}

impl Part {
    /// Twice the log of the mean over the sizes of the residual's density, over that of the size that was taken, times what has this
    /// twice the log at each ratio of the variances.
    fn averaged(&self, residual: &DVector<f64>, more: &dyn Fn(f64) -> f64) -> f64 {
        let along: Vec<(f64, f64)> = self
            .columns
            .column_iter()
            .map(|c| (length(&c), c.dot(residual).powi(2) / c.norm_squared()))
            .collect();
        let twice_log = |ratio: f64| -> f64 {
            let one = |(part, square): &(f64, f64)| {
                let variance = 1.0 + (ratio - 1.0) * part;
                square * (1.0 - 1.0 / variance) - variance.ln()
            };
            along.iter().map(one).sum()
        };
        let decades = (0..=DECADES * PER_DECADE).map(|k| LEAST_DECADE + k as f64 / PER_DECADE as f64);
        let all: Vec<(f64, f64)> = decades
            .map(|decade| {
                let ratio = 10f64.powf(decade);
                // Density of ln(ratio).
                let prior = -self.size.degrees * ratio.ln() - self.size.scale / ratio;
                (prior, prior + twice_log(ratio) + more(ratio))
            })
            .collect();
        twice_log_sum(all.iter().map(|t| t.1)) - twice_log_sum(all.iter().map(|t| t.0))
    }
}

/// Twice the log of a sum, from twice the logs of its terms.
pub fn twice_log_sum(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let top = terms.clone().fold(f64::NEG_INFINITY, f64::max);
    top + 2.0 * terms.map(|t| (0.5 * (t - top)).exp()).sum::<f64>().ln()
}

/// Part of the variance along a column that is of unknown size.
fn length(column: &DVectorView<f64>) -> f64 {
    column.norm_squared().min(1.0)
}

/// Columns of the same product `C C'` that are orthogonal.
fn orthogonal(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = columns.tr_mul(columns).symmetric_eigen();
    let kept: Vec<usize> =
        (0..eigen.eigenvalues.len()).filter(|k| eigen.eigenvalues[*k] > ROUNDING).collect();
    columns * eigen.eigenvectors.select_columns(&kept)
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{Continuous, StudentsT};

    fn unsure(columns: DMatrix<f64>, degrees: f64, scale: f64) -> UnsureNoise {
        let size = UncertainSize { places: vec![], degrees, scale };
        UnsureNoise(vec![Part { columns: orthogonal(&columns), size }])
    }

    /// Goal: along a shape of which all variance is uncertain, the density is Student's t. Reference: `statrs`. Tolerance: the average over
    /// five sizes a decade.
    #[test]
    fn along_one_shape_it_is_student_s_t() {
        let noise = unsure(DMatrix::from_column_slice(3, 1, &[0.0, 1.0, 0.0]), 4.0, 4.0);
        let t = StudentsT::new(0.0, 1.0, 4.0).unwrap();
        for z in [0.0, 1.0, 3.0, 6.0, 12.0] {
            let normal = -z * z - std::f64::consts::TAU.ln();
            let expected = 2.0 * t.ln_pdf(z) - normal;
            let found = noise.excuse(&DVector::from_vec(vec![5.0, z, -7.0]));
            assert!((found - expected).abs() < 0.02, "{z}: {found} {expected}");
        }
    }

    /// Goal: the evidence for a column that is the uncertain shape itself. Reference: the densities of y in one dimension, averaged over sizes
    /// on a fine grid. Tolerance: rounding of both grids.
    #[test]
    fn what_noise_may_be_is_little_evidence() {
        let noise = unsure(DMatrix::from_column_slice(2, 1, &[1.0, 0.0]), 4.0, 2.0);
        let b = DMatrix::from_column_slice(2, 1, &[1.0, 0.0]);
        // A normal height of variance 9.
        let evidence = |square: DMatrix<f64>, product: &DVector<f64>| {
            9.0 * product[0].powi(2) / (1.0 + 9.0 * square[0]) - (9.0 * square[0]).ln_1p()
        };
        let density = |variance: f64, y: f64| (-0.5 * y * y / variance).exp() / variance.sqrt();
        for y in [1.0, 4.0, 8.0] {
            let mean = |more: f64| -> f64 {
                let at = |k: i32| {
                    let ratio = (f64::from(k) * 1e-3).exp();
                    ratio.powi(-2) * (-1.0 / ratio).exp() * density(ratio + more, y)
                };
                (-4000..8000).map(at).sum()
            };
            let expected = 2.0 * (mean(9.0) / mean(0.0)).ln();
            let residual = DVector::from_vec(vec![y, 3.0]);
            let usual = evidence(b.tr_mul(&b), &b.tr_mul(&residual));
            let found = usual + noise.change_of_evidence(&b, &residual, &evidence);
            assert!((found - expected).abs() < 0.05, "{y}: {found} {expected} {usual}");
        }
    }

    /// Two shapes that are no more than one of them twice, and shapes that are mostly white noise.
    #[test]
    fn what_is_white_is_not_excused() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let once = unsure(DMatrix::from_column_slice(2, 1, &[1.0, 0.0]), 5.0, 3.0);
        let twice = unsure(DMatrix::from_column_slice(2, 2, &[half, 0.0, half, 0.0]), 5.0, 3.0);
        let y = DVector::from_vec(vec![6.0, 2.0]);
        assert!((once.excuse(&y) - twice.excuse(&y)).abs() < 1e-9);
        let little = unsure(DMatrix::from_column_slice(2, 1, &[0.1, 0.0]), 5.0, 3.0);
        assert!(little.excuse(&y) < 0.1 * once.excuse(&y));
        assert_eq!(UnsureNoise::default().excuse(&y), 0.0);
    }
}
