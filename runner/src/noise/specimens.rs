//! What the scatter of the specimens about their common curve says: white noise, and slow differences in shape.

use super::Common;
use super::numerical::{hats_by_knot, sum_by_key};
use super::observation::Observation;
use crate::data::motion::sample_noise;
use crate::data::noise::correlated::{FEWEST_IN_RECORD, NoiseParts, Record, noise_parts};
use crate::data::{NoiseModel, Phase};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// Noise of one test's curve.
#[derive(Debug, Clone)]
pub struct TestNoise {
    /// White deviation of each point of the curve (mN).
    pub white_mn: DVector<f64>,
    /// White deviation of a specimen's sample (mN), where specimens tell it.
    pub specimen_white_mn: Option<f64>,
    /// Errors that points of this test share (mN).
    pub common: Vec<Common>,
    /// Slow noise of the load cell (mN) and its time (s), where it is seen off contact.
    pub slow_mn: Option<(f64, f64)>,
    /// Relative scatter of the specimens' heights (-).
    pub height_scatter: Option<f64>,
}

/// A deviation below this is rounding, not noise (mN).
const SMALLEST_MN: f64 = 1e-4;
/// What a load cell resolves of the largest force.
const RESOLUTION: f64 = 1e-4;
/// A variance counts when it is this many of its standard errors above what white noise gives.
const BEYOND_DOUBT: f64 = 3.0;

/// Of a test, whose computed force is `force_mn`.
pub fn test_noise(observation: &Observation, force_mn: &DVector<f64>) -> TestNoise {
    let slow = off_contact(observation).and_then(|p| p.correlated);
    let slow_mn = slow.map(|c| (c.amplitude.value * 1e3, c.time_s.value));
    let mut noise = if observation.factors.is_empty() {
        single(observation)
    } else {
        let residuals = residuals(observation);
        from_specimens(observation, &residuals, force_mn)
    };
    if let Some((sigma_mn, time_s)) = slow_mn {
        let curves = observation.factors.len().max(1) as f64;
        noise.common.extend(slow_noise(observation, sigma_mn / curves.sqrt(), time_s));
    }
    noise.slow_mn = slow_mn;
    noise
}

/// A curve without specimens: the file's spread, or the noise between neighbouring samples.
fn single(observation: &Observation) -> TestNoise {
    let m = &observation.dataset.measurement;
    let known = NoiseModel::Auto.of(m, None).ok().filter(|n| !n.sigma_n.is_empty());
    let white_mn = match known {
        Some(noise) => DVector::from_iterator(m.len(), noise.sigma_n.iter().map(|s| s * 1e3)),
        None => {
            let noise_n = |of: &dyn Fn(usize) -> bool| {
                let points = (0..m.len()).filter(|&i| of(i)).map(|i| (m.time_s[i], m.force_n[i]));
                sample_noise(&points.collect::<Vec<_>>())
            };
            // Late in the hold the curve is straight; where samples are few there, the whole curve speaks.
            let late = noise_n(&|i| observation.dataset.phases[i] == Phase::HoldLate);
            let noise_n = if late > 0.0 { late } else { noise_n(&|_| true) };
            DVector::from_element(m.len(), noise_n * 1e3)
        }
    };
    let peak_mn = m.force_n.iter().fold(0.0_f64, |peak, f| peak.max(1e3 * f.abs()));
    let least = SMALLEST_MN.max(RESOLUTION * peak_mn);
    TestNoise {
        white_mn: white_mn.map(|s| s.max(least)),
        specimen_white_mn: None,
        common: vec![],
        slow_mn: None,
        height_scatter: None,
    }
}

/// What each specimen's curve differs from its factor times the common one (mN), one column each.
fn residuals(observation: &Observation) -> DMatrix<f64> {
    let m = &observation.dataset.measurement;
    let force = &m.force_n;
    DMatrix::from_fn(force.len(), observation.factors.len(), |i, k| {
        (m.specimens_n[k][i] - observation.factors[k] * force[i]) * 1e3
    })
}

