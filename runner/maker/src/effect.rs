//! What can be behind a case: the catalogue's seventeen effects, each in another form than poropunch's, and causes
//! that the catalogue does not have.
//!
//! A `size` is a multiple of the catalogue's plausible scale (`fmu/src/effect/README.md`); 0 is the plain model.

use serde::{Deserialize, Serialize};

/// A cause with its size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "form", rename_all = "kebab-case")]
pub enum Effect {
    /// Slow third branch: two equal slow branches with times `time_s / 2.5` and `time_s * 2.5`, together of the shear
    /// modulus 60 Pa times `size`.
    SlowPair {
        /// Times 60 Pa.
        size: f64,
        /// Middle of both relaxation times (s); the catalogue's is 200.
        time_s: f64,
    },
    /// Nonlinear viscosity: Carreau's law, fluidity `(1 + (s/s0)^2)^1.5` with `s0 = 3 x 200 Pa / size`, to second order
    /// the hyperbolic sine of the catalogue.
    Carreau {
        /// Times 0.005 1/Pa.
        size: f64,
    },
    /// Strain-dependent permeability: `exp(M (J-1)/(J-n0S))` times Eq. 11, `M = 5 size`.
    ExponentialPermeability {
        /// Times 5.
        size: f64,
    },
    /// Compressible skeleton: a logarithmic law of the pore volume with lambda* times `0.02^size`.
    LogarithmicSkeleton {
        /// In the logarithm: 1 is 2000 Pa in Table 1; much beyond, the specimen folds at the edge and has no solution.
        size: f64,
    },
    /// Softening with the largest energy that the equilibrium spring stored: stresses fall to `1 - 0.3 size` of theirs
    /// around the energy of a strain of 0.2.
    EnergySoftening {
        /// Times 0.3; at most 2: what softens more has no stable equilibrium.
        size: f64,
    },
    /// Modulus drift that saturates: all moduli and viscosities times `1 + rate T (1 - exp(-t/T))`,
    /// `rate = 1e-4 size` per second.
    SaturatingAgeing {
        /// Times 1e-4 1/s, either sign.
        size: f64,
        /// T (s).
        time_s: f64,
    },
    /// Batch of other stiffness: all moduli and viscosities times `1.22^size`, K0 divided by it.
    Batch {
        /// In the logarithm, times 0.2, either sign.
        size: f64,
    },
    /// Specimen of another radius and height than said, both times `2^size`.
    Dimensions {
        /// In the logarithm: 1 is the sample as cut.
        size: f64,
    },
    /// Slipping punch: a viscous film of `1e6 Pa s/m / size` under it.
    Film {
        /// Over 1e6 Pa s/m.
        size: f64,
    },
    /// Slipping punch: Coulomb's friction with a small coefficient.
    LowFriction {
        /// Coefficient [-].
        coefficient: f64,
    },
    /// Drained punch face: a permeance as of a layer of the specimen of a fiftieth of the punch's radius over `size`.
    LeakyFace {
        /// 0 is tight, 1 drains nearly freely.
        size: f64,
    },
    /// Bottom that hardly drains: a permeance as of a layer of the specimen of its height times `size`.
    TightBottom {
        /// 0 drains freely.
        size: f64,
    },
    /// Lateral surface that hardly drains, likewise.
    TightSide {
        /// 0 drains freely.
        size: f64,
    },
    /// Adhesion on retraction: traction `100 Pa size exp(-gap / 0.1 mm)`.
    ExponentialAdhesion {
        /// Times 100 Pa.
        size: f64,
    },
    /// Contact-point offset: the surface lies `0.02 mm size` higher than recorded.
    ShiftedSurface {
        /// Times 2e-5 m, either sign.
        size: f64,
    },
    /// Machine compliance: a frame that stiffens, `C F0 asinh(F/F0)`, `C = 0.002 m/N size`.
    StiffeningFrame {
        /// Times 0.002 m/N.
        size: f64,
        /// F0 (N): about the peak.
        force: f64,
    },
    /// Load-cell drift that saturates: `2e-6 N/s size T (1 - exp(-t/T))`.
    SaturatingDrift {
        /// Times 2e-6 N/s, either sign.
        size: f64,
        /// T (s).
        time_s: f64,
    },
    /// Load-cell lag: two equal low passes in series, together of `0.05 s size`.
    TwoPoleLag {
        /// Times 0.05 s.
        size: f64,
    },
    /// Numerical error of a coarse mesh and of long steps with a share `size`, at most 1, of backward Euler.
    Coarse {
        /// Sides of the triangles times `2^size`, the steps' tolerance times `10^size`.
        size: f64,
    },
    /// Outside: the drive overshoots at the end of every loading ramp and swings; the record does not show it.
    Overshoot {
        /// Amplitude (m).
        length: f64,
        /// Frequency (Hz).
        frequency: f64,
        /// Decay time (s).
        decay_s: f64,
    },
    /// Outside: a periodic force, mains hum (aliased by the sampling) or a thermal wave of the load cell.
    Wave {
        /// Amplitude (N).
        force: f64,
        /// Period (s).
        period_s: f64,
        /// Phase (rad).
        phase: f64,
    },
    /// Outside: the grip slips once.
    GripStep {
        /// Length that is lost (m).
        length: f64,
        /// When (s).
        time_s: f64,
    },
    /// Outside: water climbs the punch at first touch and pulls while the punch is no higher than `reach`.
    Meniscus {
        /// Force (N).
        force: f64,
        /// Height at which the bridge breaks (m).
        reach: f64,
    },
    /// Outside: a tilted punch touches over a depth; the force times the share of the face that is below the surface.
    Tilt {
        /// Depth until the whole face touches (m).
        height: f64,
    },
    /// Outside: the amplifier clips.
    Clip {
        /// Largest reading over the one without the limit [-].
        part: f64,
    },
    /// Outside: the force's clock runs faster than the record's.
    Clock {
        /// Relative rate [-].
        rate: f64,
    },
    /// Outside: a bubble in the specimen collapses, and all moduli fall at once.
    Bubble {
        /// Share that is lost.
        loss: f64,
        /// When (s).
        time_s: f64,
    },
    /// Outside: the warming frame pushes the punch on, unseen by the displacement sensor.
    WarmingFrame {
        /// Length (m).
        length: f64,
        /// Time constant (s).
        time_s: f64,
    },
    /// Outside: play in the drive; the punch follows the record this far behind after every reversal.
    Backlash {
        /// Length (m).
        length: f64,
    },
    /// Outside: the amplifier's gain is another for a while.
    Gain {
        /// Relative change [-].
        part: f64,
        /// Begin (s).
        from_s: f64,
        /// End (s).
        to_s: f64,
    },
}

impl Effect {
    /// Name in poropunch's catalogue; `None` outside of it.
    pub fn catalogue(&self) -> Option<&'static str> {
        Some(match self {
            Self::SlowPair { .. } => "third_branch",
            Self::Carreau { .. } => "eyring",
            Self::ExponentialPermeability { .. } => "permeability",
            Self::LogarithmicSkeleton { .. } => "lambda_star",
            Self::EnergySoftening { .. } => "softening",
            Self::SaturatingAgeing { .. } => "modulus_drift",
            Self::Batch { .. } => "amplitude",
            Self::Dimensions { .. } => "specimen_size",
            Self::Film { .. } | Self::LowFriction { .. } => "slip",
            Self::LeakyFace { .. } => "drained_punch",
            Self::TightBottom { .. } | Self::TightSide { .. } => "drainage",
            Self::ExponentialAdhesion { .. } => "adhesion",
            Self::ShiftedSurface { .. } => "offset",
            Self::StiffeningFrame { .. } => "compliance",
            Self::SaturatingDrift { .. } => "load_cell_drift",
            Self::TwoPoleLag { .. } => "load_cell_lag",
            Self::Coarse { .. } => "discretisation",
            _ => return None,
        })
    }
}
