//! The tests of a case, and who computes what their load cell reads (`by_engine.rs`, `by_maker.rs`).

use super::cause::Cause;
use super::make::MakeError;
use poropunch::motion::protocol::{Protocol, ProtocolError, Trapezoid};
use std::collections::BTreeMap;

/// A test of the paper as it is recorded.
#[derive(Debug, Clone)]
pub struct Test {
    /// P1 or P2.
    pub name: &'static str,
    /// Recorded motion.
    pub protocol: Protocol,
    /// End of the first ramp (s).
    pub ramp_end_s: f64,
    /// Sample times (s).
    pub time_s: Vec<f64>,
}

/// Both tests with this number of cycles; one cycle ends with its hold.
///
/// # Errors
/// Never, for the paper's protocols.
pub fn tests(cycles: i32) -> Result<[Test; 2], ProtocolError> {
    let one = |name, trapezoid: Trapezoid| {
        let protocol = match cycles {
            1 => trapezoid.first_hold()?,
            _ => Trapezoid { cycles, ..trapezoid }.protocol()?,
        };
        let ramp_end_s = protocol.points()[1].0;
        let time_s = samples(&protocol);
        Ok(Test { name, protocol, ramp_end_s, time_s })
    };
    Ok([one("P1", Trapezoid::p1())?, one("P2", Trapezoid::p2())?])
}

/// Often while the punch moves and just after, ever more seldom while it rests.
fn samples(protocol: &Protocol) -> Vec<f64> {
    const STEPS: [(f64, f64); 4] = [(1.0, 0.02), (5.0, 0.1), (20.0, 0.5), (f64::INFINITY, 1.0)];
    let mut times = vec![protocol.start_time()];
    for pair in protocol.points().windows(2) {
        let ((from, before), (to, after)) = (pair[0], pair[1]);
        let mut t = from;
        loop {
            let step = match before == after {
                true => STEPS.iter().find(|(until, _)| t - from < until - 1e-9).map_or(1.0, |s| s.1),
                false => 0.02,
            };
            t += step;
            if t > to - 0.3 * step {
                break;
            }
            times.push(t);
        }
        times.push(to);
    }
    times
}

/// Who computes the force on a specimen.
pub trait Source {
    /// Readings (N) of both tests without noise for each set of causes, `[set][test][sample]`; `material` has the FMU's names (SI). The error
    /// that a time step may have is this part of what it is as a rule.
    ///
    /// # Errors
    /// When a run fails.
    fn readings_n(
        &self,
        material: &BTreeMap<String, f64>,
        sets: &[Vec<Cause>],
        tests: &[Test; 2],
        part_of_tolerance: f64,
    ) -> Result<Vec<Vec<Vec<f64>>>, MakeError>;

    /// By how much readings (N), `[test][sample]`, depend on the time steps: their largest difference from those with a tenth of the tolerance
    /// that they have a part of, over the test's largest force; 0 where a cause is an error of the steps itself.
    ///
    /// # Errors
    /// When a run fails.
    fn error_of_steps(
        &self,
        material: &BTreeMap<String, f64>,
        causes: &[Cause],
        tests: &[Test; 2],
        readings_n: &[Vec<f64>],
        part_of_tolerance: f64,
    ) -> Result<f64, MakeError>;
}

/// Largest difference between two curves over the largest value of the second one.
pub fn difference(one: &[f64], other: &[f64]) -> f64 {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |m: f64, v| m.max(v.abs()));
    let peak = largest(&mut other.iter().copied());
    largest(&mut one.iter().zip(other).map(|(a, b)| a - b)) / peak
}

#[cfg(test)]
mod checks {
    use super::*;

    #[test]
    fn a_difference_is_told_as_part_of_the_second_curves_peak() {
        assert_eq!(difference(&[1.0, -3.0, 2.0], &[1.0, -4.0, 1.5]), 0.25);
    }

    #[test]
    fn samples_hit_the_kinks_and_increase() {
        for test in tests(1).unwrap().iter().chain(&tests(3).unwrap()) {
            assert!(test.time_s.windows(2).all(|w| w[1] > w[0]));
            for (t, _) in test.protocol.points() {
                assert!(test.time_s.contains(t), "{t}");
            }
        }
        assert!((200..300).contains(&tests(1).unwrap()[1].time_s.len()));
    }
}
