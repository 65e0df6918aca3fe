//! Volumetric extra stress with a compaction point (Eq. 10).

use crate::number::Real;

/// `tau_vol = lambda* (1-n)^2 (J/(1-n) - J/(J-n)) 1`, n = n0S; `J -> n` is compaction.
#[derive(Debug, Clone, Copy)]
pub struct Volumetric {
    lambda_star: f64,
    n0s: f64,
    /// Factor on the parameter lambda* that is part of `lambda_star` already.
    scale: f64,
}

impl Volumetric {
    /// The law for lambda* (Pa) and the initial solid fraction.
    pub fn new(lambda_star: f64, n0s: f64) -> Self {
        Self::scaled(lambda_star, n0s, 1.0)
    }

    /// The law with `scale` times the stress; its derivatives are still those by the parameters.
    pub fn scaled(lambda_star: f64, n0s: f64, scale: f64) -> Self {
        Self { lambda_star: scale * lambda_star, n0s, scale }
    }

    /// Kirchhoff stress (Pa) on the diagonal and `J d tau / dJ` (Pa) at the dilatation `J - 1`: a large lambda* on a large
    /// element would make a force of the rounding of J.
    #[inline(always)]
    pub fn stress<T: Real>(&self, dilatation: T) -> (T, T) {
        let (s, n) = (1.0 - self.n0s, self.n0s);
        let j = dilatation + 1.0;
        let c = j * (self.lambda_star * s);
        let inverse = (dilatation + s).recip();
        (c * dilatation * inverse, c * (inverse * inverse * (n * s) + 1.0))
    }

    /// Derivatives of the Kirchhoff stress by the parameters lambda* [-] and n0S (Pa).
    #[inline(always)]
    pub fn sensitivity<T: Real>(&self, j: T) -> [T; 2] {
        let s = 1.0 - self.n0s;
        let closed = (j - self.n0s).recip() * s;
        let by_n0s = j * self.lambda_star * (closed * 2.0 - closed * closed - 1.0);
        [j * (self.scale * s) * (-closed + 1.0), by_n0s]
    }

    /// Stored energy (J/m^3).
    #[inline(always)]
    pub fn energy<T: Real>(&self, j: T) -> T {
        let (s, n) = (1.0 - self.n0s, self.n0s);
        let inverse = 1.0 / s;
        ((j - 1.0) * inverse - ((j - n) * inverse).ln()) * (self.lambda_star * s * s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn stress_and_stiffness_derive_from_the_energy() {
        let law = Volumetric::new(1e5, 0.2);
        for j in [0.4, 0.9, 1.0, 1.3] {
            let h = 1e-6;
            let (tau, stiffness) = law.stress(j - 1.0);
            let slope = j * (law.energy(j + h) - law.energy(j - h)) / (2.0 * h);
            assert_relative_eq!(tau, slope, max_relative = 1e-6, epsilon = 1e-3);
            let slope = j * (law.stress(j - 1.0 + h).0 - law.stress(j - 1.0 - h).0) / (2.0 * h);
            assert_relative_eq!(stiffness, slope, max_relative = 1e-7);
        }
    }

    #[test]
    fn sensitivities_are_slopes() {
        let (j, h) = (0.8, 1e-6);
        let tau = |lambda_star, n0s| Volumetric::new(lambda_star, n0s).stress(j - 1.0).0;
        let [by_lambda, by_n0s] = Volumetric::new(1e5, 0.2).sensitivity(j);
        assert_relative_eq!(
            by_lambda,
            (tau(1e5 + 1.0, 0.2) - tau(1e5 - 1.0, 0.2)) / 2.0,
            max_relative = 1e-7
        );
        assert_relative_eq!(by_n0s, (tau(1e5, 0.2 + h) - tau(1e5, 0.2 - h)) / (2.0 * h), max_relative = 1e-7);
    }

    #[test]
    fn undeformed_is_stress_free_with_modulus_lambda_star() {
        let (tau, stiffness) = Volumetric::new(1e5, 0.032).stress(0.0);
        assert_eq!(tau, 0.0);
        assert_relative_eq!(stiffness, 1e5, max_relative = 1e-12);
    }

    #[test]
    fn compaction_resists_without_bound() {
        assert!(Volumetric::new(1e5, 0.2).stress(1e-9 - 0.8).0 < -1e10);
    }
}
