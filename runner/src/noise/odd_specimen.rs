//! A specimen that is none of its kind: one whose curve differs from the others' far more than these differ among each other.
//!
//! The mean follows such a specimen, and a scatter that contains it hides it. So each is held against the others alone: all are brought to
//! one height, the difference of its curve from their mean has the size `d`, and with the `n - 1` others' own sizes `d_j`
//! `d^2 (n - 2) (n - 1) / (n sum d_j^2)` is `F(1, n - 2)` where they differ by one shape, and spread less where by more.

use crate::data::Measurement;
use nalgebra::DVector;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Fewest specimens of which one can be odd: not more than one in so many is.
const FEWEST: usize = 4;
/// Probability, of any of the specimens of a test, below which one is odd: one good one is lost of a hundred tests, which costs little.
const ODD: f64 = 1e-2;
/// Means of so many stretches of the record stand for a curve: they are smooth where samples are noisy.
const STRETCHES: usize = 40;

/// A specimen that is none of its kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Odd {
    /// Which of the measurement's specimens.
    pub index: usize,
    /// What is odd about it.
    pub why: String,
}

/// The measurement without the specimens of an odd shape, and what is left out, in words.
pub fn without_odd(measurement: &Measurement) -> (Measurement, Vec<String>) {
    let mut kept = measurement.clone();
    let odd = odd_in_shape(measurement);
    let is_odd = |k: usize| odd.iter().any(|o| o.index == k);
    for k in (0..measurement.specimens_n.len()).rev().filter(|k| is_odd(*k)) {
        kept.specimens_n.remove(k);
        if k < kept.specimen_names.len() {
            kept.specimen_names.remove(k);
        }
    }
    let name = |k: usize| measurement.specimen_names.get(k).cloned().unwrap_or_else(|| format!("{}", k + 1));
    (kept, odd.iter().map(|o| format!("specimen {}: {}", name(o.index), o.why)).collect())
}

/// Specimens whose curve has another shape than the others'.
pub fn odd_in_shape(measurement: &Measurement) -> Vec<Odd> {
    let why = |times: f64, others: usize| {
        format!(
            "its curve differs in shape from the mean of the other {others} by {times:.0} times what one of them does"
        )
    };
    odd(measurement, shape, why)
}

/// Specimens whose curve is higher or lower than the others'.
pub fn odd_in_height(measurement: &Measurement) -> Vec<Odd> {
    let why = |times: f64, others: usize| {
        format!(
            "its force differs in height from the mean of the other {others} by {times:.0} times what one of them does"
        )
    };
    odd(measurement, height, why)
}

/// The odd specimens, the oddest first; `size` is how far a specimen is from all others, in their own deviations.
fn odd(
    measurement: &Measurement,
    size: impl Fn(&[DVector<f64>], usize) -> f64,
    why: impl Fn(f64, usize) -> String,
) -> Vec<Odd> {
    let mut left: Vec<(usize, DVector<f64>)> =
        measurement.specimens_n.iter().map(|s| stretches(s)).enumerate().collect();
    let mut found = Vec::new();
    while left.len() >= FEWEST && found.len() < measurement.specimens_n.len() / FEWEST {
        let n = left.len();
        let curves: Vec<DVector<f64>> = left.iter().map(|(_, curve)| curve.clone()).collect();
        let sizes = (0..n).map(|k| (k, size(&curves, k))).filter(|(_, size)| size.is_finite());
        let Some((k, times)) = sizes.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        let student = StudentsT::new(0.0, 1.0, (n - 2) as f64);
        if !student.is_ok_and(|student| 2.0 * n as f64 * student.sf(times) < ODD) {
            break;
        }
        found.push(Odd { index: left.remove(k).0, why: why(times, n - 1) });
    }
    found
}

