//! The force that a case's load cell reads, without noise.

use super::cause::Cause;
use super::draw::Drawn;
use super::reading::Record;
use crate::engine::Engine;
use crate::pool::{Job, Priority, Run, RunFailure};
use poropunch::motion::protocol::{Protocol, ProtocolError, Trapezoid};
use std::collections::BTreeMap;
use std::sync::Arc;

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

/// Parts of each interval at which the force is computed, for filters.
const PARTS: u32 = 4;

/// A run that was started.
pub struct Truth {
    run: Run,
    dense_s: Vec<f64>,
    causes: Vec<Cause>,
    index: usize,
    test: Test,
}

/// Starts the run of a test with some causes; `numerics` are the maker's mesh and steps.
///
/// # Errors
/// When the true motion is none.
pub fn start(
    engine: &Engine,
    drawn: &Drawn,
    causes: &[Cause],
    numerics: &BTreeMap<String, f64>,
    (index, test): (usize, &Test),
) -> Result<Truth, ProtocolError> {
    let mut parameters = drawn.material.clone();
    parameters.extend(numerics.clone());
    let mut points = test.protocol.points().to_vec();
    for cause in causes {
        cause.set(&mut parameters);
        points = cause.moved(&points);
    }
    let mut dense_s = vec![test.time_s[0]];
    for w in test.time_s.windows(2) {
        dense_s.extend((1..PARTS).map(|k| w[0] + (w[1] - w[0]) * f64::from(k) / f64::from(PARTS)));
        dense_s.push(w[1]);
    }
    let job = Job { parameters, protocol: Arc::new(Protocol::new(points)?), time_s: dense_s.clone().into() };
    let run = engine.submit(&job, Priority::Urgent);
    Ok(Truth { run, dense_s, causes: causes.to_vec(), index, test: test.clone() })
}

impl Truth {
    /// The reading at the sample times (N).
    ///
    /// # Errors
    /// When the simulation fails.
    pub fn reading_n(&self) -> Result<Vec<f64>, RunFailure> {
        let curve = self.run.wait()?;
        let mut force_n = curve.force_n().to_vec();
        let Test { protocol, ramp_end_s, .. } = &self.test;
        let record = Record { test: self.index, protocol, ramp_end_s: *ramp_end_s, time_s: &self.dense_s };
        self.causes.iter().for_each(|cause| cause.read(record, &mut force_n));
        Ok(force_n.into_iter().step_by(PARTS as usize).collect())
    }
}

#[cfg(test)]
mod checks {
    use super::*;

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
