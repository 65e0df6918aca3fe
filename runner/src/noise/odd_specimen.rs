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

/// The measurement without its odd specimens, and what is left out, in words.
pub fn without_odd(measurement: &Measurement) -> (Measurement, Vec<String>) {
    let mut kept = measurement.clone();
    let mut told = Vec::new();
    while kept.specimens_n.len() >= FEWEST && told.len() < measurement.specimens_n.len() / FEWEST {
        let Some((k, times)) = odd(&kept.specimens_n) else { break };
        kept.specimens_n.remove(k);
        let name = match k < kept.specimen_names.len() {
            true => kept.specimen_names.remove(k),
            false => format!("{}", k + 1),
        };
        told.push(format!(
            "specimen {name}: its curve differs in shape from the mean of the other {} by {times:.0} times what one of them does",
            kept.specimens_n.len()
        ));
    }
    (kept, told)
}

/// The specimen that differs most from all others, and by how many of their deviations, if it is odd.
fn odd(specimens_n: &[Vec<f64>]) -> Option<(usize, f64)> {
    let n = specimens_n.len();
    let curves: Vec<DVector<f64>> = specimens_n.iter().map(|s| stretches(s)).collect();
    let times = |k: usize| {
        let others = || (0..n).filter(move |&j| j != k);
        let sum: DVector<f64> = others().map(|j| &curves[j]).sum();
        let mean = sum / (n - 1) as f64;
        let beside = |j: usize| {
            let height = curves[j].dot(&mean) / mean.norm_squared();
            (&curves[j] / height - &mean).norm_squared()
        };
        let own: f64 = others().map(beside).sum::<f64>() / (n - 2) as f64;
        (beside(k) * (n - 1) as f64 / (n as f64 * own)).sqrt()
    };
    let all = (0..n).map(|k| (k, times(k))).filter(|(_, times)| times.is_finite());
    let (k, times) = all.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let student = StudentsT::new(0.0, 1.0, (n - 2) as f64).ok()?;
    (2.0 * n as f64 * student.sf(times) < ODD).then_some((k, times))
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

    /// One test in a hundred at most, so of 300 more than nine in less than 1 of 500 runs.
    #[test]
    fn natural_scatter_is_not_odd() {
        let odd =
            (0..300).filter(|&seed| !without_odd(&test(seed, 3 + seed as usize % 10, 0.0)).1.is_empty());
        assert!(odd.count() <= 9);
    }
}
