//! Specimens with shifted clocks, other sampling and noise come back onto one curve.

use super::*;
use crate::data::random::Random;

const RAMP_END: f64 = 1.1;

/// Force (N) and displacement (m) at a time: linear rise, then fast and slow relaxation.
fn truth(t: f64) -> (f64, f64) {
    let d = 1e-3 * (t - 0.1).min(1.0);
    let force = |d: f64| 10.0 * d.max(0.0);
    let since = t - RAMP_END;
    (
        d,
        if since <= 0.0 {
            force(d)
        } else {
            force(1e-3) * (0.5 + 0.2 * (-since / 0.05).exp() + 0.3 * (-since).exp())
        },
    )
}

/// A specimen that started `late` seconds later than the others, sampled every `step` with jitter.
fn specimen(late: f64, step: f64, factor: f64, noise_m: f64, random: &mut Random) -> Measurement {
    let mut m = Measurement { file: format!("{late}.csv").into(), ..Measurement::default() };
    let mut t = 0.02 * random.uniform();
    while t < 6.0 {
        let (d, f) = truth(t);
        m.time_s.push(t - late);
        m.displacement_m.push(d + noise_m * random.normal());
        m.force_n.push(factor * f);
        t += step * (0.8 + 0.4 * random.uniform());
    }
    m
}

#[test]
fn shifts_are_recovered_within_their_uncertainty() {
    let mut normalised = vec![];
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let late = [0.0, 0.731, -0.377, 1.9];
        let specimens = late.map(|l| specimen(l, 0.02, 1.0, 1e-6, &mut random)).to_vec();
        let found = synchronise("P", specimens).unwrap();
        for (shift, late) in found.shifts_s.iter().zip(late).skip(1) {
            assert!(shift.sigma < 1e-3, "{shift:?}");
            normalised.push((shift.value - late) / shift.sigma);
        }
    }
    let rms = (normalised.iter().map(|z| z * z).sum::<f64>() / normalised.len() as f64).sqrt();
    assert!((0.75..1.3).contains(&rms), "{rms}");
}

#[test]
fn median_and_quartiles_of_resampled_specimens_are_those_of_the_true_curves() {
    let mut random = Random::new(3);
    // Factors whose median is 1 and whose quartiles are 0.9 and 1.1.
    let factors = [1.0, 0.8, 0.9, 1.1, 1.2];
    let late = [0.0, 0.5, -0.3, 0.111, 0.05];
    let specimens = (0..5).map(|k| specimen(late[k], 0.02, factors[k], 0.0, &mut random)).collect();
    let found = synchronise("P", specimens).unwrap();
    let m = &found.measurement;
    assert_eq!((m.name.as_str(), m.specimens_n.len(), m.specimen_names.len()), ("P", 5, 5));
    let quartiles = m.quartiles_n.as_ref().unwrap();
    for (i, &t) in m.time_s.iter().enumerate() {
        let (d, f) = truth(t);
        assert!((m.displacement_m[i] - d).abs() < 2e-6, "{t}");
        // Chords: of the kink at first touch, and of a fall by a fifth of the peak within two samples.
        let within = match t {
            t if (0.08..0.12).contains(&t) => 6e-5,
            t if (1.1..1.5).contains(&t) => 40e-5,
            _ => 2e-5,
        };
        assert!((m.force_n[i] - f).abs() < within, "{t}: {} {f}", m.force_n[i]);
        assert!(
            (quartiles[i].0 - 0.9 * f).abs() < within && (quartiles[i].1 - 1.1 * f).abs() < within,
            "{t}"
        );
    }
}

#[test]
fn the_peak_is_not_cut_off() {
    let mut random = Random::new(9);
    let specimens: Vec<_> =
        (0..7).map(|k| specimen(0.13 * f64::from(k), 0.02, 1.0, 0.0, &mut random)).collect();
    let m = synchronise("P", specimens).unwrap().measurement;
    let last = m.time_s.iter().rposition(|&t| t <= RAMP_END).unwrap();
    for specimen in &m.specimens_n {
        assert!(
            (specimen[last] - truth(m.time_s[last]).1).abs() < 2e-5,
            "{} {}",
            m.time_s[last],
            specimen[last]
        );
    }
}

#[test]
fn other_ramps_and_other_times_are_refused() {
    let mut random = Random::new(1);
    let first = specimen(0.0, 0.02, 1.0, 0.0, &mut random);
    let mut fast = specimen(0.1, 0.02, 1.0, 0.0, &mut random);
    fast.time_s.iter_mut().for_each(|t| *t /= 1.6);
    let error = synchronise("P", vec![first.clone(), fast]).unwrap_err();
    assert!(matches!(error.problem, Problem::RampsDiffer { .. }), "{error}");
    assert!(error.to_string().contains("0.1.csv") && error.to_string().contains("1.600 mm/s"), "{error}");
    let mut deep = first.clone();
    deep.displacement_m.iter_mut().for_each(|d| *d *= 1.3);
    assert!(synchronise("P", vec![first.clone(), deep]).is_err());
    let mut late = first.clone();
    late.time_s.iter_mut().for_each(|t| *t += 1e4);
    // Only the clock differs: that is what synchronisation is for.
    assert!(synchronise("P", vec![first, late]).is_ok());
}
