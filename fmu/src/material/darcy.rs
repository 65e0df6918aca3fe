//! Seepage (Eq. 11).

/// `w = -(K0/mu_FR) (J-n)/(1-n) grad p`, n = n0S.
#[derive(Debug, Clone, Copy)]
pub struct Darcy {
    permeability: f64,
    fluid_viscosity: f64,
    n0s: f64,
}

impl Darcy {
    /// The law for K0 (m^2), mu_FR (Pa s) and the initial solid fraction.
    pub fn new(permeability: f64, fluid_viscosity: f64, n0s: f64) -> Self {
        Self { permeability, fluid_viscosity, n0s }
    }

    /// `J k(J)` (m^4/(N s)), k the current mobility, and its derivative with respect to J.
    ///
    /// `J` is there because the flux is integrated over the reference volume.
    #[inline(always)]
    pub fn referential_mobility(&self, j: f64) -> (f64, f64) {
        let c = self.permeability / self.fluid_viscosity / (1.0 - self.n0s);
        (c * j * (j - self.n0s), c * (2.0 * j - self.n0s))
    }

    /// Derivatives of the referential mobility by K0, mu_FR and n0S.
    #[inline(always)]
    pub fn sensitivity(&self, j: f64) -> [f64; 3] {
        let (mobility, _) = self.referential_mobility(j);
        let open = 1.0 - self.n0s;
        let by_n0s = self.permeability / self.fluid_viscosity * j * (j - 1.0) / (open * open);
        [mobility / self.permeability, -mobility / self.fluid_viscosity, by_n0s]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undeformed_mobility_is_permeability_over_viscosity() {
        let law = Darcy::new(2.3e-15, 0.89e-3, 0.032);
        let (m, dm) = law.referential_mobility(1.0);
        approx::assert_relative_eq!(m, 2.3e-15 / 0.89e-3, max_relative = 1e-14);
        let h = 1e-6;
        let slope = (law.referential_mobility(1.0 + h).0 - law.referential_mobility(1.0 - h).0) / (2.0 * h);
        approx::assert_relative_eq!(dm, slope, max_relative = 1e-8);
    }

    #[test]
    fn sensitivities_are_slopes() {
        let (at, j, h) = ([2.3e-15, 0.89e-3, 0.2], 0.8, 1e-5);
        let mobility = |p: [f64; 3]| Darcy::new(p[0], p[1], p[2]).referential_mobility(j).0;
        let exact = Darcy::new(at[0], at[1], at[2]).sensitivity(j);
        for k in 0..3 {
            let (mut up, mut down) = (at, at);
            up[k] *= 1.0 + h;
            down[k] *= 1.0 - h;
            let slope = (mobility(up) - mobility(down)) / (2.0 * h * at[k]);
            approx::assert_relative_eq!(exact[k], slope, max_relative = 1e-8);
        }
    }

    #[test]
    fn a_closed_pore_space_does_not_conduct() {
        assert_eq!(Darcy::new(1.0, 1.0, 0.2).referential_mobility(0.2).0, 0.0);
    }
}
