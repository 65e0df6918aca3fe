//! One Ogden term in principal deviatoric logarithmic strains (Eqs. 8, 9).

use crate::parameters::OgdenParameters;

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
    pub fn powers(&self, e: &[f64; 3]) -> [f64; 3] {
        e.map(|e_a| (self.alpha * e_a).exp())
    }

    /// `exp(alpha de)` for `|alpha de|` below 1e-5, to rounding.
    #[inline(always)]
    pub fn power_of_small(&self, de: f64) -> f64 {
        let x = self.alpha * de;
        1.0 + x * (1.0 + 0.5 * x)
    }

    /// Principal Kirchhoff stresses `beta` (Pa) from the powers.
    #[inline(always)]
    pub fn stress(&self, q: &[f64; 3]) -> [f64; 3] {
        let mean = (q[0] + q[1] + q[2]) / 3.0;
        q.map(|q_a| self.mu * (q_a - mean))
    }

    /// Derivatives of `beta` at fixed strain by the parameters mu [-] and alpha (Pa).
    #[inline(always)]
    pub fn sensitivity(&self, e: &[f64; 3], q: &[f64; 3]) -> [[f64; 3]; 2] {
        let slope: [f64; 3] = std::array::from_fn(|a| e[a] * q[a]);
        let (mean_q, mean_slope) = ((q[0] + q[1] + q[2]) / 3.0, (slope[0] + slope[1] + slope[2]) / 3.0);
        [q.map(|q_a| self.scale * (q_a - mean_q)), slope.map(|s| self.mu * (s - mean_slope))]
    }

    /// `d beta / d eps` at zero strain on deviators, `mu alpha` (Pa).
    #[inline(always)]
    pub fn small_strain_stiffness(&self) -> f64 {
        self.mu * self.alpha
    }

    /// Diagonal `a = mu alpha q` (Pa); the tangent is `d beta / d eps = P diag(a) P`, P the deviator.
    #[inline(always)]
    pub fn stiffness(&self, q: &[f64; 3]) -> [f64; 3] {
        q.map(|q_a| self.mu * self.alpha * q_a)
    }

    /// Stored energy `mu / alpha (sum q - 3)` (J/m^3).
    #[inline(always)]
    pub fn energy(&self, q: &[f64; 3]) -> f64 {
        self.mu / self.alpha * (q[0] + q[1] + q[2] - 3.0)
    }

    /// Tangent `P diag(a) P` (Pa).
    #[inline(always)]
    pub fn tangent(&self, q: &[f64; 3]) -> [[f64; 3]; 3] {
        let a = self.stiffness(q);
        let mean = (a[0] + a[1] + a[2]) / 9.0;
        let mut t = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                t[i][j] = mean - (a[i] + a[j]) / 3.0;
            }
            t[i][i] += a[i];
        }
        t
    }
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
