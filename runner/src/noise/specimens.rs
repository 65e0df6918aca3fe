//! Noise of one test: white noise from neighbouring samples, and what the specimens differ by, in proportion to the force and
//! beside it.

use super::Common;
use super::common_factor::MEDIAN_OVER_MEAN;
use super::low_rank::{Estimated, Group};
use super::motion::beside_the_path;
use super::neighbours::{Differences, White, white_noise};
use super::numerical::{hats_by_knot, sum_by_key};
use super::observation::{Observation, ObservationError};
use super::slow::{off_contact, slow_noise};
use super::weights::{Uncertainty, Weights};
use crate::data::Phase;
use crate::data::measurement::median;
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
    /// Where it comes from, in words.
    pub description: String,
}

/// A deviation below this is rounding, not noise (mN).
const SMALLEST_MN: f64 = 1e-4;
/// What a load cell resolves of the largest force.
const RESOLUTION: f64 = 1e-4;
/// Factor on the white deviation of a point that has no weight.
const UNKNOWN: f64 = 1e6;
/// A variance counts when it is this many of its standard errors above what white noise gives.
const BEYOND_DOUBT: f64 = 3.0;

/// Specimens that the shapes of a test's own are known by before they are seen: the fewest with which a covariance of any number of them
/// has a mean.
const USUAL_SPECIMENS: f64 = 2.0;

/// What tells the noise of a test.
enum Source<'a> {
    Nothing,
    Specimens,
    Spread(&'a [f64]),
    Neighbours,
}

fn source<'a>(observation: &'a Observation, weights: &Weights) -> Result<Source<'a>, ObservationError> {
    let m = &observation.measurement;
    let missing = |what: &str| Err(ObservationError::Noise(format!("{}: --noise {what}", m.file.display())));
    match (weights.uncertainty, &m.spread_n) {
        (Uncertainty::None, _) => Ok(Source::Nothing),
        (Uncertainty::Auto | Uncertainty::Specimens, _) if !observation.factors.is_empty() => {
            Ok(Source::Specimens)
        }
        (Uncertainty::Specimens, _) => {
            missing("specimens needs at least three specimen columns s01, s02, ...")
        }
        (Uncertainty::Spread | Uncertainty::Auto, Some(spread_n)) => Ok(Source::Spread(spread_n)),
        (Uncertainty::Spread, None) => {
            missing("spread needs a column force_std_mN, or force_q25_mN and force_q75_mN")
        }
        (Uncertainty::Auto, None) => Ok(Source::Neighbours),
    }
}

/// Checks that the files have what the uncertainty asked for needs.
///
/// # Errors
/// Names the first that has not.
pub fn check(observations: &[Observation], weights: &Weights) -> Result<(), ObservationError> {
    observations.iter().try_for_each(|o| source(o, weights).map(|_| ()))
}

/// Of a test, whose computed force is `force_mn`.
///
/// # Errors
/// When the uncertainty asked for needs what the file does not have.
pub fn test_noise(
    observation: &Observation,
    force_mn: &DVector<f64>,
    weights: &Weights,
) -> Result<TestNoise, ObservationError> {
    let mut noise = match source(observation, weights)? {
        Source::Nothing => return Ok(unknown(observation, weights)),
        Source::Specimens => from_specimens(observation, &residuals(observation), force_mn),
        Source::Spread(spread_n) => from_spread(observation, spread_n, weights.specimens),
        Source::Neighbours => from_neighbours(observation),
    };
    match observation.spikes {
        0 => (),
        1 => noise.description += "; a single sample far beside its neighbours was replaced",
        count => {
            noise.description +=
                &format!("; {count} single samples far beside their neighbours were replaced")
        }
    }
    noise.slow_mn = off_contact(observation)
        .and_then(|p| p.correlated)
        .map(|c| (c.amplitude.value * 1e3, c.time_s.value));
    if let Some((sigma_mn, time_s)) = noise.slow_mn {
        let curves = observation.factors.len().max(1) as f64;
        noise.common.extend(slow_noise(observation, "slow noise", sigma_mn / curves.sqrt(), Some(time_s)));
    }
    let beside = beside_the_path(observation, force_mn);
    noise.white_mn.zip_apply(&beside, |white, beside| *white = white.hypot(beside));
    noise.weigh(observation, weights);
    Ok(noise)
}

impl TestNoise {
    fn white(white_mn: DVector<f64>, description: String) -> Self {
        Self {
            white_mn,
            specimen_white_mn: None,
            common: vec![],
            slow_mn: None,
            height_scatter: None,
            description,
        }
    }

    /// Points of a phase that counts `w` times as much have a deviation `sqrt(w)` times smaller.
    fn weigh(&mut self, observation: &Observation, weights: &Weights) {
        for (sigma, phase) in self.white_mn.iter_mut().zip(&observation.phases) {
            *sigma /= weights.of(*phase).sqrt().max(1.0 / UNKNOWN);
        }
    }
}

