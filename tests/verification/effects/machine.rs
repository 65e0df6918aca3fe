//! Compliance of the machine.

use super::{GAP, RAMP, RATE, curve, curve_at, parameters, position};
use poropunch::{Instance, Model};
use tests::{arrive, move_to};

const COMPLIANCE: f64 = 2e-2;

/// Goal: the punch is where crosshead and force say, at every moment. Set-up: P2 with 0.02 mm/mN. Reference:
/// `indentation = displacement - C force`; and the plain model led along that very path, sampled so densely
/// that it is the same: its force must be that of the compliant machine. Tolerance: 1e-3 of the peak.
#[test]
fn plain_model_on_the_compliant_path() {
    let p = parameters(&[("effect.compliance.per_newton", COMPLIANCE), ("solver.tolerance", 3e-5)]);
    let times: Vec<f64> = (1..=120)
        .map(|k| GAP / RATE + (RAMP - GAP / RATE) * f64::from(k) / 120.0)
        .chain((0..100).map(|k| RAMP + 0.01 * 1.07_f64.powi(k)))
        .collect();
    let compliant = curve_at(&p, &times);
    let peak = compliant.iter().fold(0.0_f64, |m, o| m.max(o.force));
    let mut plain =
        Instance::new(&Model::new(parameters(&[("solver.tolerance", 3e-5)])).unwrap(), -GAP).unwrap();
    move_to(&mut plain, 0.0, GAP / RATE);
    for (time, o) in times.iter().zip(&compliant) {
        assert_eq!(o.displacement, position(*time));
        assert!((o.indentation - (o.displacement - COMPLIANCE * o.force)).abs() < 1e-15);
        arrive(&mut plain, o.indentation, *time);
        let error = (plain.outputs().force - o.force).abs();
        assert!(error < 1e-3 * peak, "{time} s: {} against {}", plain.outputs().force, o.force);
    }
    // The compliance is felt: a fifth of the depth at the peak.
    let plain = curve(&parameters(&[]));
    assert!(peak < 0.9 * plain[3].force, "{peak}");
}

/// Goal: work of the crosshead less the machine's own energy is what the sample stores and dissipates.
/// Tolerance: 0.2 % of the work, as for the rigid machine.
#[test]
fn work_is_stored_or_dissipated() {
    for o in
        &curve(&parameters(&[("effect.compliance.per_newton", COMPLIANCE), ("solver.tolerance", 1e-5)]))[1..]
    {
        let spent = o.stored_energy + o.viscous_dissipation + o.porous_dissipation;
        approx::assert_relative_eq!(o.external_work, spent, max_relative = 2e-3);
    }
}

/// Goal: an infinitely compliant machine presses with a force that its crosshead sets, `F = u / C`.
/// Set-up: C = 1 m/N and 10 mm of crosshead: 10 mN less `indentation / C`. Tolerance: 1e-8.
#[test]
fn a_soft_machine_sets_the_force() {
    let p = parameters(&[("effect.compliance.per_newton", 1.0)]);
    let mut instance = Instance::new(&Model::new(p).unwrap(), 0.0).unwrap();
    move_to(&mut instance, 9e-3, 1.0);
    let mut depth = 0.0;
    for _ in 0..10 {
        instance.advance(3.0).unwrap();
        let o = instance.outputs();
        approx::assert_relative_eq!(o.force, 9e-3 - o.indentation, max_relative = 1e-8);
        assert!(o.indentation > depth, "it creeps: {} m", o.indentation);
        depth = o.indentation;
    }
}
