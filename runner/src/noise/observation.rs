//! What is explained: one force curve per test, from all its specimens.
//!
//! Specimens that differ by a factor are brought to one height first: `s_k(t) = a_k f(t) + white`, so
//! `f = sum a_k s_k / sum a_k^2`. All specimens then speak at every point, where a median hears the middle two.

use crate::data::measurement::standard_deviation;
use crate::data::noise::common_factor::{FEWEST_SPECIMENS, common_factor};
use crate::data::{Cycle, Measurement, NoiseModel, Phase, cycles};
use crate::objective::{Dataset, DatasetError, Weights};

/// A test as the diagnosis sees it.
#[derive(Debug, Clone)]
pub struct Observation {
    /// Motion, force and phases; residuals in mN.
    pub dataset: Dataset,
    /// Cycle of each point, counted from 0.
    pub cycle: Vec<usize>,
    /// The cycles.
    pub cycles: Vec<Cycle>,
    /// Factor of each specimen's curve (-), geometric mean 1; empty where the file has no specimens.
    pub factors: Vec<f64>,
    /// What is left out of the measurement, in words.
    pub left_out: Option<String>,
}

impl Observation {
    /// Of a measurement.
    ///
    /// # Errors
    /// When it has no loading, or its motion cannot be used.
    pub fn new(measurement: &Measurement, sample_height_m: Option<f64>) -> Result<Self, DatasetError> {
        let cycles = cycles(measurement)?;
        let (measurement, factors) = levelled(measurement);
        let number = |&t: &f64| cycles.iter().filter(|c| t > c.start_s).count().max(1) - 1;
        let cycle = measurement.time_s.iter().map(number).collect();
        let weights = Weights { noise: NoiseModel::None, ..Weights::default() };
        let dataset = Dataset::new(measurement, &weights, sample_height_m)?;
        Ok(Self { dataset, cycle, cycles, factors, left_out: None })
    }

    /// The same up to the end of the first hold.
    ///
    /// # Errors
    /// As [`Observation::new`].
    pub fn first_hold(&self, sample_height_m: Option<f64>) -> Result<Self, DatasetError> {
        let m = &self.dataset.measurement;
        let end = self
            .dataset
            .phases
            .iter()
            .zip(&self.cycle)
            .position(|(phase, cycle)| *cycle > 0 || matches!(phase, Phase::Unload | Phase::Recovery));
        let Some(end) = end else { return Ok(self.clone()) };
        let mut shorter = Self::new(&until(m, end), sample_height_m)?;
        shorter.factors.clone_from(&self.factors);
        let reason = "what follows the first hold: the model cannot compute lift-off";
        shorter.left_out = Some(reason.to_owned());
        Ok(shorter)
    }

    /// Name of the test.
    pub fn name(&self) -> &str {
        &self.dataset.measurement.name
    }

    /// Measured force (mN).
    pub fn force_mn(&self) -> Vec<f64> {
        self.dataset.measurement.force_n.iter().map(|f| f * 1e3).collect()
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.dataset.measurement.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Time since the loading of its cycle began to touch (s), of a point.
    pub fn since_touch_s(&self, point: usize) -> f64 {
        self.dataset.measurement.time_s[point] - self.cycles[self.cycle[point]].ramp_start_s
    }

    /// Standard deviation of the specimens' ln factors (-), where there are enough of them.
    pub fn log_scatter(&self) -> Option<f64> {
        let logarithms: Vec<f64> = self.factors.iter().map(|a| a.ln()).collect();
        (logarithms.len() >= FEWEST_SPECIMENS).then(|| standard_deviation(&logarithms))
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
    let names = |o: &Observation| o.dataset.measurement.specimen_names.clone();
    if a.factors.len() < 2 * FEWEST_SPECIMENS || names(a) != names(b) || a.factors.len() != b.factors.len() {
        return false;
    }
    let centred = |o: &Observation| -> Vec<f64> { o.factors.iter().map(|f| f.ln()).collect() };
    let (x, y) = (centred(a), centred(b));
    let dot = |u: &[f64], v: &[f64]| u.iter().zip(v).map(|(a, b)| a * b).sum::<f64>();
    dot(&x, &y) > TOGETHER * (dot(&x, &x) * dot(&y, &y)).sqrt()
}

/// All tests read as observations.
///
/// # Errors
/// As [`Observation::new`].
pub fn observe(
    measurements: &[Measurement],
    sample_height_m: Option<f64>,
) -> Result<Vec<Observation>, DatasetError> {
    measurements.iter().map(|m| Observation::new(m, sample_height_m)).collect()
}