/// Distance of a curve's shape from that of the mean of all others.
fn shape(curves: &[DVector<f64>], k: usize) -> f64 {
    let n = curves.len();
    let others = || (0..n).filter(move |&j| j != k);
    let sum: DVector<f64> = others().map(|j| &curves[j]).sum();
    let mean = sum / (n - 1) as f64;
    let beside = |j: usize| {
        let height = curves[j].dot(&mean) / mean.norm_squared();
        (&curves[j] / height - &mean).norm_squared()
    };
    let own: f64 = others().map(beside).sum::<f64>() / (n - 2) as f64;
    (beside(k) * (n - 1) as f64 / (n as f64 * own)).sqrt()
}

/// Distance of a curve's logarithmic height from the mean of all others'.
fn height(curves: &[DVector<f64>], k: usize) -> f64 {
    let n = curves.len();
    let heights: Vec<f64> = curves.iter().map(|c| c.norm().ln()).collect();
    let others = || (0..n).filter(move |&j| j != k).map(|j| heights[j]);
    let mean = others().sum::<f64>() / (n - 1) as f64;
    let own = others().map(|h| (h - mean).powi(2)).sum::<f64>() / (n - 2) as f64;
    ((heights[k] - mean).powi(2) * (n - 1) as f64 / (n as f64 * own)).sqrt()
}

/// Means of stretches with equally many samples.
fn stretches(force_n: &[f64]) -> DVector<f64> {
    let means = force_n.chunks(force_n.len().div_ceil(STRETCHES).max(1));
    let means: Vec<f64> = means.map(|c| c.iter().sum::<f64>() / c.len() as f64).collect();
    DVector::from_vec(means)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;

    /// Specimens whose heights scatter by 10 %, whose relaxation scatters by 2 %, with white noise; the third loses `loss` of its force in
    /// the hold.
    fn test(seed: u64, specimens: usize, loss: f64) -> Measurement {
        let mut random = Random::new(seed);
        let mut one = |k: usize| -> Vec<f64> {
            let (height, late) = ((0.1 * random.normal()).exp(), 0.02 * random.normal());
            let lost = if k == 2 { loss } else { 0.0 };
            let force = |i: usize| {
                let t = i as f64 / 240.0;
                height * 1e-2 * (0.5 + 0.5 * (-4.0 * t).exp()) * (1.0 + late * t) * (1.0 - lost * t)
            };
            (0..240).map(|i| force(i) + 3e-5 * random.normal()).collect()
        };
        Measurement {
            specimens_n: (0..specimens).map(&mut one).collect(),
            specimen_names: (1..=specimens).map(|k| format!("s{k:02}")).collect(),
            ..Measurement::default()
        }
    }

    #[test]
    fn a_bad_specimen_is_found() {
        for (seed, specimens) in [(1, 5), (2, 8), (3, 12)] {
            let (kept, told) = without_odd(&test(seed, specimens, 0.6));
            assert_eq!(kept.specimens_n.len(), specimens - 1);
            assert_eq!(kept.specimen_names.len(), specimens - 1);
            assert!(told.len() == 1 && told[0].starts_with("specimen s03:"), "{told:?}");
        }
    }

    #[test]
    fn a_specimen_of_another_height_is_told_and_kept() {
        let mut m = test(4, 8, 0.0);
        assert!(odd_in_height(&m).is_empty());
        m.specimens_n[5].iter_mut().for_each(|f| *f *= 2.2);
        let found = odd_in_height(&m);
        assert!(found.len() == 1 && found[0].index == 5 && found[0].why.contains("height"), "{found:?}");
        assert_eq!(without_odd(&m).0.specimens_n.len(), 8);
    }

    /// One test in a hundred at most, so of 300 more than nine in less than 1 of 500 runs.
    #[test]
    fn natural_scatter_is_not_odd() {
        let odd =
            (0..300).filter(|&seed| !without_odd(&test(seed, 3 + seed as usize % 10, 0.0)).1.is_empty());
        assert!(odd.count() <= 9);
        let odd =
            (0..300).filter(|&seed| !odd_in_height(&test(seed, 3 + seed as usize % 10, 0.0)).is_empty());
        assert!(odd.count() <= 9);
    }
}
