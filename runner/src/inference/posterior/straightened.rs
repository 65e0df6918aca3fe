//! Variables in which a posterior is nearly a normal one of unit size.
//!
//! `x = mode + L y`, `L L'` the Laplace covariance with its principal directions in order of width, and `y_j = z_j + sum_k A_jk z_k^2 / 2`
//! over the wider ones: where the valley of chi^2 bends along a wide direction, narrow ones follow. The volume of z is that of y.

use super::{Peak, PosteriorError};
use nalgebra::{DMatrix, DVector};

/// Smaller deviations than this part of the largest are rounding.
const ROUNDING: f64 = 1e-6;
/// A bend belongs to a principal direction that it is this parallel to.
const PARALLEL: f64 = 0.99;

/// The change of variables.
pub struct Straightened {
    mode: DVector<f64>,
    root: DMatrix<f64>,
    /// `A`.
    bends: DMatrix<f64>,
}

impl Straightened {
    /// Around a maximum, whose covariance rounding may have made not quite positive.
    pub fn new(peak: &Peak<'_>) -> Result<Self, PosteriorError> {
        let eigen = (0.5 * (peak.covariance + peak.covariance.transpose())).symmetric_eigen();
        let largest = eigen.eigenvalues.amax();
        if !(largest > 0.0 && largest.is_finite()) {
            return Err(PosteriorError::Sampler("the fit has no curvature".to_owned()));
        }
        let n = peak.mode.len();
        let size = |k: usize| eigen.eigenvalues[k].max(0.0).sqrt().max(ROUNDING * largest.sqrt());
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| size(*b).total_cmp(&size(*a)));
        let sizes: Vec<f64> = order.iter().map(|k| size(*k)).collect();
        let directions = eigen.eigenvectors.select_columns(&order);
        let mut bends = DMatrix::zeros(n, n);
        for bend in peak.bends {
            let along = directions.tr_mul(&bend.deviation.normalize());
            let Some(k) = along.iter().position(|c| c.abs() > PARALLEL) else { continue };
            let across = directions.tr_mul(&bend.curvature());
            (k + 1..n).for_each(|j| bends[(j, k)] = across[j] / sizes[j]);
        }
        let root = directions * DMatrix::from_diagonal(&DVector::from_vec(sizes));
        Ok(Self { mode: DVector::from_column_slice(peak.mode), root, bends })
    }

    /// Number of variables.
    pub fn len(&self) -> usize {
        self.mode.len()
    }

    /// The point.
    pub fn x(&self, z: &DVector<f64>) -> Vec<f64> {
        let y = z + 0.5 * &self.bends * z.component_mul(z);
        (&self.mode + &self.root * y).as_slice().to_vec()
    }

    /// The point within bounds (lower, upper) whose image in the mirrors that stand there this is, and the sign of each of its
    /// variables' change.
    pub fn mirrored(&self, z: &DVector<f64>, (lower, upper): &(Vec<f64>, Vec<f64>)) -> (Vec<f64>, Vec<f64>) {
        let fold = |(x, (l, u)): (f64, (&f64, &f64))| {
            let width = u - l;
            let beyond = (x - l).rem_euclid(2.0 * width);
            if beyond <= width { (l + beyond, 1.0) } else { (u + width - beyond, -1.0) }
        };
        self.x(z).into_iter().zip(lower.iter().zip(upper)).map(fold).unzip()
    }

    /// The gradient by z of what has this gradient by x.
    pub fn gradient(&self, z: &DVector<f64>, by_x: &[f64]) -> DVector<f64> {
        let by_y = self.root.tr_mul(&DVector::from_column_slice(by_x));
        &by_y + z.component_mul(&self.bends.tr_mul(&by_y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::statistics::Bend;

    /// A valley whose floor is y = 3 x^2 / 2.
    #[test]
    fn a_parabola_becomes_straight() {
        let covariance = DMatrix::from_diagonal(&DVector::from_row_slice(&[0.01, 4.0]));
        let deviation = DVector::from_row_slice(&[0.0, -2.0]);
        let at = |z: f64| (z, DVector::from_row_slice(&[1.5 * (2.0 * z).powi(2), -2.0 * z]));
        let bends = [Bend { deviation, floor: vec![at(1.0), at(-0.5)] }];
        let to =
            Straightened::new(&Peak { mode: &[0.0, 5.0], covariance: &covariance, bends: &bends }).unwrap();
        let x = to.x(&DVector::from_row_slice(&[0.7, 0.0]));
        assert!(
            (x[0] - 1.5 * (x[1] - 5.0).powi(2)).abs() < 1e-9 && ((x[1] - 5.0).abs() - 1.4).abs() < 1e-9,
            "{x:?}"
        );
        // Beyond a bound lies the image of what is within it.
        let (within, signs) =
            to.mirrored(&DVector::from_row_slice(&[0.0, 0.0]), &(vec![1.0, -2.0], vec![11.0, 3.0]));
        assert_eq!((within, signs), (vec![2.0, 1.0], vec![-1.0, -1.0]));
        // The gradient is that of differences, for a function with the gradient (1, 2).
        let z = DVector::from_row_slice(&[0.4, -1.1]);
        let gradient = to.gradient(&z, &[1.0, 2.0]);
        let value = |z: &DVector<f64>| to.x(z)[0] + 2.0 * to.x(z)[1];
        for j in 0..2 {
            let step = DVector::from_fn(2, |i, _| if i == j { 1e-5 } else { 0.0 });
            let slope = (value(&(&z + &step)) - value(&(&z - &step))) / 2e-5;
            assert!((slope - gradient[j]).abs() < 1e-6, "{slope} {}", gradient[j]);
        }
    }
}
