//! White noise from neighbouring samples: what changes slowly, by a drift, a relaxation or a difference between specimens, cancels
//! from the distance of a sample to the line through its two neighbours.

use crate::data::measurement::median;
use nalgebra::DVectorView;

/// Distances of samples from the line through their neighbours, in units of the noise of one sample.
#[derive(Debug, Clone, Default)]
pub struct Differences(Vec<f64>);

/// Fewest distances that tell a deviation: of less most are kinks.
const FEWEST: usize = 20;
/// Deviation of normal values over the median of their sizes.
const DEVIATION_OVER_MEDIAN: f64 = 1.482_602_2;
/// A distance of so many deviations is a kink or an outlier.
const KINK: f64 = 4.0;

impl Differences {
    /// Adds those of a record.
    pub fn add(&mut self, time_s: &[f64], values: &[f64]) {
        let distance = |(t, v): (&[f64], &[f64])| {
            let b = (t[1] - t[0]) / (t[2] - t[0]);
            let a = 1.0 - b;
            (v[1] - a * v[0] - b * v[2]).abs() / (1.0 + a * a + b * b).sqrt()
        };
        self.0.extend(time_s.windows(3).zip(values.windows(3)).map(distance));
    }

    /// Their root mean square without kinks; none of too few.
    pub fn deviation(&self) -> Option<f64> {
        if self.0.len() < FEWEST {
            return None;
        }
        let robust = DEVIATION_OVER_MEDIAN * median(&mut self.0.clone());
        // Of a coarsely quantised force most distances are 0: then all speak.
        let most = if robust > 0.0 { KINK * robust } else { f64::INFINITY };
        let kept: Vec<f64> = self.0.iter().copied().filter(|d| *d <= most).collect();
        Some((kept.iter().map(|d| d * d).sum::<f64>() / kept.len() as f64).sqrt())
    }
}

/// White deviation of several records at the same times; none of too few samples.
pub fn white_noise<'a>(time_s: &[f64], records: impl Iterator<Item = DVectorView<'a, f64>>) -> Option<f64> {
    let mut differences = Differences::default();
    records.for_each(|record| differences.add(time_s, record.as_slice()));
    differences.deviation()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;

    fn deviation(value: impl Fn(f64) -> f64) -> f64 {
        let mut random = Random::new(3);
        let time_s: Vec<f64> = (0..600).map(|i| 0.1 * f64::from(i) + 0.02 * random.normal()).collect();
        let values: Vec<f64> = time_s.iter().map(|&t| value(t) + 0.07 * random.normal()).collect();
        let mut differences = Differences::default();
        differences.add(&time_s, &values);
        differences.deviation().unwrap()
    }

    #[test]
    fn drift_relaxation_and_a_jump_are_no_white_noise() {
        for value in [
            (|_| 0.0) as fn(f64) -> f64,
            |t| 0.05 * t,
            |t| 4.0 * (-t / 20.0).exp(),
            |t| if t > 30.0 { 2.0 } else { 0.0 },
        ] {
            // 600 samples tell a deviation to 4 %.
            assert!((deviation(value) / 0.07 - 1.0).abs() < 0.12, "{}", deviation(value));
        }
    }

    #[test]
    fn a_coarsely_quantised_force_has_the_noise_of_its_steps() {
        let mut random = Random::new(5);
        let time_s: Vec<f64> = (0..400).map(f64::from).collect();
        let values: Vec<f64> = time_s.iter().map(|_| (0.2 * random.normal()).round()).collect();
        let mut differences = Differences::default();
        differences.add(&time_s, &values);
        let truth = (values.iter().map(|v| v * v).sum::<f64>() / 400.0).sqrt();
        assert!(truth > 0.0 && (differences.deviation().unwrap() / truth - 1.0).abs() < 0.3);
    }
}
