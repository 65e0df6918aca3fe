//! Single samples that are far beside their neighbours: a glitch of the electronics, not the specimen.

use super::neighbours::Differences;
use crate::data::Measurement;
use crate::data::estimate::deviation_of_sizes;
use crate::data::neighbours::{distances, weights};

/// A sample of so many deviations is a spike: of ten thousand samples of normal noise none is.
const FAR: f64 = 5.0;
/// Samples on either side that tell the deviation there.
const AROUND: usize = 25;
/// A sample that is off moves the distances of both neighbours by a known part of its own; a kink of the curve moves neither, a step
/// one of them. On either side the first must be as many times more likely than no change, as twice their logarithm.
const RATHER_THAN_A_KINK: f64 = 6.0;
/// Spikes that are looked for, one after the other, in each hundred samples.
const MOST: usize = 5;

/// The largest spike of a record, if it has one.
fn largest_spike(time_s: &[f64], values: &[f64]) -> Option<usize> {
    let distances: Vec<f64> = distances(time_s, values).collect();
    let mut all = Differences::default();
    all.add(time_s, values);
    let everywhere = all.deviation()?;
    // Where the force changes fast, samples scatter more.
    let around = |k: usize| {
        let near = k.saturating_sub(AROUND)..(k + AROUND + 1).min(distances.len());
        let mut sizes: Vec<f64> = distances[near].iter().map(|d| d.abs()).collect();
        everywhere.max(deviation_of_sizes(&mut sizes))
    };
    let is_spike = |k: &usize| {
        let (own, deviation) = (distances[*k], around(*k));
        let more_likely = |neighbour: usize| {
            let part = weights(time_s, neighbour)[*k + 1 - neighbour] / weights(time_s, *k)[1];
            let off = |expected: f64| ((distances[neighbour] - expected) / deviation).powi(2);
            off(0.0) - off(part * own)
        };
        own.abs() > FAR * deviation && more_likely(k - 1).min(more_likely(k + 1)) > RATHER_THAN_A_KINK
    };
    let far = (1..distances.len().max(2) - 1).filter(|k| distances[*k].abs() > FAR * everywhere);
    let spikes = far.filter(is_spike);
    spikes.max_by(|a, b| distances[*a].abs().total_cmp(&distances[*b].abs())).map(|k| k + 1)
}

/// The measurement with the line through the neighbours in the place of every spike, and how many these are.
pub fn without_spikes(measurement: &Measurement) -> (Measurement, usize) {
    let mut clean = measurement.clone();
    let time_s = &measurement.time_s;
    let mut count = 0;
    let mut smooth = |values: &mut Vec<f64>| {
        for _ in 0..MOST * values.len() / 100 {
            let Some(k) = largest_spike(time_s, values) else { break };
            let part = (time_s[k] - time_s[k - 1]) / (time_s[k + 1] - time_s[k - 1]);
            values[k] = (1.0 - part) * values[k - 1] + part * values[k + 1];
            count += 1;
        }
    };
    if clean.specimens_n.is_empty() {
        smooth(&mut clean.force_n);
    } else {
        clean.specimens_n.iter_mut().for_each(smooth);
    }
    (clean, count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;

    /// Goal: spikes go, kinks and noise stay. Set-up: a ramp with a corner and its relaxation, 600 samples of a noise of 0.05 whose clock
    /// jitters by a tenth of the interval, five samples off by twenty deviations.
    #[test]
    fn single_samples_far_off_are_replaced_and_nothing_else() {
        let mut random = Random::new(2);
        let time_s: Vec<f64> = (0..600).map(|i| 0.02 * f64::from(i)).collect();
        let curve = |t: f64| if t < 2.0 { 5.0 * t } else { 4.0 + 6.0 * (-(t - 2.0) / 0.5).exp() };
        let clean: Vec<f64> =
            time_s.iter().map(|t| curve(t + 2e-3 * random.normal()) + 0.05 * random.normal()).collect();
        let mut force_n = clean.clone();
        let off = [30, 98, 103, 300, 550];
        off.iter().for_each(|&k| force_n[k] += 1.0);
        let m = Measurement { time_s, force_n, ..Measurement::default() };
        let (found, count) = without_spikes(&m);
        assert_eq!(count, off.len());
        for (k, (f, c)) in found.force_n.iter().zip(&clean).enumerate() {
            assert!(if off.contains(&k) { (f - c).abs() < 0.7 } else { f == c }, "{k} {f} {c}");
        }
        let kinked = Measurement { force_n: clean, ..m };
        assert_eq!(without_spikes(&kinked), (kinked.clone(), 0));
    }

    #[test]
    fn a_jump_is_no_spike() {
        let mut random = Random::new(3);
        let time_s: Vec<f64> = (0..200).map(f64::from).collect();
        let jump = |t: f64| if t < 90.5 { 0.0 } else { 4.0 };
        let force_n = time_s.iter().map(|t| jump(*t) + 0.07 * random.normal()).collect();
        let m = Measurement { time_s, force_n, ..Measurement::default() };
        assert_eq!(without_spikes(&m).1, 0);
    }

    #[test]
    fn steps_of_a_coarse_force_are_no_spikes() {
        let mut random = Random::new(4);
        let time_s: Vec<f64> = (0..500).map(f64::from).collect();
        let force_n = time_s.iter().map(|t| (0.01 * t + 0.2 * random.normal()).round()).collect();
        let m = Measurement { time_s, force_n, ..Measurement::default() };
        assert_eq!(without_spikes(&m).1, 0);
    }
}
