//! Strokes of the paper's protocols are found at their true times under noise and uneven sampling.

use super::*;
use crate::data::random::Random;

/// Corners of two cycles like the paper's P1 (s, m).
pub const CORNERS: [(f64, f64); 11] = [
    (0.0, -1e-4),
    (1.1, 1e-3),
    (91.1, 1e-3),
    (95.9, -3.8e-3),
    (155.9, -3.8e-3),
    (159.6, -1e-4),
    (219.6, -1e-4),
    (220.7, 1e-3),
    (310.7, 1e-3),
    (315.5, -3.8e-3),
    (375.5, -3.8e-3),
];

fn displacement(t: f64) -> f64 {
    let k = CORNERS.partition_point(|c| c.0 < t).clamp(1, CORNERS.len() - 1);
    let (a, b) = (CORNERS[k - 1], CORNERS[k]);
    a.1 + (b.1 - a.1) * (t - a.0) / (b.0 - a.0)
}

/// Dense while the punch moves, sparse while it rests, every distance different.
fn samples(random: &mut Random, noise_m: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut time, mut t) = (vec![], 0.0);
    while t < 375.5 {
        time.push(t);
        let moving = CORNERS.windows(2).any(|c| c[0].1 != c[1].1 && t >= c[0].0 - 1.2 && t < c[1].0 + 0.1);
        t += if moving { 0.01 + 0.01 * random.uniform() } else { 0.3 + 0.6 * random.uniform() };
    }
    let d = time.iter().map(|&t| displacement(t) + noise_m * random.normal()).collect();
    (time, d)
}

#[test]
fn strokes_are_found_at_their_times_in_noise() {
    for seed in 0..10 {
        let (time, d) = samples(&mut Random::new(seed), 1e-6);
        let motion = motion(&time, &d);
        assert!((motion.noise_m / 1e-6 - 1.0).abs() < 0.15, "{}", motion.noise_m);
        let expected: Vec<_> = CORNERS.windows(2).filter(|c| c[0].1 != c[1].1).collect();
        assert_eq!(motion.strokes.len(), expected.len(), "seed {seed}");
        for (stroke, corners) in motion.strokes.iter().zip(expected) {
            // Four standard deviations of a kink between a line and a level at 1 mm/s.
            assert!((stroke.start_s - corners[0].0).abs() < 4e-3, "{seed}: {stroke:?} {corners:?}");
            assert!((stroke.end_s - corners[1].0).abs() < 4e-3, "{seed}: {stroke:?} {corners:?}");
            let rate = (corners[1].1 - corners[0].1) / (corners[1].0 - corners[0].0);
            let off = stroke.line.rate_m_per_s - rate;
            assert!(off.abs() < 4.5 * stroke.line.rate_sigma_m_per_s, "{seed}: {stroke:?} {rate}");
        }
    }
}

#[test]
fn the_lines_uncertainty_is_what_it_says() {
    let mut normalised = vec![];
    for seed in 0..200 {
        let mut random = Random::new(seed);
        let time: Vec<f64> = (0..110).map(|i| 0.02 * f64::from(i)).collect();
        let d: Vec<f64> = time.iter().map(|&t| (t - 0.1).min(1.0) * 1e-3 + 1e-6 * random.normal()).collect();
        let line = motion(&time, &d).strokes[0].line;
        normalised.push((line.time_at(5e-4) - 0.6) / line.time_sigma_at(5e-4));
    }
    let rms = (normalised.iter().map(|z| z * z).sum::<f64>() / 200.0).sqrt();
    assert!((0.8..1.25).contains(&rms), "{rms}");
}

#[test]
fn overshoot_and_settling_belong_to_the_hold() {
    let corners = [(0.0, -1e-4), (1.1, 1.03e-3), (1.2, 0.995e-3), (1.4, 1e-3), (20.0, 1e-3), (21.0, 0.0)];
    let at = |t: f64| {
        let k = corners.partition_point(|c: &(f64, f64)| c.0 < t).clamp(1, corners.len() - 1);
        let (a, b) = (corners[k - 1], corners[k]);
        a.1 + (b.1 - a.1) * (t - a.0) / (b.0 - a.0)
    };
    let time: Vec<f64> = (0..2100).map(|i| 0.01 * f64::from(i)).collect();
    let d: Vec<f64> = time.iter().map(|&t| at(t)).collect();
    let strokes = motion(&time, &d).strokes;
    assert_eq!(strokes.len(), 2, "{strokes:?}");
    assert!((strokes[0].end_s - 1.1).abs() < 0.05 && (strokes[1].start_s - 20.0).abs() < 0.02, "{strokes:?}");
}

#[test]
fn single_intervals_are_strokes_too() {
    let strokes = motion(&[0.0, 1.0, 2.0, 9.0, 10.0, 11.0], &[-1e-3, 0.0, 1e-3, 1e-3, 1e-3, -1e-3]).strokes;
    assert_eq!(strokes.len(), 2);
    assert_eq!((strokes[0].start_s, strokes[0].end_s), (0.0, 2.0));
    assert_eq!((strokes[1].start_s, strokes[1].end_s), (10.0, 11.0));
}
