//! What a cause does to the reading of the load cell.

use super::form::Form;
use std::f64::consts::TAU;

/// What a load cell reads from.
#[derive(Debug, Clone, Copy)]
pub struct Record<'a> {
    /// Which test it is.
    pub test: usize,
    /// End of the first ramp (s).
    pub ramp_end_s: f64,
    /// Times, which lie close together (s).
    pub time_s: &'a [f64],
}

impl Form {
    /// What the load cell reads of the force at the record's times (N).
    pub fn read(&self, record: Record<'_>, force_n: &mut [f64]) {
        let Record { test, ramp_end_s, time_s } = record;
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
}
