//! Communication steps, saving and restoring, bad input.

use poropunch::{Instance, Model, StepError};
use tests::{DEPTH, check_restored, coarse, move_to};

fn model() -> Model {
    Model::new(coarse()).unwrap()
}

/// Forces at 0.625 s and 20.625 s of P2 when a master slices time into `slices` per phase.
fn sliced(model: &Model, slices: usize) -> [f64; 2] {
    let mut instance = Instance::new(model, 0.0).unwrap();
    let mut forces = [0.0; 2];
    for (phase, (duration, from, to)) in [(0.625, 0.0, DEPTH), (20.0, DEPTH, DEPTH)].into_iter().enumerate() {
        for k in 1..=slices {
            move_to(&mut instance, from + (to - from) * k as f64 / slices as f64, duration / slices as f64);
        }
        forces[phase] = instance.outputs().force;
    }
    forces
}

/// Goal: the force does not depend on how a master slices time.
/// Set-up: P2 in 1, 7 and 1000 communication steps per phase. Tolerance: 0.1 % (observed: none).
#[test]
fn communication_steps_do_not_matter() {
    let model = model();
    let one = sliced(&model, 1);
    for slices in [7, 1000] {
        for (a, b) in one.iter().zip(sliced(&model, slices)) {
            approx::assert_relative_eq!(*a, b, max_relative = 1e-3);
        }
    }
}

/// Goal: interpolation between steps is as good as the steps. Set-up: P2's hold sampled at 50 times
/// against a run with a hundredfold tighter tolerance. Tolerance: 0.2 %.
#[test]
fn dense_output_is_accurate() {
    let model = model();
    let mut tight = model.parameters().clone();
    tight.solver.tolerance = 1e-5;
    let curve = |model: &Model| -> Vec<f64> {
        let mut instance = Instance::new(model, 0.0).unwrap();
        move_to(&mut instance, DEPTH, 0.625);
        (0..50)
            .map(|k| {
                instance.advance(0.02 * 1.15_f64.powi(k)).unwrap();
                instance.outputs().force
            })
            .collect()
    };
    for (k, (a, b)) in curve(&model).iter().zip(curve(&Model::new(tight).unwrap())).enumerate() {
        assert!((a / b - 1.0).abs() < 2e-3, "sample {k}: {a} against {b}");
    }
}

/// Goal: saving and restoring is bit-identical, in the same and in another instance, in the middle of a
/// step that was integrated ahead.
#[test]
fn restored_runs_are_bit_identical() {
    check_restored(&model(), [-1e-4, 0.0], |o| vec![o.force, o.force_fluid, o.stored_energy]);
}

/// Goal: above the surface there is no force; touch happens at zero displacement inside a step.
#[test]
fn starts_above_the_surface() {
    let model = model();
    let mut gap = Instance::new(&model, -1e-4).unwrap();
    move_to(&mut gap, -5e-5, 0.05);
    assert_eq!(gap.outputs().force, 0.0);
    move_to(&mut gap, 2e-4, 0.25);
    let mut touching = Instance::new(&model, 0.0).unwrap();
    move_to(&mut touching, 2e-4, 0.2);
    approx::assert_relative_eq!(gap.outputs().force, touching.outputs().force, max_relative = 1e-9);
}

/// Goal: what cannot be simulated is an error with a reason, and the instance stays usable.
#[test]
fn errors_leave_the_instance_usable() {
    let model = model();
    let mut instance = Instance::new(&model, 0.0).unwrap();
    move_to(&mut instance, 1e-4, 0.1);
    let before = instance.save();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(instance.advance(bad), Err(StepError::BadDuration(_))));
    }
    instance.set_displacement(f64::NAN);
    assert!(matches!(instance.advance(0.1), Err(StepError::BadDisplacement(_))));
    instance.set_displacement(0.02);
    assert!(matches!(instance.advance(0.1), Err(StepError::TooDeep { .. })));
    instance.restore(&before).unwrap();
    move_to(&mut instance, 2e-4, 0.1);
    assert!(instance.outputs().force > 0.0);
    assert!(matches!(Instance::new(&model, 1e-6), Err(StepError::StartsInside(_))));
}

/// Goal: a punch that arrives at the surface at the very end of a communication step, within rounding on either side, goes on like
/// one that starts there. Set-up: Table 1, coarse mesh, 1 mm/s from 20 um above. Tolerance: 1e-9; when the touch was taken
/// to be behind the punch, the next step ran at twice the speed and the force was 20 % too high.
#[test]
fn a_touch_at_a_communication_point() {
    let model = model();
    let force = |start: f64, stops: &[f64]| {
        let mut instance = Instance::new(&model, start).unwrap();
        let mut from = start;
        for &to in stops {
            move_to(&mut instance, to, (to - from) / 1e-3);
            from = to;
        }
        instance.outputs().force
    };
    let expected = force(0.0, &[2e-5]);
    for rounding in [-1e-21, 0.0, 1e-22, 1e-21, 1e-20] {
        let found = force(-2e-5, &[rounding, 2e-5]);
        approx::assert_relative_eq!(found, expected, max_relative = 1e-9);
    }
}