fn from_specimens(observation: &Observation, residuals: &DMatrix<f64>, force_mn: &DVector<f64>) -> TestNoise {
    let (points, n) = residuals.shape();
    let basis: Vec<DVector<f64>> =
        shapes(observation).into_iter().map(|h| h.component_mul(force_mn)).collect();
    // Shapes orthogonal to each other are told one by one.
    let q = DMatrix::from_columns(&basis).qr().q();
    let coefficients = q.tr_mul(residuals);
    let smooth = &q * &coefficients;
    // The common curve was formed from the specimens themselves: one of n degrees of freedom is spent at each point.
    let degrees = (points.saturating_sub(q.ncols()) * (n - 1)).max(1) as f64;
    let white = ((residuals - &smooth).norm_squared() / degrees).sqrt().max(SMALLEST_MN);
    let square: f64 = observation.factors.iter().map(|a| a * a).sum();
    let mut common = Vec::new();
    for (j, row) in coefficients.row_iter().enumerate() {
        let variance = row.norm_squared() / (n as f64 - 1.0);
        let beyond = variance - white * white;
        if beyond > BEYOND_DOUBT * white * white * (2.0 / (n as f64 - 1.0)).sqrt() {
            common.push(Common {
                name: format!("shapes of the specimens of {}, part {}", observation.name(), j + 1),
                shape_mn: q.column(j) * (beyond / n as f64).sqrt(),
                relative: false,
            });
        }
    }
    TestNoise {
        white_mn: DVector::from_element(points, white / square.sqrt()),
        specimen_white_mn: Some(white),
        common,
        slow_mn: None,
        height_scatter: observation.log_scatter(),
    }
}

/// Slow shapes along a cycle: what all cycles share first, since a specimen that relaxes otherwise does so in every cycle, then
/// what later cycles add.
fn shapes(observation: &Observation) -> Vec<DVector<f64>> {
    let cycles: Vec<_> = (0..observation.cycles.len()).map(|c| hats_by_knot(observation, c, 1.0)).collect();
    let shared = sum_by_key(cycles.iter().flatten().map(|(knot, hat)| (*knot, hat)));
    let later = cycles.into_iter().skip(1).flat_map(BTreeMap::into_values);
    shared.into_values().chain(later).collect()
}

/// Noise while the punch is in the air after a withdrawal, of every specimen.
fn off_contact(observation: &Observation) -> Option<NoiseParts> {
    let m = &observation.dataset.measurement;
    let stretch =
        |cycle: &crate::data::Cycle| cycle.withdrawn_s.map(|from| cycle.points(&m.time_s, from, cycle.end_s));
    let stretches: Vec<_> = observation.cycles.iter().filter_map(stretch).collect();
    let records: Vec<Record> = m
        .curves_n()
        .into_iter()
        .flat_map(|curve| {
            stretches.iter().map(|range| Record {
                time_s: m.time_s[range.clone()].to_vec(),
                values: curve[range.clone()].to_vec(),
            })
        })
        .filter(|r| r.values.len() >= FEWEST_IN_RECORD)
        .collect();
    (!records.is_empty()).then(|| noise_parts(&records)).flatten()
}

/// A noise remembered for `time_s` as hat functions of that width; at most [`MOST_KNOTS`] of them.
fn slow_noise(observation: &Observation, sigma_mn: f64, time_s: f64) -> Vec<Common> {
    const MOST_KNOTS: f64 = 60.0;
    let t = &observation.dataset.measurement.time_s;
    let (first, last) = (t[0], t[t.len() - 1]);
    let width = time_s.max((last - first) / MOST_KNOTS);
    // A shorter memory than the knots' distance averages out between them.
    let sigma_mn = sigma_mn * (time_s / width).sqrt();
    let knots = ((last - first) / width).ceil() as i32;
    let hat = |k: i32| {
        let share = |t: f64| (1.0 - ((t - first) / width - f64::from(k)).abs()).max(0.0);
        let shape_mn = DVector::from_iterator(t.len(), t.iter().map(|&t| sigma_mn * share(t)));
        Common { name: format!("slow noise of {}, part {k}", observation.name()), shape_mn, relative: false }
    };
    (0..=knots).map(hat).filter(|c| c.shape_mn.amax() > 0.0).collect()
}
