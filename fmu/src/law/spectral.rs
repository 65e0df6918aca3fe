//! Spectral decomposition of axisymmetric tensors, and stress and tangent in the principal frame.

use super::{Voigt, Voigt2};
use crate::number::{Real, closure, each};

/// Relative difference of squared stretches below which they count as equal.
const DEGENERATE: f64 = 1e-7;

/// Principal frame of a left Cauchy–Green tensor.
#[derive(Debug, Clone, Copy, Default)]
pub struct Spectral<T = f64> {
    /// Squared principal stretches.
    pub squares: [T; 3],
    /// First dyad `n_1 n_1` (rr, zz, rz); the second is its complement in the plane, the third the hoop's.
    dyad: [T; 3],
    /// Half the cosine of twice the angle between `n_1` and the radius: `n_1 . d . n_2` is
    /// `-rz (d_rr - d_zz) + half_cos d_rz` with rz of the dyad and an engineering shear.
    half_cos: T,
}

impl<T: Real> Spectral<T> {
    /// Decomposes `b = [rr, zz, tt, rz]`; `None` unless it is positive definite (in every lane).
    #[inline(always)]
    pub fn of(b: &Voigt<T>) -> Option<Self> {
        let (mean, half) = ((b[0] + b[1]) * 0.5, (b[0] - b[1]) * 0.5);
        // Components are of order one: `hypot` would guard against an overflow that cannot happen.
        let radius = half.mul_add(half, b[3] * b[3]).sqrt();
        let first = mean + radius;
        // det / first avoids the cancellation of mean - radius.
        let second = (b[0] * b[1] - b[3] * b[3]) / first;
        let least = first.constant(f64::MIN_POSITIVE);
        if !(second.all_greater(least)
            && b[2].all_greater(least)
            && first.constant(f64::INFINITY).all_greater(first))
        {
            return None;
        }
        // Hosts may trap a division by zero, also where its result is not taken.
        let inverse = radius.max(least).recip() * 0.5;
        let half_cos = radius.where_greater(least, half * inverse, radius.constant(0.5));
        let rz = radius.where_greater(least, b[3] * inverse, radius.constant(0.0));
        Some(Self { squares: [first, second, b[2]], dyad: [half_cos + 0.5, -half_cos + 0.5, rz], half_cos })
    }

    /// Principal logarithmic strains.
    #[inline(always)]
    pub fn log_strains(&self) -> [T; 3] {
        each(&self.squares, closure!(|s: T| s.ln() * 0.5))
    }

    /// Tensor with principal values `v`.
    #[inline(always)]
    pub fn compose(&self, v: &[T; 3]) -> Voigt<T> {
        let [c2, s2, cs] = self.dyad;
        [v[0].mul_add(c2, v[1] * s2), v[0].mul_add(s2, v[1] * c2), v[2], (v[0] - v[1]) * cs]
    }

    /// `numerator / (s1 - s2)` where the in-plane stretches differ, `limit` where they count as equal; never a
    /// division by zero.
    #[inline(always)]
    fn quotient(&self, numerator: T, limit: T) -> T {
        let [s1, s2, _] = self.squares;
        let (apart, least) = (s1 - s2, s1 * DEGENERATE);
        apart.where_greater(least, numerator / apart.max(least), limit)
    }

    /// Change of the isotropic tensor with principal values `v` as the decomposed tensor changes by `change`.
    ///
    /// `slope[a][b]` is the derivative of `v_a` by the logarithmic strain b.
    #[inline(always)]
    pub fn differentiate(&self, v: &[T; 3], slope: &[[T; 3]; 3], change: &Voigt<T>) -> Voigt<T> {
        let [c2, d2, cs] = self.dyad;
        let half = each(&self.squares, closure!(|s: T| s.recip() * 0.5));
        let limit = (slope[0][0] - slope[0][1] - slope[1][0] + slope[1][1]) * half[0] * 0.5;
        let ratio = self.quotient(v[0] - v[1], limit) * 2.0;
        let twist = cs * change[3] * 2.0;
        let strain = [
            c2.mul_add(change[0], d2.mul_add(change[1], twist)) * half[0],
            d2.mul_add(change[0], c2.mul_add(change[1], -twist)) * half[1],
            change[2] * half[2],
        ];
        let values = each(
            slope,
            closure!(|s: [T; 3]| s[0].mul_add(strain[0], s[1].mul_add(strain[1], s[2] * strain[2]))),
        );
        let turn = ratio * cs.mul_add(change[1] - change[0], self.half_cos * change[3] * 2.0);
        let [rr, zz, tt, rz] = self.compose(&values);
        [rr - turn * cs, zz + turn * cs, tt, turn.mul_add(self.half_cos, rz)]
    }

