//! Affine scaling of Coleman and Li (SIAM J. Optim. 6, 1996): distances to the bound that the descent faces.

use super::problem::Bounds;
use nalgebra::DVector;

/// `v_i` = distance to the bound that `-g_i` points at (1 if there is none) and `dv_i / dx_i`.
pub(super) fn scaling(x: &DVector<f64>, g: &DVector<f64>, bounds: &Bounds) -> (DVector<f64>, DVector<f64>) {
    let n = x.len();
    let (mut v, mut dv) = (DVector::from_element(n, 1.0), DVector::zeros(n));
    for i in 0..n {
        let (l, u) = (bounds.lower()[i], bounds.upper()[i]);
        if g[i] < 0.0 && u.is_finite() {
            (v[i], dv[i]) = (u - x[i], -1.0);
        } else if g[i] > 0.0 && l.is_finite() {
            (v[i], dv[i]) = (x[i] - l, 1.0);
        }
    }
    (v, dv)
}

/// Largest `t >= 0` with `x + t p` within bounds, and the sign of the bounds hit there (0: not hit).
pub(super) fn stride_to_bound(x: &DVector<f64>, p: &DVector<f64>, bounds: &Bounds) -> (f64, Vec<bool>) {
    let stride = |i: usize| {
        let bound = if p[i] > 0.0 { bounds.upper()[i] } else { bounds.lower()[i] };
        if p[i] == 0.0 { f64::INFINITY } else { ((bound - x[i]) / p[i]).max(0.0) }
    };
    let strides: Vec<f64> = (0..x.len()).map(stride).collect();
    let shortest = strides.iter().copied().fold(f64::INFINITY, f64::min);
    (shortest, strides.iter().map(|&s| s == shortest && s.is_finite()).collect())
}

/// The positive root `t` of `|s + t d| = radius`, for `s` inside the region.
pub(super) fn stride_to_region(s: &DVector<f64>, d: &DVector<f64>, radius: f64) -> f64 {
    let (a, b, c) = (d.norm_squared(), s.dot(d), s.norm_squared() - radius * radius);
    if a == 0.0 || c >= 0.0 {
        return 0.0;
    }
    // Of the two stable forms, the one without cancellation.
    let root = (b * b - a * c).sqrt();
    if b > 0.0 { -c / (b + root) } else { (root - b) / a }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaling_measures_the_distance_that_descent_faces() {
        let bounds = Bounds::new(vec![0.0, 0.0, f64::NEG_INFINITY], vec![1.0, 1.0, 5.0]).unwrap();
        let x = DVector::from_vec(vec![0.25, 0.25, 0.0]);
        let g = DVector::from_vec(vec![1.0, -1.0, 1.0]);
        let (v, dv) = scaling(&x, &g, &bounds);
        assert_eq!(v.as_slice(), [0.25, 0.75, 1.0]);
        assert_eq!(dv.as_slice(), [1.0, -1.0, 0.0]);
    }

    #[test]
    fn strides_end_on_bound_and_sphere() {
        let bounds = Bounds::new(vec![-1.0, -1.0], vec![1.0, 2.0]).unwrap();
        let x = DVector::from_vec(vec![0.0, 0.0]);
        let (t, hits) = stride_to_bound(&x, &DVector::from_vec(vec![2.0, 1.0]), &bounds);
        assert_eq!((t, hits), (0.5, vec![true, false]));
        let s = DVector::from_vec(vec![1.0, 0.0]);
        let d = DVector::from_vec(vec![0.0, 3.0]);
        let t = stride_to_region(&s, &d, 2.0);
        assert!(((s + t * d).norm() - 2.0).abs() < 1e-14);
    }
}
