//! The best of three feasible steps: truncated trust-region, reflected, scaled gradient
//! (Branch, Coleman and Li, SIAM J. Sci. Comput. 21, 1999).

use super::coleman_li::{stride_to_bound, stride_to_region};
use super::problem::Bounds;
use super::subproblem::Decomposition;
use nalgebra::{DMatrix, DVector};

/// Quadratic model `1/2 |J_h p|^2 + 1/2 p^T D p + g_h^T p` in scaled variables `x = d x_h`.
pub(super) struct ScaledModel<'a> {
    /// The point.
    pub x: &'a DVector<f64>,
    /// Scale: `x` step = `d` times scaled step.
    pub d: &'a DVector<f64>,
    /// Scaled Jacobian.
    pub jacobian: &'a DMatrix<f64>,
    /// Scaled gradient.
    pub gradient: &'a DVector<f64>,
    /// Diagonal that the bounds add to the Hessian.
    pub diagonal: &'a DVector<f64>,
    /// The bounds.
    pub bounds: &'a Bounds,
    /// Fraction of the way to the bound that is taken, so that the iterates stay inside.
    pub theta: f64,
}

/// A step with its prediction.
pub(super) struct Step {
    /// Step in x.
    pub p: DVector<f64>,
    /// Step in scaled variables.
    pub p_scaled: DVector<f64>,
    /// Decrease of the cost that the quadratic model predicts.
    pub predicted: f64,
}

/// A correction longer than this part of its step is no correction.
const LONGEST_TURN: f64 = 0.75;

impl ScaledModel<'_> {
    /// The path that leads from the end of `path`, with the residuals `f` there, to those that the model foresaw of the scaled step `p_h`:
    /// along a narrow valley that bends, a straight step ends on its slope, and the same Jacobian, damped as much, leads back to its
    /// floor (Transtrum and Sethna, arXiv:1201.5885). None where that is no small correction.
    pub(super) fn turned(
        &self,
        (decomposition, alpha): (&Decomposition, f64),
        (p_h, path): (&DVector<f64>, &DVector<f64>),
        (here, there): (&DVector<f64>, &DVector<f64>),
    ) -> Option<DVector<f64>> {
        let (m, n) = self.jacobian.shape();
        let mut missed = DVector::zeros(m + n);
        missed.rows_mut(0, m).copy_from(&(there - here - self.jacobian * p_h));
        let bounds = self.diagonal.map(|v| v.max(0.0).sqrt());
        missed.rows_mut(m, n).copy_from(&bounds.component_mul(&(path - p_h)));
        let correction = decomposition.damped(&missed, alpha);
        (correction.norm() <= LONGEST_TURN * p_h.norm()).then(|| path + correction)
    }

    fn value(&self, p: &DVector<f64>) -> f64 {
        let q = (self.jacobian * p).norm_squared() + p.component_mul(p).dot(self.diagonal);
        0.5 * q + p.dot(self.gradient)
    }

    /// Minimum over `t` in `[low, high]` of the model along `origin + t direction`: `(t, value)`.
    fn minimise_on_ray(
        &self,
        origin: &DVector<f64>,
        direction: &DVector<f64>,
        low: f64,
        high: f64,
    ) -> (f64, f64) {
        let jd = self.jacobian * direction;
        let a = 0.5 * (jd.norm_squared() + direction.component_mul(direction).dot(self.diagonal));
        let b = direction.dot(self.gradient)
            + jd.dot(&(self.jacobian * origin))
            + direction.component_mul(origin).dot(self.diagonal);
        let c = self.value(origin);
        let at = |t: f64| (t, t * (a * t + b) + c);
        let stationary = -0.5 * b / a;
        let candidates = [at(low), at(high), at(if a > 0.0 { stationary.max(low).min(high) } else { low })];
        candidates.into_iter().fold(candidates[0], |best, c| if c.1 < best.1 { c } else { best })
    }

    /// Chooses the step for the trust-region solution `p_h` and the given radius.
    pub(super) fn choose(&self, p_h: &DVector<f64>, radius: f64) -> Step {
        let p = self.d.component_mul(p_h);
        let end = self.x + &p;
        if self.bounds.contain(end.as_slice()) {
            let predicted = -self.value(p_h);
            return Step { p, p_scaled: p_h.clone(), predicted };
        }
        let (stride, hits) = stride_to_bound(self.x, &p, self.bounds);
        let on_bound_h = p_h * stride;

        let truncated = &on_bound_h * self.theta;
        let mut best = (self.value(&truncated), truncated);
        let mut consider = |candidate: (f64, DVector<f64>)| {
            if candidate.0 < best.0 {
                best = candidate;
            }
        };
        if let Some(reflected) = self.reflected(p_h, &on_bound_h, stride, &hits, radius) {
            consider(reflected);
        }
        consider(self.scaled_gradient(radius));
        let (value, p_scaled) = best;
        Step { p: self.d.component_mul(&p_scaled), p_scaled, predicted: -value }
    }

    /// From the bound on, the step goes on with the components that hit it reversed.
    fn reflected(
        &self,
        p_h: &DVector<f64>,
        on_bound_h: &DVector<f64>,
        stride: f64,
        hits: &[bool],
        radius: f64,
    ) -> Option<(f64, DVector<f64>)> {
        let r_h = DVector::from_fn(p_h.len(), |i, _| if hits[i] { -p_h[i] } else { p_h[i] });
        let start = self.x + self.d.component_mul(on_bound_h);
        let (to_bound, _) = stride_to_bound(&start, &self.d.component_mul(&r_h), self.bounds);
        let to_region = stride_to_region(on_bound_h, &r_h, radius);
        let reach = to_bound.min(to_region);
        if reach <= 0.0 {
            return None;
        }
        let low = (1.0 - self.theta) * stride / reach;
        let high = if reach == to_bound { self.theta * to_bound } else { to_region };
        if low > high {
            return None;
        }
        let (t, value) = self.minimise_on_ray(on_bound_h, &r_h, low, high);
        Some((value, on_bound_h + r_h * t))
    }

    fn scaled_gradient(&self, radius: f64) -> (f64, DVector<f64>) {
        let direction = -self.gradient;
        let to_region = radius / direction.norm().max(f64::MIN_POSITIVE);
        let (to_bound, _) = stride_to_bound(self.x, &self.d.component_mul(&direction), self.bounds);
        let high = if to_bound < to_region { self.theta * to_bound } else { to_region };
        let origin = DVector::zeros(direction.len());
        let (t, value) = self.minimise_on_ray(&origin, &direction, 0.0, high);
        (value, direction * t)
    }
}
