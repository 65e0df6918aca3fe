//! The part of the scatter that a specimen's whole curve shares: `force_k(t) = a_k median(t)`, `ln a_k` normal.

use crate::data::estimate::Estimate;
use crate::data::measurement::{Measurement, standard_deviation};

/// Standard deviation of a median over that of a mean, for many normal values: sqrt(pi / 2).
pub const MEDIAN_OVER_MEAN: f64 = 1.253_314_137_315_5;
/// Fewest specimens whose scatter means anything.
pub const FEWEST_SPECIMENS: usize = 3;

/// Scatter of specimens about the median curve.
#[derive(Debug, Clone, PartialEq)]
pub struct CommonFactor {
    /// Factor of each specimen (-).
    pub amplitudes: Vec<f64>,
    /// Standard deviation of the factors' logarithms (-).
    pub log_deviation: Estimate,
    /// What that leaves unknown of the logarithm of the median curve's height (-).
    pub of_median: f64,
}

/// Factor of each specimen, by least squares against the median.
pub fn amplitudes(m: &Measurement) -> Vec<f64> {
    let square: f64 = m.force_n.iter().map(|f| f * f).sum();
    let product = |s: &Vec<f64>| s.iter().zip(&m.force_n).map(|(a, b)| a * b).sum::<f64>();
    m.specimens_n.iter().map(|s| product(s) / square).collect()
}

/// Log-normal scatter of the specimens' factors; none of fewer than three specimens, or of factors that are not
/// positive.
pub fn common_factor(m: &Measurement) -> Option<CommonFactor> {
    let amplitudes = amplitudes(m);
    let logarithms: Vec<f64> = amplitudes.iter().map(|a| a.ln()).collect();
    if amplitudes.len() < FEWEST_SPECIMENS || logarithms.iter().any(|l| !l.is_finite()) {
        return None;
    }
    let n = amplitudes.len() as f64;
    let value = standard_deviation(&logarithms);
    let log_deviation = Estimate { value, sigma: value / (2.0 * (n - 1.0)).sqrt() };
    let of_median = MEDIAN_OVER_MEAN * value / n.sqrt();
    Some(CommonFactor { amplitudes, log_deviation, of_median })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;

    fn measurement(scatter: f64, seed: u64) -> Measurement {
        let mut random = Random::new(seed);
        let truth: Vec<f64> =
            (0..200).map(|i| if i < 60 { 0.0 } else { 8e-3 - 1e-5 * f64::from(i) }).collect();
        let specimens = (0..10).map(|_| {
            let factor = (scatter * random.normal()).exp();
            truth.iter().map(|f| factor * f + 0.07e-3 * random.normal()).collect()
        });
        let mut m = Measurement {
            time_s: (0..200).map(f64::from).collect(),
            displacement_m: vec![1e-3; 200],
            specimens_n: specimens.collect(),
            ..Measurement::default()
        };
        m.summarise_specimens();
        m
    }

    #[test]
    fn the_scatter_is_recovered_within_its_uncertainty() {
        let (mut scores, mut heights, mut sum) = (vec![], vec![], 0.0);
        for seed in 0..200 {
            let m = measurement(0.12, seed);
            let found = common_factor(&m).unwrap();
            scores.push((found.log_deviation.value - 0.12) / found.log_deviation.sigma);
            sum += found.log_deviation.value;
            // Truth at the last point is 6.01 mN.
            heights.push((m.force_n[199] / 6.01e-3).ln() / found.of_median);
        }
        let rms = |z: &[f64]| (z.iter().map(|z| z * z).sum::<f64>() / 200.0).sqrt();
        assert!((0.8..1.3).contains(&rms(&scores)), "{}", rms(&scores));
        assert!((0.8..1.25).contains(&rms(&heights)), "{}", rms(&heights));
        assert!((sum / 200.0 / 0.12 - 1.0).abs() < 0.05, "{}", sum / 200.0);
    }

    #[test]
    fn two_specimens_tell_no_scatter() {
        let mut m = measurement(0.12, 1);
        m.specimens_n.truncate(2);
        assert_eq!(common_factor(&m), None);
    }
}
