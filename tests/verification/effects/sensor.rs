//! Effects of the load cell.

use super::{DEPTH, GAP, RAMP, curve, curve_at, parameters};
use poropunch::{Instance, Model, Outputs};

/// Goal: the zero drifts from the test's start, in air too, and nothing else changes. Tolerance: rounding.
#[test]
fn drift_adds_to_the_reading() {
    let plain = curve(&parameters(&[]));
    for (time, (a, b)) in super::TIMES
        .iter()
        .zip(curve(&parameters(&[("effect.load_cell_drift.rate", -2e-5)])).iter().zip(&plain))
    {
        assert_eq!(a.force, b.force - 2e-5 * time);
        let unread = |o: &Outputs| Outputs { force: 0.0, ..*o };
        assert_eq!(unread(a), unread(b));
        assert_eq!(a.force_solid + a.force_fluid, a.force_specimen);
    }
    assert_eq!(plain[0].force, 0.0, "the first time is in air");
}

/// Goal: `T dy/dt = F - y`. Set-up: P2, T = 5, 50 and 500 ms. Reference: the plain force, sampled every 0.5 ms
/// around the peak and every 20 ms later, filtered by the exact solution for a force that is linear between
/// samples. Tolerance: 3e-4 of the peak, of the interpolation between the model's steps.
#[test]
fn lag_is_a_low_pass() {
    let times: Vec<f64> = (1..=4000)
        .map(|k| 5e-4 * f64::from(k))
        .chain((1..=400).map(|k| 2.0 + 0.02 * f64::from(k)))
        .filter(|&t| (t - RAMP).abs() > 1e-9)
        .collect();
    let plain = curve_at(&parameters(&[]), &times);
    let peak = plain.iter().fold(0.0_f64, |m, o| m.max(o.force));
    for lag in [5e-3, 0.05, 0.5] {
        let lagging = curve_at(&parameters(&[("effect.load_cell_lag.time", lag)]), &times);
        let (mut y, mut before, mut since) = (0.0, 0.0, 0.0);
        let mut largest = 0.0_f64;
        for ((time, o), reading) in times.iter().zip(&plain).zip(&lagging) {
            let (length, slope) = (time - since, (o.force - before) / (time - since));
            let decay = (-length / lag).exp();
            // Particular solution of a linear force: it runs behind by slope T.
            y = decay * (y - before + slope * lag) + o.force - slope * lag;
            (before, since) = (o.force, *time);
            assert!((reading.force - y).abs() < 3e-4 * peak, "T = {lag} s, {time} s: {} {y}", reading.force);
            assert_eq!(reading.force_specimen, o.force);
            let parts = reading.force_solid + reading.force_fluid;
            assert!((parts - reading.force_specimen).abs() <= 1e-15 * peak, "{parts}");
            largest = largest.max((y - o.force).abs());
        }
        assert!(largest > 20.0 * 3e-4 * peak, "T = {lag} s is not felt: {largest}");
    }
}

/// Goal: the reading does not depend on when it is asked for. Set-up: after the first 10 ms the hold in one
/// step and in 290. Tolerance: 1e-12.
#[test]
fn lag_does_not_know_the_master() {
    let model = Model::new(parameters(&[("effect.load_cell_lag.time", 0.1)])).unwrap();
    let held = |slices: u32| {
        let mut instance = Instance::new(&model, -GAP).unwrap();
        instance.set_displacement(DEPTH);
        for duration in [RAMP, 0.01] {
            instance.advance(duration).unwrap();
        }
        for _ in 0..slices {
            instance.advance(0.29 / f64::from(slices)).unwrap();
        }
        instance.outputs().force
    };
    approx::assert_relative_eq!(held(1), held(290), max_relative = 1e-12);
}

/// Goal: the paper's read-out. Tolerance: none.
#[test]
fn traction_is_read_out() {
    for (a, b) in
        curve(&parameters(&[("effect.discretisation.traction", 1.0)])).iter().zip(curve(&parameters(&[])))
    {
        assert_eq!(a.force, b.force_traction);
        assert_eq!(a.force_specimen, b.force);
    }
}
