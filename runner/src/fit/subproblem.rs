//! The trust-region subproblem `min |A p + f|, |p| <= radius`, solved exactly by SVD (Moré 1978).

use nalgebra::{DMatrix, DVector};

/// Of a linear least-squares problem, singular values below this part of the largest are rounding.
const FELT: f64 = 1e-8;

/// `A = U S V^T` with `U^T f`; reused for every radius tried at one point.
pub(crate) struct Decomposition {
    singular_values: DVector<f64>,
    v_t: DMatrix<f64>,
    u_t: DMatrix<f64>,
    uf: DVector<f64>,
}

impl Decomposition {
    /// Of `min |A p - rest|`, along what is felt.
    pub(crate) fn linear(a: DMatrix<f64>, rest: &DVector<f64>) -> Self {
        Self::new(a, &-rest, FELT)
    }

    /// The minimiser.
    pub(crate) fn whole_step(&self) -> DVector<f64> {
        -self.v_t.tr_mul(&self.uf.component_div(&self.singular_values))
    }

    /// How much lower the sum of squares is there.
    pub(crate) fn taken_up(&self) -> f64 {
        self.uf.norm_squared()
    }

    /// Decomposes `a`; directions with a singular value below `rank_tolerance` times the largest are left
    /// alone, because along them the model says nothing and the step would be noise.
    pub(super) fn new(a: DMatrix<f64>, f: &DVector<f64>, rank_tolerance: f64) -> Self {
        let rows = a.nrows();
        let svd = a.svd(true, true);
        let (u, v_t) = match (svd.u, svd.v_t) {
            (Some(u), Some(v_t)) => (u, v_t),
            _ => unreachable!("both sides were asked for"),
        };
        let tolerance = rank_tolerance.max(f64::EPSILON * rows as f64);
        let s = svd.singular_values;
        let rank = s.iter().filter(|&&value| value > tolerance * s[0]).count();
        let u_t = u.columns(0, rank).transpose();
        let uf = &u_t * f;
        Self { singular_values: s.rows(0, rank).into_owned(), v_t: v_t.rows(0, rank).into_owned(), u_t, uf }
    }

    /// The minimiser within `radius` and the Levenberg-Marquardt parameter that belongs to it
    /// (`guess`: that of the last solve).
    pub(super) fn solve(&self, radius: f64, guess: f64) -> (DVector<f64>, f64) {
        if self.singular_values.is_empty() {
            return (DVector::zeros(self.v_t.ncols()), 0.0);
        }
        let s = &self.singular_values;
        let su = s.component_mul(&self.uf);
        let step = |alpha: f64| {
            let scaled = su.zip_map(s, |su, s| su / (s * s + alpha));
            -(self.v_t.tr_mul(&scaled))
        };
        // phi(alpha) = |p(alpha)| - radius and its derivative.
        let phi = |alpha: f64| {
            let q = su.zip_map(s, |su, s| su / (s * s + alpha));
            let norm = q.norm();
            let slope = -q.zip_map(s, |q, s| q * q / (s * s + alpha)).sum() / norm;
            (norm - radius, slope)
        };
        let newton = step(0.0);
        if newton.norm() <= radius {
            return (newton, 0.0);
        }
        let (phi0, slope0) = phi(0.0);
        let (mut lower, mut upper) = (-phi0 / slope0, su.norm() / radius);
        let mut alpha = guess;
        for _ in 0..20 {
            if alpha < lower || alpha > upper || alpha == 0.0 {
                alpha = (1e-3 * upper).max((lower * upper).sqrt());
            }
            let (value, slope) = phi(alpha);
            if value.abs() < 1e-3 * radius {
                break;
            }
            if value < 0.0 {
                upper = alpha;
            }
            let ratio = value / slope;
            lower = lower.max(alpha - ratio);
            alpha -= (value + radius) * ratio / radius;
        }
        let p = step(alpha);
        let norm = p.norm();
        (p * (radius / norm), alpha)
    }

    /// The minimiser of `|A p + f|^2 + alpha |p|^2` for other residuals `f`.
    pub(super) fn damped(&self, f: &DVector<f64>, alpha: f64) -> DVector<f64> {
        let s = &self.singular_values;
        let scaled = (&self.u_t * f).zip_map(s, |uf, s| s * uf / (s * s + alpha));
        -(self.v_t.tr_mul(&scaled))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> (DMatrix<f64>, DVector<f64>) {
        let a = DMatrix::from_row_slice(3, 2, &[1.0, 2.0, 0.0, 0.5, 3.0, -1.0]);
        (a, DVector::from_vec(vec![1.0, -2.0, 0.5]))
    }

    #[test]
    fn wide_region_gives_the_normal_equations_solution() {
        let (a, f) = example();
        let (p, alpha) = Decomposition::new(a.clone(), &f, 0.0).solve(1e3, 0.0);
        assert_eq!(alpha, 0.0);
        assert!((a.tr_mul(&(&a * p + f))).norm() < 1e-13);
    }

    #[test]
    fn whole_step_takes_up_what_can_be() {
        let (a, f) = example();
        let linear = Decomposition::linear(a.clone(), &f);
        let left = (&a * linear.whole_step() - &f).norm_squared();
        assert!((f.norm_squared() - linear.taken_up() - left).abs() < 1e-13);
        assert!((a.tr_mul(&(&a * linear.whole_step() - f))).norm() < 1e-13);
    }

    #[test]
    fn narrow_region_satisfies_the_optimality_conditions() {
        let (a, f) = example();
        let (p, alpha) = Decomposition::new(a.clone(), &f, 0.0).solve(0.1, 0.0);
        assert!((p.norm() - 0.1).abs() < 1e-14);
        assert!(alpha > 0.0);
        let kkt = a.tr_mul(&(&a * &p + &f)) + alpha * &p;
        assert!(kkt.norm() < 2e-3 * a.tr_mul(&f).norm(), "{kkt}");
    }

    #[test]
    fn null_direction_is_left_alone() {
        let a = DMatrix::from_row_slice(3, 2, &[1.0, 1.0, 2.0, 2.0, 3.0, 3.0]);
        let f = DVector::from_vec(vec![1.0, 2.0, 3.0]);
        let (p, _) = Decomposition::new(a, &f, 0.0).solve(1e3, 0.0);
        assert!((p[0] + 0.5).abs() < 1e-12 && (p[1] + 0.5).abs() < 1e-12);
    }
}
