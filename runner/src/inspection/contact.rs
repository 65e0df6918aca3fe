//! Where the punch touches: the force passes a threshold (the paper's way), and the onset extrapolated from there.

use super::trace::Trace;
use crate::data::{Cycle, Estimate};

/// First touch in one cycle of one specimen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Time at which the force passes the threshold (s).
    pub time_s: f64,
    /// Displacement at which the force passes the threshold (m).
    pub threshold_m: Estimate,
    /// Displacement at which the force begins, extrapolated from the samples up to three thresholds (m).
    pub onset_m: Option<Estimate>,
}

/// The onset is fitted to forces up to this many thresholds.
const FITTED_THRESHOLDS: f64 = 3.0;
/// Fewest samples after the onset for its fit: two unknowns of the curve, one of the place.
const FEWEST_SAMPLES: usize = 4;
/// Places tried for the onset.
const PLACES: usize = 200;
/// Depths tried over which the fast part of the force comes up.
const DEPTHS: usize = 12;

/// Contact in a cycle: `noise_n` is the standard deviation of a force sample, `base_n` the force in the air, above
/// which the threshold counts: a load cell that has drifted since it was tared is no contact.
///
/// None when the force does not pass the threshold in the approach or the ramp.
pub fn find_contact(
    trace: &Trace,
    cycle: &Cycle,
    threshold_n: f64,
    noise_n: f64,
    base_n: Estimate,
) -> Option<Contact> {
    let range = cycle.points(trace.time_s, cycle.times.start_s, cycle.times.ramp_end_s);
    let level_n = threshold_n + base_n.value;
    let (t, d, f) =
        (&trace.time_s[range.clone()], &trace.displacement_m[range.clone()], &trace.force_n[range]);
    // One sample above the threshold may be noise; two in a row are contact.
    let above = |i: usize| f[i] >= level_n && f.get(i + 1).is_none_or(|next| *next >= level_n);
    let i = (1..f.len()).find(|&i| above(i) && f[i - 1] < level_n)?;
    let slope = (f[i] - f[i - 1]) / (d[i] - d[i - 1]);
    if slope.is_nan() || slope <= 0.0 {
        return None;
    }
    let part = (level_n - f[i - 1]) / (f[i] - f[i - 1]);
    let place = d[i - 1] + part * (d[i] - d[i - 1]);
    let sigma = [
        noise_n * part.hypot(1.0 - part) / slope,
        base_n.sigma / slope,
        trace.displacement_noise_m * part.hypot(1.0 - part),
        chord_error(d, f, i) / slope,
    ];
    let onset_m = onset(d, f, i, noise_n, (threshold_n, base_n));
    Some(Contact {
        time_s: t[i - 1] + part * (t[i] - t[i - 1]),
        threshold_m: Estimate { value: place, sigma: sigma.iter().map(|s| s * s).sum::<f64>().sqrt() },
        onset_m,
    })
}

/// How far a smooth curve may be from its chord between two samples: an eighth of the second difference.
fn chord_error(d: &[f64], f: &[f64], i: usize) -> f64 {
    let (Some(next_d), Some(next_f)) = (d.get(i + 1), f.get(i + 1)) else { return 0.0 };
    let (before, after) = ((f[i] - f[i - 1]) / (d[i] - d[i - 1]), (next_f - f[i]) / (next_d - d[i]));
    let change = if after.is_finite() { (after - before).abs() } else { 0.0 };
    change * (d[i] - d[i - 1]).abs() / 8.0
}

/// Place of the onset at which the curve from there fits best.
fn onset(
    d: &[f64],
    f: &[f64],
    crossing: usize,
    noise_n: f64,
    (threshold_n, base_n): (f64, Estimate),
) -> Option<Estimate> {
    let high = f.iter().skip(crossing).position(|v| *v - base_n.value > FITTED_THRESHOLDS * threshold_n);
    let end = high.map_or(f.len(), |n| crossing + n).max(crossing + FEWEST_SAMPLES).min(f.len());
    let (d, f) = (&d[..end], &f[..end]);
    let reach = (d[end - 1] - d[crossing - 1]).max(0.0);
    let lowest = d.iter().copied().fold(f64::INFINITY, f64::min).max(d[crossing] - 2.0 * reach);
    let step = (d[crossing] - lowest) / (PLACES as f64 - 1.0);
    if step.is_nan() || step <= 0.0 {
        return None;
    }
    let depths: Vec<f64> =
        (0..DEPTHS).map(|k| reach * 0.02_f64.powf(k as f64 / (DEPTHS as f64 - 1.0))).collect();
    let fitted = |place: f64| {
        let costs = depths.iter().filter_map(|&depth| cost(d, f, place, depth, base_n.value));
        costs.min_by(f64::total_cmp).map(|c| c / (noise_n * noise_n))
    };
    let places: Vec<(f64, f64)> = (0..PLACES)
        .map(|k| lowest + step * k as f64)
        .filter_map(|place| Some((place, fitted(place)?)))
        .collect();
    let best = places.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))?;
    // A law that does not quite fit knows its place less well.
    let degrees = (f.len() as f64 - 4.0).max(1.0);
    let inflation = (best.1 / degrees).max(1.0);
    // The cost has a kink at every sample, often several minima: mean and deviation of the likelihood over all
    // places, not its curvature at one of them.
    let weighed = || places.iter().map(|p| (p.0, (-0.5 * (p.1 - best.1) / inflation).exp()));
    let sum: f64 = weighed().map(|p| p.1).sum();
    let value = weighed().map(|p| p.0 * p.1).sum::<f64>() / sum;
    let variance = weighed().map(|p| (p.0 - value).powi(2) * p.1).sum::<f64>() / sum;
    Some(Estimate { value, sigma: variance.sqrt().max(0.3 * step) })
}

