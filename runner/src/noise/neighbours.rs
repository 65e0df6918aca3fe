//! White noise from neighbouring samples, from the distance of each to the line through its two neighbours.

use crate::data::estimate::deviation_of_sizes;
use crate::data::neighbours::{FEWEST, distances, weights};
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

    /// What samples miss of a curve's kinks on average, as they are taken beside their times: of a change of slope this part,
    /// `E max(x, 0) = 1 / sqrt(2 pi)` of a normal deviate. No number of records takes that away.
    pub fn missed_by_kinks(&self, time_s: &[f64], values: &[f64]) -> Vec<f64> {
        let slope = |i: usize| (values[i + 1] - values[i]) / (time_s[i + 1] - time_s[i]);
        let at = |i: usize| {
            if i == 0 || i + 1 == values.len() {
                return 0.0;
            }
            self.clock_s * (slope(i) - slope(i - 1)).abs() / std::f64::consts::TAU.sqrt()
        };
        (0..values.len()).map(at).collect()
    }
}

/// Samples move where the rate is at least this part of the largest.
const MOVING: f64 = 0.3;
/// The clock is seen where twice the log likelihood is larger with it by the square of this: so many deviations.
const BEYOND_DOUBT: f64 = 3.0;
/// Steps to the most likely clock: each leaves a part of the distance to it.
const STEPS: usize = 60;

/// White noise of several records at the same times, which change at these rates; none of too few samples.
///
/// Where samples are taken a little beside their times, neighbours differ the more the faster the force changes: a distance from the line
/// through the neighbours has the variance `still^2 + clock^2 sum w^2 slope^2`, the sum over the three samples with their weights.
pub fn white_noise<'a>(
    time_s: &[f64],
    slopes: &[f64],
    records: impl Iterator<Item = DVectorView<'a, f64>> + Clone,
) -> Option<White> {
    let largest = slopes.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
    let of = |wanted: &dyn Fn(usize) -> bool| {
        let mut found = Differences::default();
        records.clone().for_each(|record| found.add_where(time_s, record.as_slice(), wanted));
        found.deviation()
    };
    let all = of(&|_| true)?;
    let still = of(&|i| slopes[i].abs() <= MOVING * largest).unwrap_or(all);
    let by_clock: Vec<f64> = (0..slopes.len().saturating_sub(2))
        .map(|i| weights(time_s, i).iter().zip(&slopes[i..]).map(|(w, slope)| (w * slope).powi(2)).sum())
        .collect();
    let squares = records.flat_map(|record| {
        let found: Vec<f64> = distances(time_s, record.as_slice()).map(|d| d * d).collect();
        found.into_iter().zip(&by_clock)
    });
    let squares: Vec<(f64, f64)> = squares.map(|(square, own)| (square, *own)).collect();
    let white = still * still;
    // Fisher's scoring.
    let mut clock = 0.0;
    for _ in 0..STEPS {
        let weighed = squares.iter().map(|(square, own)| (square, own, (white + clock * own).powi(-2)));
        let (above, below) = weighed.fold((0.0, 0.0), |(above, below), (square, own, weight)| {
            (above + weight * own * (square - white), below + weight * own * own)
        });
        clock = if below > 0.0 { f64::max(above / below, 0.0) } else { 0.0 };
    }
    let twice_log = |clock: f64| -> f64 {
        squares.iter().map(|(square, own)| -(white + clock * own).ln() - square / (white + clock * own)).sum()
    };
    if white > 0.0 && twice_log(clock) - twice_log(0.0) > BEYOND_DOUBT.powi(2) {
        return Some(White { still, clock_s: clock.sqrt() });
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

    /// Goal: the mean of samples at a corner. Set-up: 20 000 samples of a corner from 3 per second up to 5 per second down, a clock of 40 ms.
    /// Tolerance: four standard errors.
    #[test]
    fn samples_beside_their_times_miss_a_corner() {
        let curve = |t: f64| if t < 0.0 { 3.0 * t } else { -5.0 * t };
        let times: Vec<f64> = (-5..6).map(|i| 0.1 * f64::from(i)).collect();
        let values: Vec<f64> = times.iter().map(|t| curve(*t)).collect();
        let missed = White { still: 0.0, clock_s: 0.04 }.missed_by_kinks(&times, &values);
        let mut random = Random::new(9);
        let mean = (0..20_000).map(|_| curve(0.04 * random.normal())).sum::<f64>() / 2e4;
        assert!((missed[5] + mean).abs() < 4.0 * 0.04 * 5.0 / 2e4_f64.sqrt(), "{} {mean}", missed[5]);
        assert!((0..11).filter(|i| *i != 5).all(|i| missed[i] < 1e-9));
    }

    /// A force that jumps between two samples tells the clock by these alone: three records of a step, 4 ms of 20.
    #[test]
    fn a_clock_is_seen_at_a_single_fast_change() {
        let time_s: Vec<f64> = (0..200).map(|i| 0.02 * f64::from(i)).collect();
        let slopes: Vec<f64> = (0..200).map(|i| if (100..102).contains(&i) { 250.0 } else { 0.5 }).collect();
        let found: Vec<White> = (0..20)
            .map(|seed| {
                let mut random = Random::new(seed);
                let mut record = || {
                    let late = |slope: &f64| slope * 4e-3 * random.normal() + 0.07 * random.normal();
                    nalgebra::DVector::from_iterator(200, slopes.iter().map(late))
                };
                let records: Vec<_> = (0..3).map(|_| record()).collect();
                white_noise(&time_s, &slopes, records.iter().map(|r| r.column(0))).unwrap()
            })
            .collect();
        // Six samples tell a variance to a factor of two.
        let mean = found.iter().map(|w| w.clock_s.powi(2)).sum::<f64>() / 20.0;
        assert!((mean.sqrt() / 4e-3 - 1.0).abs() < 0.25, "{}", mean.sqrt());
        assert!(found.iter().all(|w| (w.still / 0.07 - 1.0).abs() < 0.15));
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
