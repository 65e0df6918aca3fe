//! Volume change (Eq. 10) and seepage (Eq. 11).

/// The drained skeleton's resistance to volume change, with bulk stiffness lambda* at small strain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Volumetric {
    /// `tau = lambda* (1-n0S)^2 (J/(1-n0S) - J/(J-n0S))` (Eq. 10).
    Compaction,
    /// `tau = lambda* m^2 ln((J-n0S)/m) J/(J-n0S)`, `m = 1-n0S`: logarithmic in the pore volume.
    LogarithmicPores,
}

impl Volumetric {
    /// `tau_vol` and its derivative by J (Pa).
    pub fn stress(self, lambda: f64, n0s: f64, j: f64) -> (f64, f64) {
        let (m, pore) = (1.0 - n0s, j - n0s);
        match self {
            Self::Compaction => {
                let k = lambda * m * m;
                (k * (j / m - j / pore), k * (1.0 / m + n0s / (pore * pore)))
            }
            Self::LogarithmicPores => {
                let (k, log) = (lambda * m * m, (pore / m).ln());
                (k * log * j / pore, k * (j - n0s * log) / (pore * pore))
            }
        }
    }
}

/// How the permeability follows the pore volume.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Seepage {
    /// `(J-n0S)/(1-n0S)` (Eq. 11).
    Linear,
    /// Eq. 11 times `exp(M (J-1)/(J-n0S))`.
    Exponential(f64),
}

impl Seepage {
    /// `k(J) / (K0/mu_FR)`.
    pub fn factor(self, n0s: f64, j: f64) -> f64 {
        let pore = j - n0s;
        let linear = pore / (1.0 - n0s);
        match self {
            Self::Linear => linear,
            Self::Exponential(exponent) => linear * (exponent * (j - 1.0) / pore).exp(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_derivatives_and_agree_at_small_strain() {
        for j in [0.7, 1.0, 1.3] {
            let h = 1e-6;
            for law in [Volumetric::Compaction, Volumetric::LogarithmicPores] {
                let at = |j| law.stress(1e5, 0.1, j).0;
                let slope = law.stress(1e5, 0.1, j).1;
                assert!(((at(j + h) - at(j - h)) / (2.0 * h) / slope - 1.0).abs() < 1e-7);
                assert!((law.stress(1e5, 0.1, 1.0).1 / 1e5 - 1.0).abs() < 1e-9 && at(1.0).abs() < 1e-9);
            }
        }
        assert!((Seepage::Exponential(4.0).factor(0.1, 1.0) - 1.0).abs() < 1e-15);
        assert!(Seepage::Exponential(4.0).factor(0.1, 0.9) < Seepage::Linear.factor(0.1, 0.9));
    }
}
