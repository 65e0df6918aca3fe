//! Parity of tests: the same specimens' material at another rate, or other specimens?
//!
//! After equal holds at equal depth a material with fading memory has forgotten the rate, so the ratio of the
//! forces there is an amplitude between two sets of specimens; what the peaks' ratio has beyond it is the rate's.

use super::cycle_readings::Readings;
use super::result::{Ratio, RatioValue, TestInspection};
use crate::data::measurement::{median, standard_deviation};

/// Standard deviation of a median over that of a mean, for many normal values.
const MEDIAN_OVER_MEAN: f64 = 1.253_314_137_315_5;
/// Rates nearer than this part are the same.
const SAME_RATE: f64 = 0.02;

/// All tests against the slowest, in the cycles that both have.
pub(super) fn ratios(tests: &[(TestInspection, Vec<Readings>)]) -> Vec<Ratio> {
    let rate = |t: &TestInspection| t.cycles.first().map_or(0.0, |c| c.rate_mm_per_s.value);
    let mut order: Vec<usize> = (0..tests.len()).collect();
    order.sort_by(|&a, &b| rate(&tests[a].0).total_cmp(&rate(&tests[b].0)));
    let Some((&slowest, others)) = order.split_first() else { return vec![] };
    let (reference, slow) = &tests[slowest];
    // Tests of one rate keep the order in which they were given.
    let first = |&i: &usize| rate(&tests[i].0) > (1.0 + SAME_RATE) * rate(reference) || i > slowest;
    let mut ratios = Vec::new();
    for &i in others.iter().filter(|i| first(i)) {
        let (test, fast) = &tests[i];
        for (k, (a, b)) in fast.iter().zip(slow).enumerate() {
            let over =
                |r: &Readings| r.peak_n.iter().zip(&r.hold_end_n).map(|(p, e)| p / e).collect::<Vec<f64>>();
            let (Some(peak), Some(hold_end)) =
                (ratio(&a.peak_n, &b.peak_n), ratio(&a.hold_end_n, &b.hold_end_n))
            else {
                continue;
            };
            let scatter = ratio(&over(a), &over(b)).and_then(|r| Some(r.sigma? / r.value));
            let value = peak.value / hold_end.value;
            ratios.push(Ratio {
                test: test.name.clone(),
                reference: reference.name.clone(),
                cycle: k + 1,
                rate: rate(test) / rate(reference),
                peak,
                hold_end,
                rate_effect: RatioValue { value, sigma: scatter.map(|s| s * value) },
            });
        }
    }
    ratios
}

/// Ratio of medians; the scatter of the logarithms tells its uncertainty.
fn ratio(a: &[f64], b: &[f64]) -> Option<RatioValue> {
    if a.is_empty() || b.is_empty() || a.iter().chain(b).any(|v| v.is_nan() || *v <= 0.0) {
        return None;
    }
    let value = median(&mut a.to_vec()) / median(&mut b.to_vec());
    let square = |v: &[f64]| {
        let logarithms: Vec<f64> = v.iter().map(|v| v.ln()).collect();
        (MEDIAN_OVER_MEAN * standard_deviation(&logarithms)).powi(2) / v.len() as f64
    };
    let known = a.len() >= 3 && b.len() >= 3;
    Some(RatioValue { value, sigma: known.then(|| value * (square(a) + square(b)).sqrt()) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;

    #[test]
    fn the_ratio_of_medians_is_recovered_within_its_uncertainty() {
        let mut scores = vec![];
        for seed in 0..200 {
            let mut random = Random::new(seed);
            let mut draw = |scale: f64| -> Vec<f64> {
                (0..10).map(|_| scale * (0.12 * random.normal()).exp()).collect()
            };
            let found = ratio(&draw(12.0), &draw(11.0)).unwrap();
            scores.push((found.value - 12.0 / 11.0) / found.sigma.unwrap());
        }
        let rms = (scores.iter().map(|z| z * z).sum::<f64>() / 200.0).sqrt();
        assert!((0.75..1.3).contains(&rms), "{rms}");
    }

    #[test]
    fn single_curves_have_a_ratio_without_uncertainty() {
        assert_eq!(ratio(&[3.0], &[2.0]), Some(RatioValue { value: 1.5, sigma: None }));
        assert_eq!(ratio(&[3.0], &[-2.0]), None);
    }
}
