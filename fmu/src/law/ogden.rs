//! One Ogden term in principal deviatoric logarithmic strains (Eqs. 8, 9).

use crate::law::parameters::OgdenParameters;
use crate::number::{Real, closure, each};

/// `beta_a = mu (q_a - mean q)` with `q_a = exp(alpha e_a)`, `e` the deviatoric logarithmic strains.
#[derive(Debug, Clone, Copy)]
pub struct Ogden {
    mu: f64,
    alpha: f64,
    /// Factor on the parameter mu that is part of `mu` already.
    scale: f64,
}

impl Ogden {
    /// The law of a parameter pair.
    pub fn new(p: &OgdenParameters) -> Self {
        Self::scaled(p, 1.0)
    }

    /// The law with `scale` times the stress; its derivatives are still those by the parameters.
    pub fn scaled(p: &OgdenParameters, scale: f64) -> Self {
        Self { mu: scale * p.mu, alpha: p.alpha, scale }
    }

    /// Powers of the isochoric principal stretches, `q_a = ltilde_a^alpha`.
    #[inline(always)]
    pub fn powers<T: Real>(&self, e: &[T; 3]) -> [T; 3] {
        each(e, closure!(|e_a: T| (e_a * self.alpha).exp()))
    }

    /// `exp(alpha de)` for `|alpha de|` below 1e-5, to rounding.
    #[inline(always)]
    pub fn power_of_small<T: Real>(&self, de: T) -> T {
        let x = de * self.alpha;
        x * (x * 0.5 + 1.0) + 1.0
    }

    /// Principal Kirchhoff stresses `beta` (Pa) from the powers.
    #[inline(always)]
    pub fn stress<T: Real>(&self, q: &[T; 3]) -> [T; 3] {
        let mean = mean(q);
        each(q, closure!(|q_a: T| (q_a - mean) * self.mu))
    }

    /// Derivatives of `beta` at fixed strain by the parameters mu [-] and alpha (Pa).
    #[inline(always)]
    pub fn sensitivity<T: Real>(&self, e: &[T; 3], q: &[T; 3]) -> [[T; 3]; 2] {
        let slope = [e[0] * q[0], e[1] * q[1], e[2] * q[2]];
        let (mean_q, mean_slope) = (mean(q), mean(&slope));
        [
            each(q, closure!(|q_a: T| (q_a - mean_q) * self.scale)),
            each(&slope, closure!(|s: T| (s - mean_slope) * self.mu)),
        ]
    }

    /// `d beta / d eps` at zero strain on deviators, `mu alpha` (Pa).
    #[inline(always)]
    pub fn small_strain_stiffness(&self) -> f64 {
        self.mu * self.alpha
    }

    /// Diagonal `a = mu alpha q` (Pa); the tangent is `d beta / d eps = P diag(a) P`, P the deviator.
    #[inline(always)]
    pub fn stiffness<T: Real>(&self, q: &[T; 3]) -> [T; 3] {
        each(q, closure!(|q_a: T| q_a * (self.mu * self.alpha)))
    }

    /// Stored energy `mu / alpha (sum q - 3)` (J/m^3).
    #[inline(always)]
    pub fn energy<T: Real>(&self, q: &[T; 3]) -> T {
        (q[0] + q[1] + q[2] - 3.0) * (self.mu / self.alpha)
    }

    /// Tangent `P diag(a) P` (Pa).
    #[inline(always)]
    pub fn tangent<T: Real>(&self, q: &[T; 3]) -> [[T; 3]; 3] {
        let a = self.stiffness(q);
        let third = each(&a, closure!(|a_i: T| a_i * (1.0 / 3.0)));
        let ninth = mean(&third);
        let off = closure!(|i: usize, j: usize| ninth - (third[i] + third[j]));
        let (t01, t02, t12) = (off(0, 1), off(0, 2), off(1, 2));
        [[off(0, 0) + a[0], t01, t02], [t01, off(1, 1) + a[1], t12], [t02, t12, off(2, 2) + a[2]]]
    }
}

#[inline(always)]
fn mean<T: Real>(v: &[T; 3]) -> T {
    (v[0] + v[1] + v[2]) * (1.0 / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law() -> Ogden {
        Ogden::new(&OgdenParameters { mu: -418.0, alpha: -13.5 })
    }

    #[test]
    fn stress_is_the_energys_gradient() {
        let (law, h) = (law(), 1e-6);
        let e = [0.11, -0.07, -0.04];
        let beta = law.stress(&law.powers(&e));
        // Only deviatoric directions are admissible: compare along (1, -1, 0) and (0, 1, -1).
        for (i, j) in [(0, 1), (1, 2)] {
            let shifted = |s: f64| {
                let mut x = e;
                x[i] += s;
                x[j] -= s;
                law.energy(&law.powers(&x))
            };
            let slope = (shifted(h) - shifted(-h)) / (2.0 * h);
            approx::assert_relative_eq!(slope, beta[i] - beta[j], max_relative = 1e-7);
        }
    }

    #[test]
    fn small_strain_shear_modulus_is_half_mu_alpha() {
        let e = [1e-7, -0.5e-7, -0.5e-7];
        let beta = law().stress(&law().powers(&e));
        let g = 0.5 * 418.0 * 13.5;
        approx::assert_relative_eq!(beta[0], 2.0 * g * e[0], max_relative = 1e-5);
    }
}
