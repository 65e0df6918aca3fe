//! Flexible GMRES (Saad, *SIAM J. Sci. Comput.* 14, 1993) without restarts.

/// Largest dimension of the Krylov space.
pub const DIMENSIONS: usize = 50;

/// The vectors of the iteration, kept from one solve to the next.
#[derive(Debug, Default)]
pub struct Krylov {
    basis: Vec<Vec<f64>>,
    directions: Vec<Vec<f64>>,
}

/// Outcome of an iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Preconditioned products made.
    pub iterations: usize,
    /// Norm of the residual over that of the first one.
    pub reduction: f64,
}

impl Krylov {
    /// Adds to `x` the solution of `A dx = r` with a residual below `reduction` times `|r|`.
    ///
    /// `product(v, y)` makes `y = A v`, `precondition(z)` replaces z by about `A^-1 z`.
    pub fn solve(
        &mut self,
        x: &mut [f64],
        r: &[f64],
        reduction: f64,
        mut product: impl FnMut(&[f64], &mut [f64]),
        mut precondition: impl FnMut(&mut [f64]),
    ) -> Outcome {
        let first = norm(r);
        if first == 0.0 || !first.is_finite() {
            return Outcome { iterations: 0, reduction: if first == 0.0 { 0.0 } else { f64::NAN } };
        }
        self.grow(0, r.len());
        self.basis[0].iter_mut().zip(r).for_each(|(v, r)| *v = r / first);
        // Upper triangle of the rotated Hessenberg matrix by columns, and the rotated right-hand side.
        let mut triangle: Vec<Vec<f64>> = Vec::new();
        let mut rotations: Vec<(f64, f64)> = Vec::new();
        let mut rhs = vec![first];
        let mut reached = 1.0;
        while triangle.len() < DIMENSIONS && reached > reduction {
            let k = triangle.len();
            self.grow(k + 1, r.len());
            let (known, next) = self.basis.split_at_mut(k + 1);
            let (w, z) = (&mut next[0], &mut self.directions[k]);
            z.copy_from_slice(&known[k]);
            precondition(z);
            product(z, w);
            let mut column: Vec<f64> = known
                .iter()
                .map(|v| {
                    let h = dot(v, w);
                    w.iter_mut().zip(v).for_each(|(w, v)| *w -= h * v);
                    h
                })
                .collect();
            let length = norm(w);
            w.iter_mut().for_each(|w| *w /= length.max(f64::MIN_POSITIVE));
            for (i, &(c, s)) in rotations.iter().enumerate() {
                (column[i], column[i + 1]) =
                    (c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]);
            }
            let radius = column[k].hypot(length);
            if !(radius > 0.0 && radius.is_finite()) {
                reached = f64::NAN;
                break;
            }
            let (c, s) = (column[k] / radius, length / radius);
            column[k] = radius;
            rotations.push((c, s));
            rhs.push(-s * rhs[k]);
            rhs[k] *= c;
            triangle.push(column);
            reached = rhs[k + 1].abs() / first;
        }
        let mut y = rhs;
        for k in (0..triangle.len()).rev() {
            y[k] /= triangle[k][k];
            for i in 0..k {
                y[i] -= triangle[k][i] * y[k];
            }
        }
        for (y, z) in y.iter().zip(&self.directions).take(triangle.len()) {
            x.iter_mut().zip(z).for_each(|(x, z)| *x += y * z);
        }
        Outcome { iterations: triangle.len(), reduction: reached }
    }

    fn grow(&mut self, k: usize, unknowns: usize) {
        while self.basis.len() <= k + 1 {
            self.basis.push(vec![0.0; unknowns]);
            self.directions.push(vec![0.0; unknowns]);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Eight sums, so that the compiler may use vectors.
    let mut sums = [0.0; 8];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    for (a, b) in a.iter().zip(b) {
        (0..8).for_each(|i| sums[i] += a[i] * b[i]);
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

/// Euclidean norm.
pub fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Goal: the residual reached is the one reported. Set-up: an unsymmetric tridiagonal matrix,
    /// preconditioned by its diagonal. Reference: the residual itself. Tolerance: 1e-10 and 1 %.
    #[test]
    fn solves_an_unsymmetric_system() {
        let n = 203;
        let product = |v: &[f64], y: &mut [f64]| {
            for i in 0..n {
                let (left, right) =
                    (if i > 0 { v[i - 1] } else { 0.0 }, if i + 1 < n { v[i + 1] } else { 0.0 });
                y[i] = (4.0 + (i % 5) as f64) * v[i] - 1.5 * left - 0.5 * right;
            }
        };
        let b: Vec<f64> = (0..n).map(|i| ((i * 7919) % 1009) as f64 / 1009.0 - 0.5).collect();
        let mut x = vec![0.0; n];
        let precondition =
            |z: &mut [f64]| z.iter_mut().enumerate().for_each(|(i, z)| *z /= 4.0 + (i % 5) as f64);
        let outcome = Krylov::default().solve(&mut x, &b, 1e-10, product, precondition);
        assert!(outcome.reduction <= 1e-10 && outcome.iterations < DIMENSIONS, "{outcome:?}");
        let mut r = vec![0.0; n];
        product(&x, &mut r);
        r.iter_mut().zip(&b).for_each(|(r, b)| *r = b - *r);
        approx::assert_relative_eq!(
            norm(&r) / norm(&b),
            outcome.reduction,
            max_relative = 0.01,
            epsilon = 1e-14
        );
    }

    #[test]
    fn a_zero_right_hand_side_needs_no_iteration() {
        let mut x = vec![1.0; 3];
        let outcome = Krylov::default().solve(&mut x, &[0.0; 3], 1e-3, |_, _| {}, |_| {});
        assert_eq!((outcome.iterations, x), (0, vec![1.0; 3]));
    }
}