/// Sum of squares of the best curve `F = base + b x + a (1 - exp(-x / depth))`, `x` the displacement from the
/// onset: what a spring beside a Maxwell element gives at constant rate. None where too few samples lie beyond
/// the onset, or the curve would begin by pulling.
fn cost(d: &[f64], f: &[f64], place: f64, depth: f64, base_n: f64) -> Option<f64> {
    let (mut xx, mut xq, mut qq, mut xy, mut qy, mut yy, mut n) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0);
    for (&d, &f) in d.iter().zip(f) {
        let (x, y) = ((d - place).max(0.0), f - base_n);
        // In the unit of a displacement, so that the normal equations are balanced.
        let q = depth * (1.0 - (-x / depth).exp());
        (xx, xq, qq) = (xx + x * x, xq + x * q, qq + q * q);
        (xy, qy, yy) = (xy + x * y, qy + q * y, yy + y * y);
        n += usize::from(x > 0.0);
    }
    let determinant = xx * qq - xq * xq;
    if n < FEWEST_SAMPLES || determinant <= 1e-10 * xx * qq {
        return None;
    }
    let (b, a) = ((qq * xy - xq * qy) / determinant, (xx * qy - xq * xy) / determinant);
    (a + b > 0.0).then(|| (yy - b * xy - a * qy).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;
    use crate::data::{Measurement, Synchronised, cycles};

    const NOISE: f64 = 0.05e-3;
    /// A load cell that has drifted.
    const BASE: Estimate = Estimate { value: -0.7e-3, sigma: 1e-6 };

    /// First touch at `onset`: 20 mN/mm, and 0.6 mN that come up within 0.02 mm, as on a hydrogel at 1 mm/s.
    fn force(x: f64) -> f64 {
        if x > 0.0 { 20.0 * x + 0.6e-3 * (1.0 - (-x / 0.02e-3).exp()) } else { 0.0 }
    }

    fn measured(onset: f64, seed: u64) -> Measurement {
        let mut random = Random::new(seed);
        let start = -0.15e-3 - 0.02e-3 * random.uniform();
        let time_s: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
        let displacement_m: Vec<f64> = time_s.iter().map(|t| (start + 1e-3 * t).min(0.2e-3)).collect();
        let force_n =
            displacement_m.iter().map(|d| BASE.value + force(d - onset) + NOISE * random.normal()).collect();
        Measurement { time_s, displacement_m, force_n, ..Measurement::default() }
    }

    fn contact(m: &Measurement) -> Option<Contact> {
        let test = Synchronised { measurement: m.clone(), originals: vec![], shifts_s: vec![] };
        let trace = &Trace::of_all(&test).unwrap()[0];
        find_contact(trace, &trace.cycles[0], 1e-3, NOISE, BASE)
    }

    #[test]
    fn threshold_and_onset_are_recovered_within_their_uncertainty() {
        let (mut at_threshold, mut at_onset) = (vec![], vec![]);
        for seed in 0..100 {
            let onset = -0.03e-3 + 6e-7 * seed as f64;
            let found = contact(&measured(onset, seed)).unwrap();
            // force(x) = 1 mN
            let threshold = onset + 2.756179e-5;
            at_threshold.push((found.threshold_m.value - threshold) / found.threshold_m.sigma);
            let fitted = found.onset_m.unwrap();
            assert!(found.threshold_m.sigma < 6e-6 && fitted.sigma < 8e-6, "{found:?}");
            at_onset.push((fitted.value - onset) / fitted.sigma);
        }
        let rms = |z: &[f64]| (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
        assert!((0.6..1.4).contains(&rms(&at_threshold)), "{}", rms(&at_threshold));
        assert!((0.6..1.5).contains(&rms(&at_onset)), "{} {at_onset:.1?}", rms(&at_onset));
    }

    #[test]
    fn a_force_below_the_threshold_is_no_contact() {
        let mut m = measured(0.0, 1);
        m.force_n.iter_mut().for_each(|f| *f = BASE.value + 0.1 * (*f - BASE.value));
        assert_eq!(contact(&m), None);
        assert_eq!(cycles(&m).unwrap().len(), 1);
    }

    #[test]
    fn a_spike_is_no_contact() {
        let mut m = measured(0.0, 1);
        m.force_n[3] = 5e-3;
        let time = contact(&m).unwrap().time_s;
        assert!(time > 0.15, "{time}");
    }
}
