//! White noise from neighbouring samples, from the distance of each to the line through its two neighbours.

use crate::data::estimate::deviation_of_sizes;
use crate::data::neighbours::{FEWEST, distances};
use nalgebra::DVectorView;

/// Distances of samples from the line through their neighbours, in units of the noise of one sample.
#[derive(Debug, Clone, Default)]
pub struct Differences(Vec<f64>);

/// A distance of so many deviations is a kink or an outlier.
const KINK: f64 = 4.0;

impl Differences {
    /// Adds those of a record.
    pub fn add(&mut self, time_s: &[f64], values: &[f64]) {
        self.add_where(time_s, values, &|_| true);
    }

    /// Adds those of some samples of a record.
    fn add_where(&mut self, time_s: &[f64], values: &[f64], wanted: &dyn Fn(usize) -> bool) {
        let sizes = distances(time_s, values).map(f64::abs);
        self.0.extend(sizes.zip(1..).filter(|(_, i)| wanted(*i)).map(|(d, _)| d));
    }

    /// Their root mean square without kinks; none of too few.
    pub fn deviation(&self) -> Option<f64> {
        if self.0.len() < FEWEST {
            return None;
        }
        let robust = deviation_of_sizes(&mut self.0.clone());
        // Of a coarsely quantised force most distances are 0: then all speak.
        let most = if robust > 0.0 { KINK * robust } else { f64::INFINITY };
        let kept: Vec<f64> = self.0.iter().copied().filter(|d| *d <= most).collect();
        Some((kept.iter().map(|d| d * d).sum::<f64>() / kept.len() as f64).sqrt())
    }
}

/// White noise of records.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct White {
    /// Deviation where the records are still.
    pub still: f64,
    /// Deviation of the times at which samples are taken (s); 0 where none is seen.
    pub clock_s: f64,
}

impl White {
    /// Deviation where the records change at this rate.
    pub fn at(&self, slope: f64) -> f64 {
        self.still.hypot(self.clock_s * slope)
    }
}

/// Samples move where the rate is at least this part of the largest.
const MOVING: f64 = 0.3;
/// The clock is seen where the moving samples' variance is this many of its standard errors above that of the others.
const BEYOND_DOUBT: f64 = 3.0;

/// White noise of several records at the same times, which change at these rates; none of too few samples.
///
/// Where samples are taken a little beside their times, neighbours differ the more the faster the force changes.
pub fn white_noise<'a>(
    time_s: &[f64],
    slopes: &[f64],
    records: impl Iterator<Item = DVectorView<'a, f64>> + Clone,
) -> Option<White> {
    let largest = slopes.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
    let is_moving = |i: usize| slopes[i].abs() > MOVING * largest;
    let of = |wanted: &dyn Fn(usize) -> bool| {
        let mut found = Differences::default();
        records.clone().for_each(|record| found.add_where(time_s, record.as_slice(), wanted));
        found
    };
    let all = of(&|_| true).deviation()?;
    let (moving, still) = (of(&is_moving), of(&|i| !is_moving(i)).deviation().unwrap_or(all));
    let more = moving.deviation().map_or(0.0, |m| m * m - still * still);
    let doubt = still * still * (2.0 / moving.0.len().max(1) as f64).sqrt();
    let fast: Vec<f64> = (0..slopes.len()).filter(|i| is_moving(*i)).map(|i| slopes[i].powi(2)).collect();
    if more > BEYOND_DOUBT * doubt {
        let clock_s = (more * fast.len() as f64 / fast.iter().sum::<f64>()).sqrt();
        return Some(White { still, clock_s });
    }
    Some(White { still: all, clock_s: 0.0 })
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

    /// Goal: a clock that jitters is told from noise of the force. Set-up: a ramp of 5 per second for 2 s, then a rest; force noise 0.07,
    /// clock 0 or 40 ms. Tolerance: 100 moving samples of 10 records tell a deviation to 3 %.
    #[test]
    fn a_clock_that_jitters_is_seen_where_the_force_changes() {
        let time_s: Vec<f64> = (0..400).map(|i| 0.02 * f64::from(i)).collect();
        let slopes: Vec<f64> = time_s.iter().map(|t| if *t < 2.0 { 5.0 } else { 0.0 }).collect();
        for clock_s in [0.0, 0.04] {
            let mut random = Random::new(7);
            let mut record = || {
                let late = |slope: &f64| slope * clock_s * random.normal() + 0.07 * random.normal();
                nalgebra::DVector::from_iterator(400, slopes.iter().map(late))
            };
            let records: Vec<_> = (0..10).map(|_| record()).collect();
            let found = white_noise(&time_s, &slopes, records.iter().map(|r| r.column(0))).unwrap();
            assert!((found.still / 0.07 - 1.0).abs() < 0.05, "{found:?}");
            assert!((found.clock_s - clock_s).abs() <= 0.1 * clock_s, "{found:?}");
            approx::assert_relative_eq!(found.at(3.0), found.still.hypot(3.0 * found.clock_s));
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