    /// Adds the spatial tangent (Oldroyd rate of `tau`) of an isotropic law with principal Kirchhoff
    /// stresses `tau` and their derivative `dtau` with respect to the logarithmic strains.
    #[inline(always)]
    pub fn add_tangent(&self, tau: &[T; 3], dtau: &[[T; 3]; 3], into: &mut Voigt2<T>) {
        let mut a = *dtau;
        for i in 0..3 {
            a[i][i] -= tau[i] * 2.0;
        }
        let ([s1, s2, _], [c2, d2, cs]) = (self.squares, self.dyad);
        let limit = (dtau[0][0] - dtau[0][1] - dtau[1][0] + dtau[1][1]) * 0.25 - (tau[0] + tau[1]) * 0.5;
        let g = self.quotient(tau[0] * s2 - tau[1] * s1, limit);
        // In-plane components rr, zz, rz of both dyads, and of the shear with its factor.
        let (first, second) = ([c2, d2, cs], [d2, c2, -cs]);
        let shear = [-cs, cs, self.half_cos];
        for (i, row) in [0, 1, 3].into_iter().enumerate() {
            let along = each(&[0, 1, 2], closure!(|b: usize| first[i].mul_add(a[0][b], second[i] * a[1][b])));
            let turn = g * shear[i] * 4.0;
            for (j, column) in [0, 1, 3].into_iter().enumerate() {
                let sum = turn.mul_add(shear[j], into[row][column]);
                into[row][column] = along[0].mul_add(first[j], along[1].mul_add(second[j], sum));
            }
            into[row][2] += along[2];
            into[2][row] += a[2][0].mul_add(first[i], a[2][1] * second[i]);
        }
        into[2][2] += a[2][2];
    }
}

/// Deviator of three principal values.
#[inline(always)]
pub fn deviator<T: Real>(v: &[T; 3]) -> [T; 3] {
    let mean = (v[0] + v[1] + v[2]) * (1.0 / 3.0);
    each(v, closure!(|x: T| x - mean))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn composes_back() {
        for b in [[1.3, 0.7, 0.9, 0.2], [1.0, 1.0, 1.0, 0.0], [0.5, 2.0, 1.1, -0.4]] {
            let s = Spectral::of(&b).unwrap();
            let back = s.compose(&s.squares);
            for i in 0..4 {
                approx::assert_relative_eq!(back[i], b[i], epsilon = 1e-14, max_relative = 1e-13);
            }
        }
    }

    /// `log b` against central differences along changes that stretch, shear and turn.
    #[test]
    fn differentiates_isotropic_functions() {
        let log = |b: &Voigt| {
            let s = Spectral::of(b).unwrap();
            s.compose(&s.log_strains())
        };
        let (change, h) = ([0.3, -0.2, 0.5, 0.4], 1e-6);
        for b in [[1.3, 0.7, 0.9, 0.2], [1.0, 1.0, 1.0, 0.0], [0.5, 2.0, 1.1, -0.4]] {
            let s = Spectral::of(&b).unwrap();
            let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let exact = s.differentiate(&s.log_strains(), &identity, &change);
            let moved = |sign: f64| log(&std::array::from_fn(|i| b[i] + sign * h * change[i]));
            let (up, down) = (moved(1.0), moved(-1.0));
            for i in 0..4 {
                let slope = (up[i] - down[i]) / (2.0 * h);
                approx::assert_relative_eq!(exact[i], slope, max_relative = 1e-7, epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn indefinite_tensors_are_refused() {
        assert!(Spectral::of(&[1.0, 1.0, 1.0, 1.1]).is_none());
        assert!(Spectral::of(&[1.0, 1.0, -0.1, 0.0]).is_none());
        assert!(Spectral::of(&[f64::NAN, 1.0, 1.0, 0.0]).is_none());
    }
}
