//! What can be behind a case: effects of the catalogue in other forms than the catalogue's, and causes that it does
//! not have.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A cause with its size (SI).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "form", rename_all = "kebab-case")]
pub enum Cause {
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

impl Cause {
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

    /// The true motion, of points (s, m), of which the record knows nothing.
    pub fn moved(&self, points: &[(f64, f64)]) -> Vec<(f64, f64)> {
        match *self {
            Self::ShiftedSurface { height } => points.iter().map(|&(t, d)| (t, d + height)).collect(),
            Self::Overshoot { length, frequency, decay_s } => {
                const PER_PERIOD: f64 = 12.0;
                let swing =
                    |s: f64| length * (-s / decay_s).exp() * (std::f64::consts::TAU * frequency * s).sin();
                let step = 1.0 / (PER_PERIOD * frequency);
                let times = (1..).map(|k| f64::from(k) * step).take_while(|s| *s < 6.0 * decay_s);
                in_holds(points, &times.collect::<Vec<_>>(), &swing)
            }
            Self::WarmingFrame { length, time_s } => {
                const PER_DECADE: f64 = 4.0;
                let times = (-8..8).map(|k| time_s * 10f64.powf(f64::from(k) / PER_DECADE));
                in_holds(points, &times.collect::<Vec<_>>(), &|s| length * (1.0 - (-s / time_s).exp()))
            }
            _ => points.to_vec(),
        }
    }

    /// What the load cell reads of the force at its times (s, N), which lie close together.
    pub fn read(&self, test: usize, ramp_end_s: f64, time_s: &[f64], force_n: &mut [f64]) {
        match *self {
            Self::SaturatingDrift { rate, time_s: slow } => {
                for (f, t) in force_n.iter_mut().zip(time_s) {
                    *f += rate * slow * (1.0 - (-t / slow).exp());
                }
            }
            Self::TwoPoleLag { time_s: delay } => {
                low_pass(0.5 * delay, time_s, force_n);
                low_pass(0.5 * delay, time_s, force_n);
            }
            Self::Batch { log_factor } if test > 0 => {
                force_n.iter_mut().for_each(|f| *f *= log_factor.exp());
            }
            Self::Meniscus { force } => {
                force_n.iter_mut().filter(|f| **f > 0.0).for_each(|f| *f -= force);
            }
            Self::Hum { force, period_s } => {
                for (f, t) in force_n.iter_mut().zip(time_s) {
                    *f += force * (std::f64::consts::TAU * t / period_s).sin();
                }
            }
            Self::GainStep { part, from_s, to_s } => {
                let during = (ramp_end_s + from_s)..(ramp_end_s + to_s);
                for (f, _) in force_n.iter_mut().zip(time_s).filter(|(_, t)| during.contains(t)) {
                    *f *= 1.0 + part;
                }
            }
            _ => {}
        }
    }
}

/// A motion with `more(s)` added `s` seconds into each hold at the largest depth, at `times` after its begin; it is gone
/// when the hold ends.
fn in_holds(points: &[(f64, f64)], times: &[f64], more: &dyn Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let deepest = points.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
    let mut moved = Vec::new();
    for pair in points.windows(2) {
        moved.push(pair[0]);
        if pair[0].1 == deepest && pair[1].1 == deepest {
            let inside = times.iter().filter(|s| pair[0].0 + *s < pair[1].0 - 1e-3);
            moved.extend(inside.map(|&s| (pair[0].0 + s, deepest + more(s))));
        }
    }
    moved.extend(points.last().copied());
    moved
}

/// `T dy/dt = F - y`, exact for a force that is linear between its times.
fn low_pass(time_constant: f64, time_s: &[f64], force_n: &mut [f64]) {
    let (mut reading, mut before) = (force_n[0], force_n[0]);
    for i in 1..force_n.len() {
        let h = time_s[i] - time_s[i - 1];
        let (force, decay) = (force_n[i], (-h / time_constant).exp());
        let slope = (force - before) / h;
        // The answer to a ramp lags behind it by its slope times T.
        reading = force - slope * time_constant + (reading - before + slope * time_constant) * decay;
        before = force;
        force_n[i] = reading;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_pass_answers_a_step_and_a_ramp_as_it_should() {
        let time: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
        let mut ramp: Vec<f64> = time.iter().map(|t| 3.0 * t).collect();
        low_pass(0.1, &time, &mut ramp);
        for (t, y) in time.iter().zip(&ramp) {
            let exact = 3.0 * (t - 0.1 * (1.0 - (-t / 0.1).exp()));
            assert!((y - exact).abs() < 1e-12);
        }
    }

    #[test]
    fn a_swing_is_in_the_hold_only() {
        let points = [(0.0, -1.0), (2.0, 1.0), (92.0, 1.0)];
        let overshoot = Cause::Overshoot { length: 0.1, frequency: 3.0, decay_s: 0.2 };
        let moved = overshoot.moved(&points);
        assert!(moved.windows(2).all(|w| w[1].0 > w[0].0) && moved.len() > 20);
        assert!(moved.iter().map(|p| p.1).fold(0.0, f64::max) > 1.05);
        assert_eq!((moved[0], moved[1], moved[moved.len() - 1]), (points[0], points[1], points[2]));
    }

    #[test]
    fn causes_outside_the_catalogue_have_no_name_in_it() {
        let names: Vec<&str> = poropunch::effect::CATALOGUE.iter().map(|e| e.name).collect();
        let inside = Cause::TwoPoleLag { time_s: 0.1 };
        assert!(names.contains(&inside.effect().unwrap()));
        assert!(Cause::Hum { force: 1e-4, period_s: 7.0 }.effect().is_none());
    }
}
