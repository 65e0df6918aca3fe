//! Derivatives of the force by the material's parameters while effects act, and by the magnitudes of the load cell's.

use super::{GAP, RAMP, SEEPING, parameters, position};
use poropunch::law::{Magnitude, MaterialParameter};
use poropunch::{ForceSensitivity, Instance, Model, Parameters};
use tests::arrive;

const TIMES: [f64; 6] = [0.2, 0.5, RAMP, RAMP + 0.05, RAMP + 1.0, RAMP + 20.0];

fn fixed_steps(effects: &[(&str, f64)]) -> Parameters {
    let values: Vec<_> = SEEPING.iter().chain(effects).copied().collect();
    let mut p = parameters(&values);
    // Step sizes that depend on nothing: the tolerance is never felt.
    p.solver.tolerance = 1.0;
    p.solver.initial_increment = 2e-5;
    p.solver.max_step = 4.0;
    p.solver.newton_tolerance = 1e-12;
    p
}

/// What is read, the specimen's force and its fluid part (N), and their derivatives, at all times.
fn cycle(p: &Parameters) -> Vec<([f64; 3], Vec<ForceSensitivity>)> {
    let mut instance = Instance::new(&Model::new(p.clone()).unwrap(), -GAP).unwrap();
    let advance = |time: f64| {
        arrive(&mut instance, position(time), time);
        let o = instance.outputs();
        ([o.force, o.force_specimen, o.force_fluid], instance.sensitivities())
    };
    TIMES.into_iter().map(advance).collect()
}

/// Relative changes by fourth-order central differences of both forces by the parameters (name in Table 1's
/// order of indices, as the sensitivities).
fn check(effects: &[(&str, f64)], tolerance: f64) {
    const STEP: f64 = 2e-3;
    let mut p = fixed_steps(effects);
    p.solver.sensitivities = true;
    let exact = cycle(&p);
    p.solver.sensitivities = false;
    // One parameter of every law: seepage, volume, springs, dashpots.
    type Field = fn(&mut Parameters) -> &mut f64;
    let chosen: [(usize, Field); 6] = [
        (MaterialParameter::SolidFraction.index(), |p| &mut p.material.n0s),
        (MaterialParameter::LambdaStar.index(), |p| &mut p.material.lambda_star),
        (MaterialParameter::Permeability.index(), |p| &mut p.material.permeability),
        (4, |p| &mut p.material.equilibrium.mu),
        (7, |p| &mut p.material.branches[0].ogden.alpha),
        (MaterialParameter::Eta(1).index(), |p| &mut p.material.branches[1].eta),
    ];
    for (index, field) in chosen {
        let start = *field(&mut p.clone());
        let runs = [-2.0, -1.0, 1.0, 2.0].map(|steps| {
            let mut moved = p.clone();
            *field(&mut moved) = start * (1.0 + STEP * steps);
            cycle(&moved)
        });
        for part in 0..3 {
            let numeric: Vec<f64> = (0..TIMES.len())
                .map(|k| {
                    let f = |run: usize| runs[run][k].0[part];
                    (f(0) - 8.0 * f(1) + 8.0 * f(2) - f(3)) / (12.0 * STEP * start)
                })
                .collect();
            let largest = numeric.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
            for (k, numeric) in numeric.iter().enumerate() {
                let s = exact[k].1[index];
                let analytic = [s.force, s.specimen, s.fluid][part];
                let error = (analytic - numeric).abs() / largest;
                assert!(
                    error < tolerance,
                    "{effects:?}, parameter {index}, part {part}, {} s: {analytic:e} {numeric:e}",
                    TIMES[k]
                );
            }
        }
    }
}

/// Goal: with effects inside the specimen and under the punch the derivatives are exact along P2's ramp, kink
/// and hold. Set-up: coarse mesh, fixed steps, Newton to 1e-12, a skeleton that seeps. Reference: central
/// differences of fourth order. Tolerance: 2e-5 of the largest value along the curve.
#[test]
fn with_effects_of_specimen_and_contact() {
    check(
        &[
            ("effect.eyring.inverse_stress", 5e-3),
            ("effect.permeability.exponent", 5.0),
            ("effect.modulus_drift.rate", 1e-2),
            ("effect.amplitude.log_factor", 0.3),
            ("effect.slip.compliance", 1e-6),
            ("effect.offset.height", 2e-5),
        ],
        2e-5,
    );
}

/// Goal: the same while the skeleton softens with past strain, beside a branch that flows.
/// Tolerance: 2e-3, of the reference: points whose strain turns during the hold do so at other times as the
/// parameter moves, and the largest strain has a kink there.
#[test]
#[ignore = "long: 24 runs"]
fn with_softening() {
    let softening = [("effect.softening.loss", 0.4), ("effect.softening.strain", 0.1)];
    check(&softening, 2e-3);
    check(&[softening[0], softening[1], ("effect.softening.delay", 0.3)], 2e-3);
}

/// Goal: the same with a compliant machine and the load cell's effects.
#[test]
fn with_effects_of_machine_and_sensor() {
    check(
        &[
            ("effect.compliance.per_newton", 2e-2),
            ("effect.load_cell_drift.rate", 1e-5),
            ("effect.load_cell_lag.time", 0.05),
        ],
        2e-5,
    );
}

