//! Effects between specimen and punch or support.

use super::{DEPTH, GAP, RAMP, RATE, curve, parameters};
use poropunch::mesh::Mesh;
use poropunch::motion::protocol::Trapezoid;
use poropunch::parameters::{BoundaryParameters, GeometryParameters};
use poropunch::specimen::{Discretisation, Sample, Stepper};
use poropunch::{Instance, Model, Parameters, StepError};
use std::f64::consts::PI;
use std::sync::Arc;
use tests::poroelastic;
use tests::{analytical::consolidation::Ramp, arrive, move_to};

/// Goal: the shear layer leads from the bonded to the frictionless punch. Set-up: P2, compliances from 1e-12 to
/// 1 m/Pa. Reference: the two switches. Tolerance: 1e-5 at the ends, falling strictly between them.
#[test]
fn slip_leads_from_bonded_to_frictionless() {
    let peak = |values: &[(&str, f64)]| curve(&parameters(values))[3].force;
    let (bonded, frictionless) = (peak(&[]), peak(&[("boundary.bonded_punch", 0.0)]));
    assert!(frictionless < 0.98 * bonded, "{frictionless} {bonded}");
    let slipping = [1e-12, 1e-7, 1e-6, 1e-5, 1.0].map(|c| peak(&[("effect.slip.compliance", c)]));
    approx::assert_relative_eq!(slipping[0], bonded, max_relative = 1e-5);
    approx::assert_relative_eq!(slipping[4], frictionless, max_relative = 1e-5);
    assert!(slipping.windows(2).all(|pair| pair[1] < pair[0]), "{slipping:?}");
}

/// Goal: shear layer, compliant machine and lagging load cell go through separation and a second touch.
/// Set-up: one effect at a time at its plausible scale, two cycles of P2. Tolerance: the specimen is never pulled
/// (1e-4 mN) and free of force above the surface; with the compliance the specimen's energies balance within 0.5 %;
/// the lag's reading follows within five of its times (1e-2 of the peak); second peak within 10 % of the first.
#[test]
fn effects_go_through_separation() {
    let effects = [
        ("effect.slip.compliance", 1e-6),
        ("effect.compliance.per_newton", 2e-3),
        ("effect.load_cell_lag.time", 0.05),
    ];
    for (name, value) in effects {
        let protocol = Trapezoid { cycles: 2, ..Trapezoid::p2() }.protocol().unwrap();
        let model = Model::new(parameters(&[(name, value)])).unwrap();
        let mut instance = Instance::new(&model, -GAP).unwrap();
        let (mut peaks, mut leg) = ([0.0_f64; 2], 0);
        for pair in protocol.points().windows(2) {
            let ((from, a), (to, b)) = (pair[0], pair[1]);
            for k in 1..=20 {
                let part = f64::from(k) / 20.0;
                arrive(&mut instance, a + (b - a) * part, from + (to - from) * part);
                let o = instance.outputs();
                let case = format!("{name}, {} s: {o:?}", instance.time());
                assert!(o.force_specimen > -1e-7, "{case}");
                assert!(o.displacement > 0.0 || o.force_specimen == 0.0, "{case}");
                peaks[leg / 6] = peaks[leg / 6].max(o.force);
                if name == "effect.compliance.per_newton" {
                    let spent = o.stored_energy + o.viscous_dissipation + o.porous_dissipation;
                    assert!((spent - o.external_work).abs() < 5e-3 * o.external_work + 1e-12, "{case}");
                }
            }
            let o = instance.outputs();
            assert!((o.force - o.force_specimen).abs() < 1e-2 * peaks[0] || leg % 6 == 0, "{name}: {o:?}");
            leg += 1;
        }
        assert!(peaks[1] > 0.9 * peaks[0] && peaks[1] < 1.002 * peaks[0], "{name}: {peaks:?}");
    }
}