/// Differences count in mN.
fn unknown(observation: &Observation, weights: &Weights) -> TestNoise {
    let what = "no noise model: sum of squared differences (Eq. 16)";
    let mut noise = TestNoise::white(DVector::from_element(observation.len(), 1.0), what.to_owned());
    noise.weigh(observation, weights);
    noise
}

/// The file's spread, as that of the curve where the number of specimens is known.
fn from_spread(observation: &Observation, spread_n: &[f64], specimens: Option<usize>) -> TestNoise {
    let own = observation.measurement.specimens_n.len();
    let n = specimens.or((own > 1).then_some(own));
    let factor = n.map_or(1.0, |n| MEDIAN_OVER_MEAN / (n as f64).sqrt());
    // A few equal specimens by chance must not give a point endless weight.
    let floor = 0.1 * median(&mut spread_n.to_vec());
    let description = match n {
        Some(n) => format!("spread of the file, as that of the median of {n} specimens"),
        None => "spread of the file (of single specimens: their number is not known)".to_owned(),
    };
    let sigma = |s: &f64| 1e3 * factor * s.max(floor);
    let white_mn = DVector::from_iterator(spread_n.len(), spread_n.iter().map(sigma));
    TestNoise::white(at_least(observation, white_mn), description)
}

/// A curve without specimens and spread: the noise between neighbouring samples.
fn from_neighbours(observation: &Observation) -> TestNoise {
    let m = &observation.measurement;
    let of = |late: bool| {
        let mut differences = Differences::default();
        let points = (0..m.len()).filter(|&i| !late || observation.phases[i] == Phase::HoldLate);
        let (time_s, force_n): (Vec<f64>, Vec<f64>) = points.map(|i| (m.time_s[i], m.force_n[i])).unzip();
        differences.add(&time_s, &force_n);
        differences.deviation()
    };
    // Late in the hold the curve is straight; where samples are few there, the whole curve speaks.
    let noise_mn = 1e3 * of(true).or_else(|| of(false)).unwrap_or(0.0);
    let white_mn = at_least(observation, DVector::from_element(m.len(), noise_mn));
    let description =
        format!("{:.3} mN from differences of neighbouring samples; no specimens", white_mn.amax());
    TestNoise::white(white_mn, description)
}

/// Not less than what a load cell resolves.
fn at_least(observation: &Observation, white_mn: DVector<f64>) -> DVector<f64> {
    let peak_mn = observation.measurement.force_n.iter().fold(0.0_f64, |peak, f| peak.max(1e3 * f.abs()));
    let least = SMALLEST_MN.max(RESOLUTION * peak_mn);
    white_mn.map(|s| s.max(least))
}

/// What each specimen's curve differs from its factor times the common one (mN), one column each.
fn residuals(observation: &Observation) -> DMatrix<f64> {
    let m = &observation.measurement;
    let force = &m.force_n;
    DMatrix::from_fn(force.len(), observation.factors.len(), |i, k| {
        (m.specimens_n[k][i] - observation.factors[k] * force[i]) * 1e3
    })
}

fn from_specimens(observation: &Observation, residuals: &DMatrix<f64>, force_mn: &DVector<f64>) -> TestNoise {
    let (points, n) = residuals.shape();
    // The height comes first and is known apart; together the first shapes are the height, so that one of them is none of its own.
    let proportional = shapes(observation).into_iter().skip(1).map(|h| h.component_mul(force_mn));
    let basis: Vec<DVector<f64>> =
        std::iter::once(force_mn.clone()).chain(proportional).chain(drifts(observation)).collect();
    let q = DMatrix::from_columns(&basis).qr().q();
    let coefficients = q.tr_mul(residuals);
    let smooth = &q * &coefficients;
    // The common curve was formed from the specimens themselves: one of n degrees of freedom is spent at each point.
    let degrees = (points.saturating_sub(q.ncols()) * (n - 1)).max(1) as f64;
    let rest_square = (residuals - &smooth).norm_squared() / degrees;
    let spent = (n as f64 / (n as f64 - 1.0)).sqrt();
    let slopes = slopes(&observation.time_s, force_mn.as_slice());
    let seen = white_noise(&observation.time_s, &slopes, residuals.column_iter());
    let seen = seen.unwrap_or(White { still: rest_square.sqrt() / spent, clock_s: 0.0 });
    let at = |slope: &f64| (spent * seen.at(*slope)).max(SMALLEST_MN);
    let white_mn = DVector::from_iterator(points, slopes.iter().map(at));
    let missed_mn = DVector::from_vec(seen.missed_by_kinks(&observation.time_s, force_mn.as_slice()));
    let white = if seen.clock_s > 0.0 { white_mn.norm() / (points as f64).sqrt() } else { at(&0.0) };
    let square: f64 = observation.factors.iter().map(|a| a * a).sum();
    // What is known before and what n specimens tell, together.
    let of = Estimated::Shapes { first_point: 0 };
    let group = Some(Group { of, degrees: (n - 1) as f64 + USUAL_SPECIMENS });
    let named = |(j, shape_mn)| {
        let name = format!("shapes of the specimens of {}, part {j}", observation.name());
        Common { group, ..Common::additive(name, shape_mn) }
    };
    let mut common: Vec<Common> = (1..).zip(differences(&q, &coefficients, white)).map(named).collect();
    if is_beyond(rest_square, white, degrees) {
        // Neither white nor a slow shape: remembered from sample to sample.
        let sigma_mn = ((rest_square - white * white) / square).sqrt();
        common.extend(slow_noise(observation, "unsteadiness", sigma_mn, None));
    }
    let clock = match 1e3 * spent * seen.clock_s {
        0.0 => String::new(),
        clock_ms => format!(", of its clock {clock_ms:.1} ms"),
    };
    let description = format!(
        "mean of {n} specimens: white noise {:.3} mN per specimen{clock}, from neighbouring samples; their heights scatter by {:.1} %",
        at(&0.0),
        100.0 * observation.log_scatter().unwrap_or(0.0)
    );
    TestNoise {
        white_mn: (white_mn / square.sqrt()).zip_map(&missed_mn, f64::hypot),
        specimen_white_mn: Some(white),
        common,
        slow_mn: None,
        height_scatter: observation.log_scatter(),
        description,
    }
}

