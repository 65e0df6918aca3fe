//! Seepage (Eq. 11), and a permeability that depends on strain: `K = K0 ((J - n0S)/(1 - n0S))^m`.
//!
//! A power of the pore volume, so that the permeability vanishes with it (Eipper, 1998, the exponent there
//! is m + 1).

use crate::number::Real;

/// `w = -(K0/mu_FR) (J-n)/(1-n) grad p`, n = n0S; K0 times `((J-n)/(1-n))^m` where the exponent m is not 0.
#[derive(Debug, Clone, Copy)]
pub struct Darcy {
    permeability: f64,
    fluid_viscosity: f64,
    n0s: f64,
    exponent: f64,
    /// Factor on the parameter K0 that is part of `permeability` already.
    scale: f64,
}

impl Darcy {
    /// The law for K0 (m^2), mu_FR (Pa s) and the initial solid fraction.
    pub fn new(permeability: f64, fluid_viscosity: f64, n0s: f64) -> Self {
        Self::extended(permeability, fluid_viscosity, n0s, 0.0, 1.0)
    }

    /// The law with an exponent and `scale` times the permeability; its derivatives are still those by K0.
    pub fn extended(permeability: f64, fluid_viscosity: f64, n0s: f64, exponent: f64, scale: f64) -> Self {
        Self { permeability: scale * permeability, fluid_viscosity, n0s, exponent, scale }
    }

    /// `J k(J)` (m^4/(N s)), k the current mobility, and its derivative with respect to J.
    ///
    /// `J` is there because the flux is integrated over the reference volume.
    #[inline(always)]
    pub fn referential_mobility<T: Real>(&self, j: T) -> (T, T) {
        let c = self.permeability / self.fluid_viscosity / (1.0 - self.n0s);
        let (mobility, slope) = (j * c * (j - self.n0s), (j * 2.0 - self.n0s) * c);
        if self.exponent == 0.0 {
            return (mobility, slope);
        }
        let [factor, by_j, _] = power_of_pores(self.exponent, j, self.n0s);
        (mobility * factor, slope * factor + mobility * by_j)
    }

    /// Derivative of the referential mobility by the exponent.
    #[inline(always)]
    pub fn by_exponent<T: Real>(&self, j: T) -> T {
        self.referential_mobility(j).0 * ((j - self.n0s) * (1.0 / (1.0 - self.n0s))).ln()
    }

    /// Derivatives of the referential mobility by K0, mu_FR and n0S.
    #[inline(always)]
    pub fn sensitivity<T: Real>(&self, j: T) -> [T; 3] {
        let (mobility, _) = self.referential_mobility(j);
        let open = 1.0 - self.n0s;
        let mut by_n0s = j * (j - 1.0) * (self.permeability / self.fluid_viscosity / (open * open));
        if self.exponent != 0.0 {
            let [factor, _, slope] = power_of_pores(self.exponent, j, self.n0s);
            by_n0s = by_n0s * factor + mobility / factor * slope;
        }
        [mobility * (self.scale / self.permeability), mobility * (-1.0 / self.fluid_viscosity), by_n0s]
    }
}

/// `((J-n)/(1-n))^m` and its derivatives by J and by n.
#[inline(always)]
fn power_of_pores<T: Real>(exponent: f64, j: T, n0s: f64) -> [T; 3] {
    let (pore, open) = (j - n0s, 1.0 - n0s);
    let value = (pore * (1.0 / open)).powf(exponent);
    let by_pore = value * exponent / pore;
    [value, by_pore, value * (exponent / open) - by_pore]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undeformed_mobility_is_permeability_over_viscosity() {
        for exponent in [0.0, 4.5] {
            let law = Darcy::extended(2.3e-15, 0.89e-3, 0.032, exponent, 1.0);
            let (m, dm) = law.referential_mobility(1.0);
            approx::assert_relative_eq!(m, 2.3e-15 / 0.89e-3, max_relative = 1e-14);
            let h = 1e-6;
            let slope =
                (law.referential_mobility(1.0 + h).0 - law.referential_mobility(1.0 - h).0) / (2.0 * h);
            approx::assert_relative_eq!(dm, slope, max_relative = 1e-8);
        }
    }

    #[test]
    fn sensitivities_are_slopes() {
        let (at, j, h) = ([2.3e-15, 0.89e-3, 0.2], 0.8, 1e-5);
        for (exponent, scale) in [(0.0, 1.0), (4.5, 0.7)] {
            let law = |p: [f64; 3]| Darcy::extended(p[0], p[1], p[2], exponent, scale);
            let exact = law(at).sensitivity(j);
            for k in 0..3 {
                let (mut up, mut down) = (at, at);
                up[k] *= 1.0 + h;
                down[k] *= 1.0 - h;
                let mobility = |p| law(p).referential_mobility(j).0;
                let slope = (mobility(up) - mobility(down)) / (2.0 * h * at[k]);
                approx::assert_relative_eq!(exact[k], slope, max_relative = 1e-8);
            }
        }
    }

    #[test]
    fn a_closed_pore_space_does_not_conduct() {
        assert_eq!(Darcy::new(1.0, 1.0, 0.2).referential_mobility(0.2).0, 0.0);
    }
}
