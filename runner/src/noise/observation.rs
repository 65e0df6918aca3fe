//! What is explained: one force curve per test, from all its specimens.
//!
//! Specimens that differ by a factor are brought to one height first: `s_k(t) = a_k f(t) + white`, so
//! `f = sum a_k s_k / sum a_k^2`. All specimens then speak at every point, where a median hears the middle two.

use super::common_factor::{FEWEST_SPECIMENS, common_factor};
use super::odd_specimen::without_odd;
use super::spikes::without_spikes;
use crate::data::measurement::standard_deviation;
use crate::data::phase::phases;
use crate::data::{Cycle, DataError, Measurement, Phase, Problem, cycles, protocol_of};
use poropunch::motion::protocol::{Protocol, ProtocolError};
use std::sync::Arc;
use thiserror::Error;

/// A test: what was measured, how the punch moved, and what belongs together in it.
#[derive(Debug, Clone)]
pub struct Observation {
    /// What was measured; its force is the curve that is explained.
    pub measurement: Measurement,
    /// Motion of the punch.
    pub protocol: Arc<Protocol>,
    /// Times (s) of the points.
    pub time_s: Arc<[f64]>,
    /// Phase of each point.
    pub phases: Vec<Phase>,
    /// Cycle of each point, counted from 0.
    pub cycle: Vec<usize>,
    /// The cycles; none where the motion never loads the sample.
    pub cycles: Vec<Cycle>,
    /// Factor of each specimen's curve (-), geometric mean 1; empty where the file has no specimens.
    pub factors: Vec<f64>,
    /// Single samples far beside their neighbours, which were replaced.
    pub spikes: usize,
    /// What is left out of the measurement, in words.
    pub left_out: Vec<String>,
}

/// A measurement that cannot be explained.
#[derive(Debug, Clone, Error)]
pub enum ObservationError {
    /// Something about the file.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The motion.
    #[error(transparent)]
    Protocol(#[from] ProtocolError),
    /// The noise that was asked for needs what the file does not have.
    #[error("{0}")]
    Noise(String),
}

impl Observation {
    /// Of a measurement on a sample of the given height (m).
    ///
    /// # Errors
    /// When the motion starts inside the sample, pierces it, or cannot be followed.
    pub fn new(measurement: &Measurement, sample_height_m: Option<f64>) -> Result<Self, ObservationError> {
        check_motion(measurement, sample_height_m)?;
        let (clean, spikes) = without_spikes(measurement);
        let (clean, left_out) = without_odd(&clean);
        let (measurement, factors) = levelled(&clean);
        let cycles = cycles(&measurement).unwrap_or_default();
        let number = |&t: &f64| cycles.iter().filter(|c| t > c.times.start_s).count().max(1) - 1;
        let cycle = measurement.time_s.iter().map(number).collect();
        let phases = phases(&measurement);
        let protocol = Arc::new(protocol_of(&measurement)?);
        let time_s = measurement.time_s.clone().into();
        Ok(Self { measurement, protocol, time_s, phases, cycle, cycles, factors, spikes, left_out })
    }

    /// The same on a surface that lies `up_m` higher, with `tare_n` taken off the force.
    ///
    /// # Errors
    /// When the motion then starts inside the sample.
    pub fn moved(&self, up_m: f64, tare_n: f64) -> Result<Self, ObservationError> {
        let mut moved = self.clone();
        let m = &mut moved.measurement;
        m.displacement_m.iter_mut().for_each(|d| *d += up_m);
        m.force_n.iter_mut().chain(m.specimens_n.iter_mut().flatten()).for_each(|f| *f -= tare_n);
        m.quartiles_n.iter_mut().flatten().for_each(|q| *q = (q.0 - tare_n, q.1 - tare_n));
        check_motion(m, None)?;
        let points = self.protocol.points().iter().map(|(t, d)| (*t, d + up_m)).collect();
        moved.protocol = Arc::new(Protocol::new(points)?);
        Ok(moved)
    }

    /// The same up to the end of the first hold.
    ///
    /// # Errors
    /// As [`Observation::new`].
    pub fn first_hold(&self, sample_height_m: Option<f64>) -> Result<Self, ObservationError> {
        let end = self.first_hold_end();
        if end == self.len() {
            return Ok(self.clone());
        }
        let mut shorter = Self::new(&until(&self.measurement, end), sample_height_m)?;
        shorter.factors.clone_from(&self.factors);
        let reason = "what follows the first hold: the model cannot compute lift-off";
        shorter.left_out = self.left_out.clone();
        shorter.left_out.push(reason.to_owned());
        Ok(shorter)
    }

    /// Number of points up to the end of the first hold.
    pub fn first_hold_end(&self) -> usize {
        let after =
            |(phase, cycle): (&Phase, &usize)| *cycle > 0 || matches!(phase, Phase::Unload | Phase::Recovery);
        self.phases.iter().zip(&self.cycle).position(after).unwrap_or(self.len())
    }

    /// Name of the test.
    pub fn name(&self) -> &str {
        &self.measurement.name
    }

