//! Derivatives of the force by the material's parameters while effects act.

use super::{GAP, RAMP, SEEPING, parameters, position};
use poropunch::law::MaterialParameter;
use poropunch::{ForceSensitivity, Instance, Model, Parameters};

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
        instance.set_displacement(position(time));
        instance.advance(time - instance.time()).unwrap();
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
