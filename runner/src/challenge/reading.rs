//! What a cause does to the reading of the load cell.

use super::cause::Cause;
use poropunch::motion::protocol::Protocol;
use std::f64::consts::TAU;

/// What a load cell reads from.
#[derive(Debug, Clone, Copy)]
pub struct Record<'a> {
    /// Which test it is.
    pub test: usize,
    /// The recorded motion.
    pub protocol: &'a Protocol,
    /// End of the first ramp (s).
    pub ramp_end_s: f64,
    /// Times, which lie close together (s).
    pub time_s: &'a [f64],
}

impl Cause {
    /// What the load cell reads of the force at the record's times (N).
    pub fn read(&self, record: Record<'_>, force_n: &mut [f64]) {
        let Record { test, protocol, ramp_end_s, time_s } = record;
        let mut add = |more: &dyn Fn(f64) -> f64| {
            force_n.iter_mut().zip(time_s).for_each(|(f, t)| *f += more(*t));
        };
        match *self {
            Self::SaturatingDrift { rate, time_s: slow } => {
                add(&|t| rate * slow * (1.0 - (-t / slow).exp()));
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
            Self::Hum { force, period_s } => add(&|t| force * (TAU * t / period_s).sin()),
            Self::Mains { force, frequency } => add(&|t| force * (TAU * t * frequency).sin()),
            Self::ThermalWave { force, period_s, phase } => {
                let shift = phase * (1 + test) as f64;
                add(&|t| force * (TAU * t / period_s + shift).sin());
            }
            Self::GainStep { part, from_s, to_s } => {
                let during = (ramp_end_s + from_s)..(ramp_end_s + to_s);
                for (f, _) in force_n.iter_mut().zip(time_s).filter(|(_, t)| during.contains(t)) {
                    *f *= 1.0 + part;
                }
            }
            Self::Tilt { depth } => {
                for (f, t) in force_n.iter_mut().zip(time_s) {
                    // The part of the face that touches grows with the depth.
                    let touched = (protocol.displacement(*t) / depth).clamp(0.0, 1.0);
                    *f *= touched.sqrt();
                }
            }
            Self::Clipped { part } => {
                let most = part * force_n.iter().copied().fold(0.0, f64::max);
                force_n.iter_mut().for_each(|f| *f = f.min(most));
            }
            Self::Clock { faster } => {
                let own = force_n.to_vec();
                let mut next = 0;
                for (f, t) in force_n.iter_mut().zip(time_s) {
                    let told = time_s[0] + (t - time_s[0]) * (1.0 + faster);
                    while next + 2 < time_s.len() && time_s[next + 1] < told {
                        next += 1;
                    }
                    let part = ((told - time_s[next]) / (time_s[next + 1] - time_s[next])).min(1.0);
                    *f = own[next] + part * (own[next + 1] - own[next]);
                }
            }
            Self::Bubble { loss, at_s } => {
                const COLLAPSE_S: f64 = 0.5;
                for (f, t) in force_n.iter_mut().zip(time_s) {
                    let since = (t - ramp_end_s - at_s).max(0.0);
                    *f *= 1.0 - loss * (1.0 - (-since / COLLAPSE_S).exp());
                }
            }
            _ => {}
        }
    }
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

    /// Every cause outside the catalogue that acts on the reading, on a force of 1 N while the punch is in.
    #[test]
    fn a_reading_is_spoilt_where_its_cause_acts() {
        let protocol = Protocol::new(vec![(0.0, -1.0), (2.0, 1.0), (92.0, 1.0)]).unwrap();
        let time_s: Vec<f64> = (0..921).map(|i| 0.1 * f64::from(i)).collect();
        let read = |cause: Cause, t: f64| {
            let mut force: Vec<f64> =
                time_s.iter().map(|t| if *t > 1.0 { 1.0 + 0.01 * t } else { 0.0 }).collect();
            let record = Record { test: 0, protocol: &protocol, ramp_end_s: 2.0, time_s: &time_s };
            cause.read(record, &mut force);
            force[(10.0 * t) as usize]
        };
        approx::assert_relative_eq!(
            read(Cause::Tilt { depth: 0.5 }, 1.2),
            1.012 * 0.4f64.sqrt(),
            epsilon = 1e-9
        );
        approx::assert_relative_eq!(read(Cause::Tilt { depth: 0.5 }, 50.0), 1.5, epsilon = 1e-12);
        approx::assert_relative_eq!(read(Cause::Clipped { part: 0.5 }, 90.0), 0.96, epsilon = 1e-12);
        approx::assert_relative_eq!(read(Cause::Clock { faster: 0.1 }, 50.0), 1.55, epsilon = 1e-9);
        approx::assert_relative_eq!(
            read(Cause::Bubble { loss: 0.1, at_s: 10.0 }, 50.0),
            1.35,
            epsilon = 1e-9
        );
        approx::assert_relative_eq!(
            read(Cause::Bubble { loss: 0.1, at_s: 10.0 }, 11.0),
            1.11,
            epsilon = 1e-12
        );
        approx::assert_relative_eq!(
            read(Cause::Mains { force: 0.2, frequency: 0.25 }, 9.0),
            1.29,
            epsilon = 1e-9
        );
        let wave = Cause::ThermalWave { force: 0.2, period_s: 100.0, phase: TAU / 4.0 };
        approx::assert_relative_eq!(read(wave, 0.0), 0.2, epsilon = 1e-9);
    }
}