/// What is read (N) and its derivatives by the load cell's drift and lag at all times, from before contact on.
fn reading(p: &Parameters) -> Vec<(f64, f64, [f64; 2])> {
    let mut instance = Instance::new(&Model::new(p.clone()).unwrap(), -GAP).unwrap();
    let count = MaterialParameter::count(2);
    let advance = |time: f64| {
        arrive(&mut instance, position(time), time);
        let s = instance.sensitivities();
        let by = |magnitude: Magnitude| s.get(count + magnitude.index()).map_or(0.0, |s| s.force);
        (time, instance.outputs().force, [by(Magnitude::DriftRate), by(Magnitude::Lag)])
    };
    [0.03].into_iter().chain(TIMES).map(advance).collect()
}

/// Goal: the derivatives by drift and lag of the load cell are exact, before contact, along P2's ramp, kink and hold, also where
/// there is no lag. Set-up: coarse mesh, fixed steps. Reference: by the drift, which acts in proportion, the difference of two
/// runs; by the lag central differences of fourth order, from null forward ones of second order with 1 and 2 us. Tolerance:
/// 1e-7 of the largest value along the curve, from null 1e-5, of the reference.
#[test]
fn by_the_load_cells_drift_and_lag() {
    for (lag, step, tolerance) in [(0.05, 1e-4, 1e-7), (0.0, 1e-6, 1e-5)] {
        let mut p = fixed_steps(&[("effect.load_cell_drift.rate", 1e-5), ("effect.load_cell_lag.time", lag)]);
        (p.solver.sensitivities, p.solver.effect_sensitivities) = (true, true);
        let exact = reading(&p);
        (p.solver.sensitivities, p.solver.effect_sensitivities) = (false, false);
        let mut drifting = p.clone();
        drifting.effect.load_cell_drift.rate = 2e-5;
        let moved = |steps: f64| {
            let mut moved = p.clone();
            moved.effect.load_cell_lag.time = lag + steps * step;
            reading(&moved)
        };
        let (weights, divisor): (&[(f64, f64)], f64) = if lag > 0.0 {
            (&[(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)], 12.0)
        } else {
            (&[(0.0, -3.0), (1.0, 4.0), (2.0, -1.0)], 2.0)
        };
        let runs: Vec<_> = weights.iter().map(|&(steps, weight)| (weight, moved(steps))).collect();
        let slope =
            |k: usize| runs.iter().map(|(weight, run)| weight * run[k].1).sum::<f64>() / (divisor * step);
        let largest = (0..exact.len()).fold(0.0_f64, |m, k| m.max(slope(k).abs()));
        for (k, ((time, force, [by_drift, by_lag]), (_, drifted, _))) in
            exact.iter().zip(reading(&drifting)).enumerate()
        {
            approx::assert_relative_eq!(*by_drift, (drifted - force) / 1e-5, max_relative = 1e-9);
            let error = (by_lag - slope(k)).abs() / largest;
            assert!(error < tolerance, "lag {lag} s at {time} s: {by_lag:e} {:e} {error:.1e}", slope(k));
        }
        assert_eq!(exact[0].2[1], 0.0, "before contact nothing lags");
    }
}

/// Goal: derivatives by the magnitudes of the specimen lag as the force does. Set-up: a lag of 0.05 s and a compliant machine,
/// as the test of the material's. Reference: central differences of fourth order. Tolerance: 2e-5 of the largest value.
#[test]
fn a_lag_filters_the_derivatives_by_magnitudes() {
    let mut p = fixed_steps(&[("effect.compliance.per_newton", 2e-2), ("effect.load_cell_lag.time", 0.05)]);
    (p.solver.sensitivities, p.solver.effect_sensitivities) = (true, true);
    let exact = cycle(&p);
    (p.solver.sensitivities, p.solver.effect_sensitivities) = (false, false);
    type Field = fn(&mut Parameters) -> &mut f64;
    let chosen: [(Magnitude, Field, f64); 2] = [
        (Magnitude::MachineCompliance, |p| &mut p.effect.compliance.per_newton, 2e-5),
        (Magnitude::Amplitude, |p| &mut p.effect.amplitude.log_factor, 1e-3),
    ];
    for (magnitude, field, step) in chosen {
        let runs = [-2.0, -1.0, 1.0, 2.0].map(|steps| {
            let mut moved = p.clone();
            *field(&mut moved) += steps * step;
            cycle(&moved)
        });
        let f = |run: usize, k: usize| runs[run][k].0[0];
        let slope = |k: usize| (f(0, k) - 8.0 * f(1, k) + 8.0 * f(2, k) - f(3, k)) / (12.0 * step);
        let largest = (0..TIMES.len()).fold(0.0_f64, |m, k| m.max(slope(k).abs()));
        for (k, (_, derivatives)) in exact.iter().enumerate() {
            let s = derivatives[MaterialParameter::count(2) + magnitude.index()];
            let error = (s.force - slope(k)).abs() / largest;
            assert!(error < 2e-5, "{magnitude:?} at {} s: {error:.1e}", TIMES[k]);
        }
    }
}