/// What a mean of specimens misses by the shapes in which these differ (mN, independent of each other): of their coefficients of the
/// orthonormal columns of `q`, one column each, of which the first is the height and known apart. The covariance is the posterior mean
/// of what is beyond white noise, where an inverse Wishart distribution is known before, of a scale of so many more specimens that
/// differ in every shape by the mean of all: few specimens may seem alike by chance, and what differs in one way differs in many
/// shapes at once.
fn differences(q: &DMatrix<f64>, coefficients: &DMatrix<f64>, white_mn: f64) -> Vec<DVector<f64>> {
    let (q, shapes) = (q.columns_range(1..), coefficients.rows_range(1..));
    let (count, n) = (shapes.nrows(), shapes.ncols() as f64);
    let degrees = n - 1.0;
    let mean = shapes.norm_squared() / (degrees * count as f64);
    let diagonal = USUAL_SPECIMENS * mean - (degrees + USUAL_SPECIMENS) * white_mn * white_mn;
    let square = shapes * shapes.transpose() + DMatrix::from_diagonal_element(count, count, diagonal);
    let own = (square / (degrees * n)).symmetric_eigen();
    let known = own.eigenvalues.iter().zip(own.eigenvectors.column_iter());
    known.filter(|(variance, _)| **variance > 0.0).map(|(v, shape)| q * shape * v.sqrt()).collect()
}

/// Rates at which a curve changes: the larger of both sides'.
fn slopes(time_s: &[f64], values: &[f64]) -> Vec<f64> {
    let between = |i: usize| (values[i + 1] - values[i]) / (time_s[i + 1] - time_s[i]);
    let last = values.len().saturating_sub(1);
    let at = |i: usize| {
        let sides = [i.checked_sub(1), Some(i).filter(|i| *i < last)];
        sides.into_iter().flatten().map(|k| between(k).abs()).fold(0.0, f64::max)
    };
    (0..values.len()).map(at).collect()
}

/// Whether a variance of so many degrees of freedom is larger than white noise alone makes it.
fn is_beyond(variance: f64, white: f64, degrees: f64) -> bool {
    variance - white * white > BEYOND_DOUBT * white * white * (2.0 / degrees).sqrt()
}

/// Additive drifts of a specimen's reading: piecewise straight, with a kink where a cycle begins.
fn drifts(observation: &Observation) -> Vec<DVector<f64>> {
    let t = &observation.time_s;
    let mut knots: Vec<f64> = observation.cycles.iter().map(|c| c.times.start_s).collect();
    knots.extend([t[0], t[t.len() - 1]]);
    knots.sort_by(f64::total_cmp);
    knots.dedup_by(|b, a| *b <= *a);
    let hat = |k: usize| {
        let rise = |t: f64| match k.checked_sub(1).map(|before| knots[before]) {
            Some(before) if t <= knots[k] => (t - before) / (knots[k] - before),
            _ if t <= knots[k] => 1.0,
            _ => knots.get(k + 1).map_or(0.0, |after| (after - t) / (after - knots[k])),
        };
        DVector::from_iterator(t.len(), t.iter().map(|&t| rise(t).clamp(0.0, 1.0)))
    };
    (0..knots.len()).map(hat).collect()
}

/// Slow shapes along a cycle: what all cycles share first, since a specimen that relaxes otherwise does so in every cycle, then
/// what later cycles add.
fn shapes(observation: &Observation) -> Vec<DVector<f64>> {
    let cycles: Vec<_> = (0..observation.cycles.len()).map(|c| hats_by_knot(observation, c, 1.0)).collect();
    let shared = sum_by_key(cycles.iter().flatten().map(|(knot, hat)| (*knot, hat)));
    let later = cycles.into_iter().skip(1).flat_map(BTreeMap::into_values);
    shared.into_values().chain(later).collect()
}