    /// Measured force (mN).
    pub fn force_mn(&self) -> Vec<f64> {
        self.measurement.force_n.iter().map(|f| f * 1e3).collect()
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.measurement.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Time since the loading of its cycle began to touch (s), of a point; since the beginning where there is no loading.
    pub fn since_touch_s(&self, point: usize) -> f64 {
        let touch_s = self.cycles.get(self.cycle[point]).map_or(self.time_s[0], |c| c.times.ramp_start_s);
        self.time_s[point] - touch_s
    }

    /// Standard deviation of the specimens' ln factors (-), where there are enough of them.
    pub fn log_scatter(&self) -> Option<f64> {
        let logarithms: Vec<f64> = self.factors.iter().map(|a| a.ln()).collect();
        (logarithms.len() >= FEWEST_SPECIMENS).then(|| standard_deviation(&logarithms))
    }
}

fn check_motion(m: &Measurement, sample_height_m: Option<f64>) -> Result<(), DataError> {
    let start = m.displacement_m.first().copied().unwrap_or(0.0);
    if start > 0.0 {
        return Err(m.error(Problem::StartsInside { start_mm: start * 1e3 }));
    }
    match sample_height_m {
        Some(height) if m.depth_m() >= height => {
            Err(m.error(Problem::TooDeep { depth_mm: m.depth_m() * 1e3, height_mm: height * 1e3 }))
        }
        _ => Ok(()),
    }
}

/// The measurement with the mean of its levelled specimens as force, and their factors.
fn levelled(measurement: &Measurement) -> (Measurement, Vec<f64>) {
    let mut levelled = measurement.clone();
    let Some(common) = common_factor(measurement) else { return (levelled, vec![]) };
    let n = common.amplitudes.len() as f64;
    let mean = (common.amplitudes.iter().map(|a| a.ln()).sum::<f64>() / n).exp();
    let factors: Vec<f64> = common.amplitudes.iter().map(|a| a / mean).collect();
    let square: f64 = factors.iter().map(|a| a * a).sum();
    let at = |i: usize| {
        let sum: f64 = factors.iter().zip(&measurement.specimens_n).map(|(a, s)| a * s[i]).sum();
        sum / square
    };
    levelled.force_n = (0..measurement.len()).map(at).collect();
    (levelled, factors)
}

/// The first points of a measurement.
fn until(m: &Measurement, end: usize) -> Measurement {
    let cut = |v: &Vec<f64>| v[..end.min(v.len())].to_vec();
    Measurement {
        time_s: cut(&m.time_s),
        displacement_m: cut(&m.displacement_m),
        force_n: cut(&m.force_n),
        spread_n: m.spread_n.as_ref().map(cut),
        quartiles_n: m.quartiles_n.as_ref().map(|q| q[..end.min(q.len())].to_vec()),
        specimens_n: m.specimens_n.iter().map(cut).collect(),
        lines: m.lines[..end.min(m.lines.len())].to_vec(),
        ..m.clone()
    }
}

/// Whether two tests were made on the same specimens: their factors go together, name by name.
pub fn same_specimens(a: &Observation, b: &Observation) -> bool {
    /// Independent factors of ten specimens pass this in less than one of ten thousand pairs of tests.
    const TOGETHER: f64 = 0.9;
    fn named(o: &Observation) -> impl Iterator<Item = (&String, f64)> {
        o.measurement.specimen_names.iter().zip(o.factors.iter().map(|f| f.ln()))
    }
    // An odd specimen is left out of one test, not of the other.
    let of_b = |name: &String| named(b).find(|(other, _)| *other == name).map(|(_, ln)| ln);
    let (x, y): (Vec<f64>, Vec<f64>) = named(a).filter_map(|(name, ln)| Some((ln, of_b(name)?))).unzip();
    let odd = a.left_out.len() + b.left_out.len();
    if x.len() < 2 * FEWEST_SPECIMENS || x.len() + odd < a.factors.len().max(b.factors.len()) {
        return false;
    }
    let centred = |v: &[f64]| -> Vec<f64> {
        let mean = v.iter().sum::<f64>() / v.len() as f64;
        v.iter().map(|x| x - mean).collect()
    };
    let (x, y) = (centred(&x), centred(&y));
    let dot = |u: &[f64], v: &[f64]| u.iter().zip(v).map(|(a, b)| a * b).sum::<f64>();
    dot(&x, &y) > TOGETHER * (dot(&x, &x) * dot(&y, &y)).sqrt()
}

/// What is left out of tests, in words.
pub fn left_out(observations: &[Observation]) -> impl Iterator<Item = String> + '_ {
    observations.iter().flat_map(|o| o.left_out.iter().map(|what| format!("{}: left out: {what}", o.name())))
}

/// All tests read as observations of loadings.
///
/// # Errors
/// As [`Observation::new`], and when a motion never loads the sample.
pub fn observe(
    measurements: &[Measurement],
    sample_height_m: Option<f64>,
) -> Result<Vec<Observation>, ObservationError> {
    let one = |m: &Measurement| {
        cycles(m)?;
        Observation::new(m, sample_height_m)
    };
    measurements.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histories_that_start_inside_or_pierce_the_sample_are_refused() {
        let measurement = Measurement {
            time_s: vec![0.0, 1.0, 2.0, 3.0, 4.0],
            displacement_m: vec![-1e-3, 0.0, 1e-3, 1e-3, 1e-3],
            force_n: vec![0.0, 0.0, 4e-3, 3e-3, 2e-3],
            ..Measurement::default()
        };
        assert!(matches!(
            Observation::new(&measurement, Some(1e-3)),
            Err(ObservationError::Data(DataError { problem: Problem::TooDeep { .. }, .. }))
        ));
        let mut inside = measurement;
        inside.displacement_m[0] = 1e-4;
        assert!(matches!(
            Observation::new(&inside, None),
            Err(ObservationError::Data(DataError { problem: Problem::StartsInside { .. }, .. }))
        ));
    }
}
