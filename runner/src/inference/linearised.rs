//! What a refit of the parameters cannot absorb.
//!
//! `W = [inv(L) J; inv(S)]`: whitened Jacobian, and below it the parameters' prior of deviations `S`. `P = 1 - W (W'W)^-1 W'`
//! removes from a vector what a refit would take up; `y = P [inv(L)(measured - model); (mean - x) / S]` is what is left of the residual.

use super::magnitude::prior_weight;
use crate::fit::Whitening;
use nalgebra::{DMatrix, DVector};

/// Signatures of a larger cosine look the same.
const CONFUSABLE: f64 = 0.9;

/// A fit, linearised at its optimum.
#[derive(Debug, Clone)]
pub struct Linearised {
    /// `W = Q R`: `Q`, then `R`.
    basis: DMatrix<f64>,
    triangle: DMatrix<f64>,
    /// `W`.
    pub design: DMatrix<f64>,
    /// Residual (measured minus model) that no refit absorbs, whitened; the prior's rows last.
    pub residual: DVector<f64>,
    /// Number of rows that are data.
    pub data: usize,
}

impl Linearised {
    /// From the whitened design with the prior's rows last, and the residual (measured minus model) alike.
    pub fn new(design: DMatrix<f64>, residual: &DVector<f64>) -> Self {
        let data = design.nrows() - design.ncols();
        let qr = design.clone().qr();
        let (basis, triangle) = (qr.q(), qr.r());
        let mut fit = Self { basis, triangle, design, residual: DVector::zeros(0), data };
        fit.residual = fit.project(residual);
        fit
    }

    /// `P v`.
    pub fn project(&self, v: &DVector<f64>) -> DVector<f64> {
        v - &self.basis * self.basis.tr_mul(v)
    }

    /// `P [inv(L) d; 0]` of a change of force `d` (mN), and the norm of `inv(L) d`.
    pub fn signature<W: Whitening>(&self, whitening: &W, d_mn: &DVector<f64>) -> Signature {
        let whitened = whitening.apply(d_mn);
        let norm = whitened.norm();
        Signature { s: self.project(&whitened.resize_vertically(self.design.nrows(), 0.0)), norm }
    }

    /// Change of the variables that takes up as much as it can of a change of force `d` (mN): `-(W'W)^-1 W' [inv(L) d; 0]`.
    pub fn giving_way<W: Whitening>(&self, whitening: &W, d_mn: &DVector<f64>) -> DVector<f64> {
        let whitened = whitening.apply(d_mn).resize_vertically(self.design.nrows(), 0.0);
        // Where the design says nothing of a variable, none moves.
        let step = self.triangle.solve_upper_triangular(&-self.basis.tr_mul(&whitened));
        step.unwrap_or_else(|| DVector::zeros(self.design.ncols()))
    }

    /// ln det (W'W).
    pub fn log_curvature(&self) -> f64 {
        2.0 * self.triangle.diagonal().iter().map(|d| d.abs().ln()).sum::<f64>()
    }
}

/// What an effect of magnitude 1 leaves after a refit of the parameters.
#[derive(Debug, Clone)]
pub struct Signature {
    /// `P inv(L) d`.
    pub s: DVector<f64>,
    /// `|inv(L) d|`.
    pub norm: f64,
}

impl Signature {
    /// Standard normal where there is no effect: `s'y / |s|`.
    pub fn score(&self, y: &DVector<f64>) -> f64 {
        let length = self.s.norm();
        if length > 0.0 { self.s.dot(y) / length } else { 0.0 }
    }

    /// Magnitude of least squares, `s'y / s's`, and its standard deviation `1 / |s|`.
    pub fn magnitude(&self, y: &DVector<f64>) -> (f64, f64) {
        let length = self.s.norm().max(f64::MIN_POSITIVE);
        (self.score(y) / length, 1.0 / length)
    }

    /// Decrease of chi^2 by the effect at magnitude 1: `2 s'y - s's`.
    pub fn gain_of_one(&self, y: &DVector<f64>) -> f64 {
        2.0 * self.s.dot(y) - self.s.norm_squared()
    }

    /// Share of the effect that a refit hides, `1 - |s| / |inv(L) d|`.
    pub fn absorbed(&self) -> f64 {
        if self.norm > 0.0 { (1.0 - self.s.norm() / self.norm).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Score that magnitude 1 gives on average: its power.
    pub fn strength(&self) -> f64 {
        self.s.norm()
    }

    /// Cosine of the angle between two signatures.
    pub fn cosine(&self, other: &Self) -> f64 {
        let product = self.s.norm() * other.s.norm();
        if product > 0.0 { (self.s.dot(&other.s) / product).clamp(-1.0, 1.0) } else { 0.0 }
    }

    /// Whether these data cannot tell the two apart.
    pub fn looks_like(&self, other: &Self) -> bool {
        self.cosine(other).abs() > CONFUSABLE
    }

    /// Twice the log evidence for the effect against no effect, its magnitude as likely before the measurement as
    /// `inference::magnitude` says, on one side only if `one_sided`.
    pub fn evidence(&self, y: &DVector<f64>, one_sided: bool) -> f64 {
        let (magnitude, deviation) = self.magnitude(y);
        self.score(y).powi(2) + prior_weight(magnitude, deviation, one_sided)
    }
}

/// Standard normal distribution; never quite 0, so that its logarithm exists.
pub fn normal_cdf(z: f64) -> f64 {
    (0.5 * statrs::function::erf::erfc(-z / std::f64::consts::SQRT_2)).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Covariance;

    /// A constant and a slope, known to 10 before; a parabola, of which both take up what they can.
    #[test]
    fn variables_give_way_to_what_is_left_of_an_effect() {
        let x = DVector::from_fn(20, |i, _| i as f64 / 10.0);
        let data = DMatrix::from_columns(&[DVector::from_element(20, 1.0), x.clone()]);
        let mut design = data.resize_vertically(22, 0.0);
        design[(20, 0)] = 0.1;
        design[(21, 1)] = 0.1;
        let fit = Linearised::new(design.clone(), &DVector::zeros(22));
        let unit = Covariance::new(DVector::from_element(20, 1.0), vec![]);
        let parabola = x.component_mul(&x);
        let moved = fit.giving_way(&unit, &parabola);
        let together = parabola.clone().resize_vertically(22, 0.0) + &design * &moved;
        approx::assert_relative_eq!(together, fit.signature(&unit, &parabola).s, epsilon = 1e-12);
        // Its tangent at the middle, turned round.
        assert!((moved[1] + 1.9).abs() < 0.05 && moved[0] > 0.0, "{moved}");
    }
}
