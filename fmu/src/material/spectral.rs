//! Spectral decomposition of axisymmetric tensors, and stress and tangent in the principal frame.

use super::{Voigt, Voigt2};

/// Relative difference of squared stretches below which they count as equal.
const DEGENERATE: f64 = 1e-7;

/// Principal frame of a left Cauchy–Green tensor.
#[derive(Debug, Clone, Copy, Default)]
pub struct Spectral {
    /// Squared principal stretches.
    pub squares: [f64; 3],
    /// Dyads `n_a n_a`.
    pub dyads: [Voigt; 3],
    /// `n_1 . d . n_2` as a linear form of the strain `d`.
    pub shear: Voigt,
}

impl Spectral {
    /// Decomposes `b = [rr, zz, tt, rz]`; `None` unless it is positive definite.
    #[inline(always)]
    pub fn of(b: &Voigt) -> Option<Self> {
        let (mean, half) = (0.5 * (b[0] + b[1]), 0.5 * (b[0] - b[1]));
        // Components are of order one: `hypot` would guard against an overflow that cannot happen.
        let radius = (half * half + b[3] * b[3]).sqrt();
        let (cos2, sin2) =
            if radius > f64::MIN_POSITIVE { (half / radius, b[3] / radius) } else { (1.0, 0.0) };
        let (c2, s2, cs) = (0.5 * (1.0 + cos2), 0.5 * (1.0 - cos2), 0.5 * sin2);
        let first = mean + radius;
        // det / first avoids the cancellation of mean - radius.
        let second = (b[0] * b[1] - b[3] * b[3]) / first;
        if !(second > 0.0 && b[2] > 0.0 && first.is_finite()) {
            return None;
        }
        Some(Self {
            squares: [first, second, b[2]],
            dyads: [[c2, s2, 0.0, cs], [s2, c2, 0.0, -cs], [0.0, 0.0, 1.0, 0.0]],
            shear: [-cs, cs, 0.0, 0.5 * cos2],
        })
    }

    /// Principal logarithmic strains.
    #[inline(always)]
    pub fn log_strains(&self) -> [f64; 3] {
        self.squares.map(|s| 0.5 * s.ln())
    }

    /// Tensor with principal values `v`.
    #[inline(always)]
    pub fn compose(&self, v: &[f64; 3]) -> Voigt {
        std::array::from_fn(|i| (0..3).map(|a| v[a] * self.dyads[a][i]).sum())
    }

    /// Change of the isotropic tensor with principal values `v` as the decomposed tensor changes by `change`.
    ///
    /// `slope[a][b]` is the derivative of `v_a` by the logarithmic strain b, `explicit` the change of `v` at
    /// fixed strain.
    #[inline(always)]
    pub fn differentiate(
        &self,
        v: &[f64; 3],
        slope: &[[f64; 3]; 3],
        explicit: &[f64; 3],
        change: &Voigt,
    ) -> Voigt {
        let strain: [f64; 3] = std::array::from_fn(|a| {
            let (d, s) = (&self.dyads[a], self.squares[a]);
            (d[0] * change[0] + d[1] * change[1] + d[2] * change[2] + 2.0 * d[3] * change[3]) / (2.0 * s)
        });
        let values: [f64; 3] = std::array::from_fn(|a| {
            explicit[a] + slope[a][0] * strain[0] + slope[a][1] * strain[1] + slope[a][2] * strain[2]
        });
        let (s1, s2) = (self.squares[0], self.squares[1]);
        let ratio = if (s1 - s2).abs() > DEGENERATE * s1 {
            (v[0] - v[1]) / (s1 - s2)
        } else {
            (slope[0][0] - slope[0][1] - slope[1][0] + slope[1][1]) / (4.0 * s1)
        };
        let n = &self.shear;
        let turn = 2.0 * ratio * (n[0] * change[0] + n[1] * change[1] + 2.0 * n[3] * change[3]);
        let mut result = self.compose(&values);
        result.iter_mut().zip(n).for_each(|(r, n)| *r += turn * n);
        result
    }

    /// Adds the spatial tangent (Oldroyd rate of `tau`) of an isotropic law with principal Kirchhoff
    /// stresses `tau` and their derivative `dtau` with respect to the logarithmic strains.
    #[inline(always)]
    pub fn add_tangent(&self, tau: &[f64; 3], dtau: &[[f64; 3]; 3], into: &mut Voigt2) {
        let mut a = *dtau;
        for i in 0..3 {
            a[i][i] -= 2.0 * tau[i];
        }
        let (s1, s2) = (self.squares[0], self.squares[1]);
        let g = if (s1 - s2).abs() > DEGENERATE * s1 {
            (tau[0] * s2 - tau[1] * s1) / (s1 - s2)
        } else {
            0.25 * (dtau[0][0] - dtau[0][1] - dtau[1][0] + dtau[1][1]) - 0.5 * (tau[0] + tau[1])
        };
        for i in 0..4 {
            let row: [f64; 3] = std::array::from_fn(|b| (0..3).map(|m| self.dyads[m][i] * a[m][b]).sum());
            for j in 0..4 {
                into[i][j] += row[0] * self.dyads[0][j]
                    + row[1] * self.dyads[1][j]
                    + row[2] * self.dyads[2][j]
                    + 4.0 * g * self.shear[i] * self.shear[j];
            }
        }
    }
}

/// Deviator of three principal values.
#[inline(always)]
pub fn deviator(v: &[f64; 3]) -> [f64; 3] {
    let mean = (v[0] + v[1] + v[2]) / 3.0;
    v.map(|x| x - mean)
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
            let exact = s.differentiate(&s.log_strains(), &identity, &[0.0; 3], &change);
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