/// Goal: an offset is a shift of the displacement. Reference: the plain model on the shifted path; contact
/// begins at the true surface. Tolerance: 1e-12.
#[test]
fn offset_shifts_the_displacement() {
    for height in [5e-5, -5e-5] {
        let shifted = curve(&parameters(&[("effect.offset.height", height)]));
        let mut plain = Instance::new(&Model::new(parameters(&[])).unwrap(), -GAP + height).unwrap();
        for (time, to) in [(0.2, -GAP + RATE * 0.2), (0.5, -GAP + RATE * 0.5), (RAMP, DEPTH)] {
            arrive(&mut plain, to + height, time);
        }
        let (a, b) = (shifted[3], plain.outputs());
        approx::assert_relative_eq!(a.force, b.force, max_relative = 1e-12);
        assert_eq!((a.displacement, a.indentation), (DEPTH, DEPTH + height));
        // At 0.03 s the punch is 0.052 mm above the nominal zero, in contact with neither surface; at 0.05 s
        // it has touched the higher one only.
        assert_eq!(shifted[0].force, 0.0);
        let model = Model::new(parameters(&[("effect.offset.height", height)])).unwrap();
        let mut early = Instance::new(&model, -GAP).unwrap();
        move_to(&mut early, -GAP + RATE * 0.05, 0.05);
        assert_eq!(early.outputs().force > 0.0, height > 0.0);
    }
    let model = Model::new(parameters(&[("effect.offset.height", 2e-4)])).unwrap();
    assert!(matches!(Instance::new(&model, -GAP), Err(StepError::StartsInside(_))));
}

const SHEAR: f64 = 300.0;
const BULK: f64 = 1000.0;
const MOBILITY: f64 = 1e-9;
const HEIGHT: f64 = 1e-3;
const RADIUS: f64 = 0.5e-3;

/// Force of a confined column of 40 layers pressed at `velocity` until `end`.
fn column(drained_bottom: bool, drained_punch: bool, velocity: f64, end: f64) -> f64 {
    let mut p = Parameters { material: poroelastic(SHEAR, BULK, MOBILITY), ..Default::default() };
    p.geometry =
        GeometryParameters { punch_radius: RADIUS, sample_radius: 1.1 * RADIUS, sample_height: HEIGHT };
    p.boundary = BoundaryParameters {
        drained_bottom,
        drained_punch,
        drained_side: false,
        drained_top: false,
        confined_side: true,
        ..Default::default()
    };
    p.solver.newton_tolerance = 1e-13;
    let heights: Vec<f64> = (0..=40).map(|k| HEIGHT * f64::from(k) / 40.0).collect();
    let mesh = Mesh::tensor(&[0.0, RADIUS], &heights, RADIUS);
    let mut stepper = Stepper::new(&p.setup(), Arc::new(Sample::from_mesh(mesh).unwrap()));
    let (mut state, steps) = (stepper.undeformed(0.0), 200);
    let dt = end / f64::from(steps);
    for k in 0..steps {
        let start = velocity * dt * f64::from(k);
        state = tests::step(&mut stepper, &state, (start, velocity), dt);
    }
    state.outputs.force
}

/// Closed form of the same, drained over the length `path`.
fn series(path: f64, velocity: f64, end: f64) -> f64 {
    let modulus = BULK + 4.0 * SHEAR / 3.0;
    // Each of `HEIGHT / path` columns takes its part of the velocity.
    let ramp =
        Ramp { modulus, consolidation: MOBILITY * modulus, height: path, velocity: velocity * path / HEIGHT };
    PI * RADIUS * RADIUS * ramp.stress(end)
}

/// Goal: drainage through the punch and through the bottom. Set-up: a confined column, T = 0.1. Reference:
/// series of one-dimensional consolidation; drained at both ends it is two columns of half the height.
/// Tolerance: 0.1 %.
#[test]
fn drained_ends_of_a_column() {
    let modulus = BULK + 4.0 * SHEAR / 3.0;
    let end = 0.1 * HEIGHT * HEIGHT / (MOBILITY * modulus);
    let velocity = 1e-9 / end;
    for (bottom, punch, path) in [(true, false, HEIGHT), (false, true, HEIGHT), (true, true, 0.5 * HEIGHT)] {
        let (force, exact) = (column(bottom, punch, velocity, end), series(path, velocity, end));
        assert!((force / exact - 1.0).abs() < 1e-3, "{bottom} {punch}: {force:e} {exact:e}");
    }
}
