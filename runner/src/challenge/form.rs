//! Causes of the near ground, which act on the engine's parameters, its motion (`motion.rs`) or its reading (`reading.rs`): effects of
//! the catalogue in other forms than the catalogue's where these are not the engine's own, and five causes that it does not have.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A cause with its size (SI).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "form", rename_all = "kebab-case")]
pub enum Form {
    /// Drift that slows down, where the catalogue's is linear: `rate T (1 - exp(-t/T))`.
    SaturatingDrift {
        /// Initial rate (N/s).
        rate: f64,
        /// T (s).
        time_s: f64,
    },
    /// Two equal low passes in series, where the catalogue has one.
    TwoPoleLag {
        /// Sum of both time constants (s).
        time_s: f64,
    },
    /// The surface lies higher than recorded; the motion itself is shifted.
    ShiftedSurface {
        /// Height (m).
        height: f64,
    },
    /// The second test's specimens are stiffer by a factor.
    Batch {
        /// ln of the factor.
        log_factor: f64,
    },
    /// A slow branch of a time that the catalogue does not try.
    SlowBranch {
        /// Ogden modulus (Pa), exponent that of the FMU.
        mu: f64,
        /// Viscosity (Pa s).
        eta: f64,
    },
    /// Flow by the hyperbolic sine.
    Flow {
        /// Inverse stress (1/Pa).
        inverse_stress: f64,
    },
    /// Softening of another strain scale.
    Damage {
        /// Part of the stress that is lost.
        loss: f64,
        /// Its strain.
        strain: f64,
    },
    /// Stiffening or softening with time.
    Ageing {
        /// Rate (1/s).
        rate: f64,
    },
    /// An elastic frame.
    Frame {
        /// Compliance (m/N).
        per_newton: f64,
    },
    /// A drained skeleton that can be compressed.
    SoftSkeleton {
        /// lambda* (Pa).
        lambda: f64,
    },
    /// Outside the catalogue: the drive overshoots at the end of the ramp and swings.
    Overshoot {
        /// Amplitude (m).
        length: f64,
        /// Frequency (Hz).
        frequency: f64,
        /// Decay time (s).
        decay_s: f64,
    },
    /// Outside: the warming frame pushes the punch on during the hold, unseen by the displacement sensor.
    WarmingFrame {
        /// Length (m).
        length: f64,
        /// Time (s).
        time_s: f64,
    },
    /// Outside: water climbs the punch on contact and pulls with a constant force.
    Meniscus {
        /// Force (N).
        force: f64,
    },
    /// Outside: a periodic disturbance, e.g. of the air conditioning.
    Hum {
        /// Amplitude (N).
        force: f64,
        /// Period (s).
        period_s: f64,
    },
    /// Outside: the amplifier's gain changes for a while during the hold.
    GainStep {
        /// Relative change (-).
        part: f64,
        /// Begin, after the end of the ramp (s).
        from_s: f64,
        /// End (s).
        to_s: f64,
    },
}

impl Form {
    /// Name in the catalogue; `None` outside of it.
    pub fn effect(&self) -> Option<&'static str> {
        Some(match self {
            Self::SaturatingDrift { .. } => "load_cell_drift",
            Self::TwoPoleLag { .. } => "load_cell_lag",
            Self::ShiftedSurface { .. } => "offset",
            Self::Batch { .. } => "amplitude",
            Self::SlowBranch { .. } => "third_branch",
            Self::Flow { .. } => "eyring",
            Self::Damage { .. } => "softening",
            Self::Ageing { .. } => "modulus_drift",
            Self::Frame { .. } => "compliance",
            Self::SoftSkeleton { .. } => "lambda_star",
            Self::Overshoot { .. }
            | Self::WarmingFrame { .. }
            | Self::Meniscus { .. }
            | Self::Hum { .. }
            | Self::GainStep { .. } => return None,
        })
    }

    /// Parameters of the FMU.
    pub fn set(&self, values: &mut BTreeMap<String, f64>) {
        let mut set = |name: &str, value: f64| {
            values.insert(name.to_owned(), value);
        };
        match *self {
            Self::SlowBranch { mu, eta } => {
                set("material.branch[3].mu", mu);
                set("material.branch[3].eta", eta);
            }
            Self::Flow { inverse_stress } => set("effect.eyring.inverse_stress", inverse_stress),
            Self::Damage { loss, strain } => {
                set("effect.softening.loss", loss);
                set("effect.softening.strain", strain);
            }
            Self::Ageing { rate } => set("effect.modulus_drift.rate", rate),
            Self::Frame { per_newton } => set("effect.compliance.per_newton", per_newton),
            Self::SoftSkeleton { lambda } => set("material.lambda_star", lambda),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_outside_the_catalogue_have_no_name_in_it() {
        let names: Vec<&str> = poropunch::effect::CATALOGUE.iter().map(|e| e.name).collect();
        let inside = Form::TwoPoleLag { time_s: 0.1 };
        assert!(names.contains(&inside.effect().unwrap()));
        assert!(Form::Hum { force: 1e-4, period_s: 7.0 }.effect().is_none());
    }
}
