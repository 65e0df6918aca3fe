//! Beside the material's parameters: the magnitudes of effects that results are differentiated by.

/// One magnitude; in every list of derivatives they follow the material's parameters, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Magnitude {
    /// `1 / tau_0` of Eyring flow (1/Pa).
    InverseStress,
    /// Exponent of the permeability's dependence on the pore volume [-].
    PermeabilityExponent,
    /// Share of the stress that softening takes [-].
    Loss,
    /// Strain in which it does [-].
    LossStrain,
    /// Rate at which moduli and viscosities grow (1/s).
    GrowthRate,
    /// Logarithm of the factor on all stresses [-].
    Amplitude,
    /// Compliance of the shear layer under the punch (m/Pa).
    ShearCompliance,
    /// Strength of adhesion (Pa).
    AdhesiveStrength,
    /// Height of the surface above the zero of the displacement (m).
    SurfaceHeight,
    /// Compliance of the machine (m/N).
    MachineCompliance,
    /// Rate at which the load cell's zero drifts (N/s).
    DriftRate,
    /// Time constant of the load cell (s).
    Lag,
}

impl Magnitude {
    /// All of them.
    pub const ALL: [Self; 12] = [
        Self::InverseStress,
        Self::PermeabilityExponent,
        Self::Loss,
        Self::LossStrain,
        Self::GrowthRate,
        Self::Amplitude,
        Self::ShearCompliance,
        Self::AdhesiveStrength,
        Self::SurfaceHeight,
        Self::MachineCompliance,
        Self::DriftRate,
        Self::Lag,
    ];
    /// Number of the first, which the laws of the material depend on.
    pub const OF_LAWS: usize = 6;
    /// Number of the first, which the force on the specimen depends on; the rest are the load cell's.
    pub const OF_SPECIMEN: usize = 10;

    /// Place among the magnitudes.
    pub const fn index(self) -> usize {
        self as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_follow_the_order() {
        for (index, magnitude) in Magnitude::ALL.into_iter().enumerate() {
            assert_eq!(magnitude.index(), index);
        }
        assert_eq!(Magnitude::ShearCompliance.index(), Magnitude::OF_LAWS);
        assert_eq!(Magnitude::DriftRate.index(), Magnitude::OF_SPECIMEN);
    }
}
