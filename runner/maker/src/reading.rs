//! What the load cell makes of the force.

use crate::effect::Effect;
use crate::history::History;
use crate::motion::Motion;
use std::f64::consts::{PI, TAU};

/// Readings (N) at times (s) of the record, of the force on the specimen and the true motion.
pub fn readings(history: &History, motion: &Motion, times: &[f64], effects: &[Effect]) -> Vec<f64> {
    let touch = history
        .times()
        .iter()
        .zip(history.forces())
        .find(|(_, f)| **f > 0.0)
        .map_or(f64::INFINITY, |(t, _)| *t);
    let start = motion.span().0;
    let mut released = None;
    let specimen = |t: f64, released: &mut Option<f64>| {
        let (mut force, depth) = (history.at(t), motion.at(t));
        for effect in effects {
            match *effect {
                Effect::Tilt { height } => force *= share_below(depth / height),
                Effect::Meniscus { force: pull, reach } if t >= touch => {
                    if depth < -reach {
                        released.get_or_insert(t);
                    }
                    // The bridge thins out over its reach, and forms anew with the next touch.
                    if force > 0.0 {
                        *released = None;
                    }
                    let thin =
                        if released.is_some() { 0.0 } else { (1.0 + depth.min(0.0) / reach).max(0.0).sqrt() };
                    force -= pull * thin;
                }
                _ => {}
            }
        }
        force
    };
    let clock: f64 = effects.iter().map(|e| if let Effect::Clock { rate } = e { *rate } else { 0.0 }).sum();
    let lag: f64 =
        effects.iter().map(|e| if let Effect::TwoPoleLag { size } = e { 0.05 * size } else { 0.0 }).sum();
    let mut filter = LowPass::new(0.5 * lag, start);
    let mut readings: Vec<f64> = times
        .iter()
        .map(|&t| {
            let clocked = start + (t - start) * (1.0 + clock);
            let force = match lag > 0.0 {
                true => filter.follow(clocked, |t| specimen(t, &mut released)),
                false => specimen(clocked, &mut released),
            };
            effects.iter().fold(force, |force, effect| sensed(effect, force, t, t - start))
        })
        .collect();
    for effect in effects {
        if let Effect::Clip { part } = effect {
            let limit = part * readings.iter().copied().fold(0.0, f64::max);
            readings.iter_mut().for_each(|f| *f = f.min(limit));
        }
    }
    readings
}

/// Effects of the amplifier at a time (s), `since` the record's start.
fn sensed(effect: &Effect, force: f64, time: f64, since: f64) -> f64 {
    match *effect {
        Effect::SaturatingDrift { size, time_s } => force - 2e-6 * size * time_s * (-since / time_s).exp_m1(),
        Effect::Wave { force: amplitude, period_s, phase } => {
            force + amplitude * (TAU * time / period_s + phase).sin()
        }
        Effect::Gain { part, from_s, to_s } if time >= from_s && time < to_s => force * (1.0 + part),
        _ => force,
    }
}

/// Share of a disc's area beyond a chord at `x` of its diameter.
fn share_below(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    let y = 1.0 - 2.0 * x;
    (y.acos() - y * (1.0 - y * y).max(0.0).sqrt()) / PI
}

/// Two equal low passes in series, followed in steps that are short against their time.
struct LowPass {
    pole: f64,
    time: f64,
    first: f64,
    second: f64,
}

impl LowPass {
    fn new(pole: f64, time: f64) -> Self {
        Self { pole, time, first: 0.0, second: 0.0 }
    }

    /// Reading at a time, of the force before it; times must not fall.
    fn follow(&mut self, until: f64, mut force: impl FnMut(f64) -> f64) -> f64 {
        // What is older than thirty poles is forgotten.
        let from = self.time.max(until - 30.0 * self.pole);
        let steps = ((until - from) / (0.05 * self.pole)).ceil().max(1.0);
        let h = (until - from) / steps;
        let decay = (-h / self.pole).exp();
        for i in 0..steps as usize {
            let input = force(from + (i as f64 + 0.5) * h);
            // Exact for an input that is constant within the step.
            let (a, b) = (self.first - input, self.second - input);
            self.second = input + decay * (b + a * h / self.pole);
            self.first = input + decay * a;
        }
        self.time = until;
        self.second
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> (History, Motion) {
        let mut history = History::default();
        for i in 0..=20 {
            history.push(0.5 * f64::from(i), 1e-3 * f64::from(i));
        }
        (history, Motion::new(vec![(0.0, 0.0), (10.0, 1e-3)]).unwrap())
    }

    /// A ramp comes late by the sum of the poles.
    #[test]
    fn two_poles_delay_a_ramp() {
        let (history, motion) = ramp();
        let times: Vec<f64> = (0..100).map(|i| 0.1 * f64::from(i)).collect();
        let lagged = readings(&history, &motion, &times, &[Effect::TwoPoleLag { size: 4.0 }]);
        assert!((lagged[90] - history.at(times[90] - 0.2)).abs() < 1e-7);
    }

    #[test]
    fn the_amplifier_and_the_clock() {
        let (history, motion) = ramp();
        let read = |effect: Effect| readings(&history, &motion, &[5.0], &[effect])[0];
        assert_eq!(read(Effect::Clip { part: 0.5 }), 5e-3);
        assert!((read(Effect::Clock { rate: 0.1 }) - 11e-3).abs() < 1e-12);
        assert!((read(Effect::SaturatingDrift { size: 1.0, time_s: 1e6 }) - 10.01e-3).abs() < 1e-7);
        assert!((read(Effect::Tilt { height: 1e-3 }) - 5e-3).abs() < 1e-12);
        assert!(read(Effect::Meniscus { force: 1e-3, reach: 1e-3 }) < 9.1e-3);
    }
}
