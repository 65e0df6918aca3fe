//! Spectral decomposition of symmetric tensors; stress and tangent in the principal frame.

use super::{Tensor, Voigt, Voigt2};

/// Relative difference of squared stretches below which they count as equal.
const DEGENERATE: f64 = 1e-7;
/// Sweeps of Jacobi's method; it converges quadratically and never needs half of them.
const SWEEPS: usize = 16;

/// Principal frame of a left Cauchy–Green tensor.
#[derive(Debug, Clone, Copy)]
pub struct Spectral {
    /// Squared principal stretches.
    pub squares: [f64; 3],
    /// Dyads `n_a n_a`.
    pub dyads: [Voigt; 3],
    /// Symmetric parts of `n_a n_b` for (a, b) = (0, 1), (1, 2), (2, 0).
    pub mixed: [Voigt; 3],
}

/// The pairs of principal directions, in the order of [`Spectral::mixed`].
const PAIRS: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];

impl Spectral {
    /// Decomposes `b` by Jacobi's method, which finds small eigenvalues to full relative accuracy and
    /// orthonormal directions when they coincide; `None` unless `b` is positive definite.
    pub fn of(b: &Voigt) -> Option<Self> {
        let mut a = [[b[0], b[3], b[5]], [b[3], b[1], b[4]], [b[5], b[4], b[2]]];
        // Columns are the directions.
        let mut n = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut converged = false;
        for _ in 0..SWEEPS {
            let off = a[0][1] * a[0][1] + a[1][2] * a[1][2] + a[0][2] * a[0][2];
            let on = a[0][0] * a[0][0] + a[1][1] * a[1][1] + a[2][2] * a[2][2];
            // NaN never passes.
            if off <= 1e-34 * on {
                converged = true;
                break;
            }
            rotate::<0, 1, 2>(&mut a, &mut n);
            rotate::<0, 2, 1>(&mut a, &mut n);
            rotate::<1, 2, 0>(&mut a, &mut n);
        }
        let squares = [a[0][0], a[1][1], a[2][2]];
        if !(converged && squares.iter().all(|s| *s > 0.0 && s.is_finite())) {
            return None;
        }
        let mixed = |p: usize, q: usize| -> Voigt {
            let sym = |i: usize, j: usize| 0.5 * (n[i][p] * n[j][q] + n[j][p] * n[i][q]);
            [sym(0, 0), sym(1, 1), sym(2, 2), sym(0, 1), sym(1, 2), sym(2, 0)]
        };
        Some(Self {
            squares,
            dyads: [mixed(0, 0), mixed(1, 1), mixed(2, 2)],
            mixed: PAIRS.map(|(p, q)| mixed(p, q)),
        })
    }

    /// Principal logarithmic strains.
    #[inline]
    pub fn log_strains(&self) -> [f64; 3] {
        self.squares.map(|s| 0.5 * s.ln())
    }

    /// Tensor with principal values `v`.
    #[inline]
    pub fn compose(&self, v: &[f64; 3]) -> Voigt {
        std::array::from_fn(|i| (0..3).map(|a| v[a] * self.dyads[a][i]).sum())
    }

    /// Adds the spatial tangent (Oldroyd rate of `tau`) of an isotropic law with principal Kirchhoff
    /// stresses `tau` and their derivative `dtau` with respect to the logarithmic strains.
    #[inline]
    pub fn add_tangent(&self, tau: &[f64; 3], dtau: &[[f64; 3]; 3], into: &mut Voigt2) {
        let mut a = *dtau;
        for i in 0..3 {
            a[i][i] -= 2.0 * tau[i];
        }
        let shear: [f64; 3] = PAIRS.map(|(p, q)| {
            let (s1, s2) = (self.squares[p], self.squares[q]);
            let g = if (s1 - s2).abs() > DEGENERATE * s1.max(s2) {
                (tau[p] * s2 - tau[q] * s1) / (s1 - s2)
            } else {
                // The limit of equal stretches.
                0.25 * (dtau[p][p] - dtau[p][q] - dtau[q][p] + dtau[q][q]) - 0.5 * (tau[p] + tau[q])
            };
            4.0 * g
        });
        for i in 0..6 {
            let row: [f64; 3] = std::array::from_fn(|b| (0..3).map(|m| self.dyads[m][i] * a[m][b]).sum());
            let slip: [f64; 3] = std::array::from_fn(|k| shear[k] * self.mixed[k][i]);
            for j in 0..6 {
                for k in 0..3 {
                    into[i][j] += row[k] * self.dyads[k][j] + slip[k] * self.mixed[k][j];
                }
            }
        }
    }
}

/// One Jacobi rotation that makes the component (P, Q) zero; R is the third direction.
#[inline]
fn rotate<const P: usize, const Q: usize, const R: usize>(a: &mut Tensor, n: &mut Tensor) {
    let apq = a[P][Q];
    if apq == 0.0 {
        return;
    }
    let theta = (a[Q][Q] - a[P][P]) / (2.0 * apq);
    // For huge theta the square overflows to infinity and t becomes 0, as it should.
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    a[P][P] -= t * apq;
    a[Q][Q] += t * apq;
    (a[P][Q], a[Q][P]) = (0.0, 0.0);
    let (arp, arq) = (a[R][P], a[R][Q]);
    let (rp, rq) = (c * arp - s * arq, s * arp + c * arq);
    (a[R][P], a[P][R], a[R][Q], a[Q][R]) = (rp, rp, rq, rq);
    for row in n.iter_mut() {
        (row[P], row[Q]) = (c * row[P] - s * row[Q], s * row[P] + c * row[Q]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Goal: the decomposition is one. Set-up: distinct, double and triple eigenvalues, a wide range.
    /// Reference: composing back; unit trace of the dyads. Tolerance: 1e-13 relative.
    #[test]
    fn composes_back() {
        let tensors: [Voigt; 6] = [
            [1.3, 0.7, 0.9, 0.2, -0.1, 0.05],
            [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
            [2.0, 2.0, 2.0, 1.0, 1.0, 1.0], // eigenvalues 1, 1, 4
            [0.5, 2.0, 1.1, -0.4, 0.3, 0.2],
            [1.0 + 1e-12, 1.0, 1.0 - 1e-12, 1e-13, -2e-13, 1e-12],
            [1e6, 1e-3, 1.0, 0.1, 1e-3, 3.0],
        ];
        for b in tensors {
            let s = Spectral::of(&b).unwrap();
            let back = s.compose(&s.squares);
            let size = b.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            for i in 0..6 {
                assert!((back[i] - b[i]).abs() < 1e-13 * size, "{b:?}: {back:?}");
            }
            for d in s.dyads {
                approx::assert_relative_eq!(d[0] + d[1] + d[2], 1.0, max_relative = 1e-13);
            }
        }
    }

    #[test]
    fn indefinite_tensors_are_refused() {
        assert!(Spectral::of(&[1.0, 1.0, 1.0, 1.1, 0.0, 0.0]).is_none());
        assert!(Spectral::of(&[1.0, 1.0, -0.1, 0.0, 0.0, 0.0]).is_none());
        assert!(Spectral::of(&[f64::NAN, 1.0, 1.0, 0.0, 0.0, 0.0]).is_none());
    }
}
