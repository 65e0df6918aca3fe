//! Known noise is recovered, and the stated uncertainty is that of repeated estimates.

use super::*;
use crate::data::random::Random;

/// Stretches of `n` samples at uneven times, each with an offset and a drift of its own.
fn records(
    white: f64,
    correlated: f64,
    tau: f64,
    (count, n): (usize, usize),
    random: &mut Random,
) -> Vec<Record> {
    let one = |k: usize| {
        let mut r = Record::default();
        let (mut t, mut c) = (100.0 * k as f64, correlated * random.normal());
        for _ in 0..n {
            let step = if random.uniform() < 0.7 { 0.05 } else { 0.2 + random.uniform() };
            let kept = (-step / tau).exp();
            c = kept * c + correlated * (1.0 - kept * kept).sqrt() * random.normal();
            t += step;
            r.time_s.push(t);
            r.values.push(5.0 * k as f64 + 0.02 * (k % 3) as f64 * t + c + white * random.normal());
        }
        r
    };
    (0..count).map(one).collect()
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|z| z * z).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn white_and_correlated_parts_are_recovered_within_their_uncertainty() {
    let mut scores: [Vec<f64>; 3] = Default::default();
    for seed in 0..40 {
        let found = noise_parts(&records(0.07, 0.05, 2.0, (12, 150), &mut Random::new(seed))).unwrap();
        let c = found.correlated.expect("a correlated part");
        scores[0].push((found.white.value - 0.07) / found.white.sigma);
        // Positive quantities: their logarithms are nearer to normal.
        scores[1].push((c.amplitude.value / 0.05).ln() * c.amplitude.value / c.amplitude.sigma);
        scores[2].push((c.time_s.value / 2.0).ln() * c.time_s.value / c.time_s.sigma);
        assert!(c.amplitude.sigma < 0.01 && c.time_s.sigma < 2.5, "{found:?}");
        assert!(found.correlated_below > c.amplitude.value && found.outliers < 5, "{found:?}");
    }
    for (z, what) in scores.iter().zip(["white", "amplitude", "time"]) {
        assert!((0.7..1.35).contains(&rms(z)), "{what}: {}", rms(z));
        assert!(z.iter().all(|z| z.abs() < 4.5), "{what}: {z:?}");
    }
}

#[test]
fn white_noise_alone_is_told_so() {
    let (mut false_alarms, mut score, mut useful) = (0, vec![], 0);
    for seed in 0..60 {
        let found = noise_parts(&records(0.07, 0.0, 1.0, (6, 100), &mut Random::new(1000 + seed))).unwrap();
        false_alarms += usize::from(found.correlated.is_some());
        useful += usize::from(found.correlated_below < 0.05);
        score.push((found.white.value - 0.07) / found.white.sigma);
    }
    assert!(false_alarms <= 2, "{false_alarms}");
    // 600 samples must exclude a correlated part as large as the white one.
    assert!(useful >= 57, "{useful}");
    assert!((0.75..1.3).contains(&rms(&score)), "{}", rms(&score));
}

#[test]
fn a_correlated_part_too_small_to_see_is_below_its_limit() {
    let limits = (0..60).map(|seed| {
        noise_parts(&records(0.07, 0.02, 2.0, (6, 100), &mut Random::new(2000 + seed)))
            .unwrap()
            .correlated_below
    });
    let above = limits.filter(|l| *l > 0.02).count();
    assert!(above >= 55, "{above}");
}

#[test]
fn outliers_do_not_count() {
    let mut noisy = records(0.07, 0.0, 1.0, (6, 100), &mut Random::new(3));
    for r in &mut noisy {
        r.values[17] += 40.0;
    }
    let found = noise_parts(&noisy).unwrap();
    assert_eq!(found.outliers, 6);
    assert!((found.white.value - 0.07).abs() < 4.0 * found.white.sigma, "{found:?}");
}

#[test]
fn autocorrelation_falls_exponentially_from_the_correlated_share() {
    let noise = records(0.05, 0.05, 0.5, (60, 300), &mut Random::new(5));
    let bins = autocorrelation(&noise, 20);
    assert!(bins.len() > 10);
    for b in bins.iter().filter(|b| b.lag_s < 2.0) {
        let expected = 0.5 * (-b.lag_s / 0.5).exp();
        assert!((b.correlation - expected).abs() < 0.05, "{b:?} {expected}");
    }
}

#[test]
fn autocorrelation_of_independent_samples_is_zero_at_every_lag() {
    let bins = autocorrelation(&records(0.07, 0.0, 1.0, (100, 40), &mut Random::new(8)), 20);
    let normalised: Vec<f64> = bins.iter().map(|b| b.correlation * (b.pairs as f64).sqrt()).collect();
    assert!(bins.len() > 10 && (0.6..1.4).contains(&rms(&normalised)), "{normalised:?}");
}

#[test]
fn long_records_are_thinned_and_still_tell_both_parts() {
    let mut random = Random::new(11);
    let noise = records(0.07, 0.05, 2.0, (4, 60_000), &mut random);
    let found = noise_parts(&noise).unwrap();
    assert!(found.samples <= MOST_SAMPLES && found.samples > MOST_SAMPLES / 2, "{found:?}");
    let c = found.correlated.expect("a correlated part");
    for (estimate, truth) in [(found.white, 0.07), (c.amplitude, 0.05), (c.time_s, 2.0)] {
        assert!((estimate.value - truth).abs() < 4.0 * estimate.sigma, "{truth} {found:?}");
        assert!(estimate.sigma < 0.1 * truth, "{truth} {found:?}");
    }
    assert!(autocorrelation(&noise, 20).len() > 10);
}

#[test]
fn too_few_samples_tell_nothing() {
    assert_eq!(noise_parts(&records(0.1, 0.0, 1.0, (2, 5), &mut Random::new(1))), None);
}
