//! Terzaghi's one-dimensional consolidation: a confined, laterally fixed column drained at its bottom.

use poropunch::Outputs;
use poropunch::mesh::Mesh;
use poropunch::parameters::TimeScheme;
use poropunch::specimen::{Discretisation, Sample, State, Stepper};
use std::f64::consts::PI;
use std::sync::Arc;
use tests::analytical::consolidation::{Ramp, degree};
use tests::poroelastic;

const SHEAR: f64 = 300.0;
const BULK: f64 = 1000.0;
const MOBILITY: f64 = 1e-9;
const HEIGHT: f64 = 1e-3;
/// A thin column: lateral fixing comes from its bonded ends and side in [`column`].
const RADIUS: f64 = 0.5e-3;

/// Confined modulus K + 4 G / 3 (Pa).
const MODULUS: f64 = BULK + 4.0 * SHEAR / 3.0;
/// Coefficient of consolidation [m^2/s].
const CONSOLIDATION: f64 = MOBILITY * MODULUS;

fn area() -> f64 {
    PI * RADIUS * RADIUS
}

/// A column of `layers` elements, confined, drained at the bottom only.
fn column(layers: usize, scheme: TimeScheme) -> Stepper {
    let mut parameters = tests::confined_column(poroelastic(SHEAR, BULK, MOBILITY), RADIUS, HEIGHT);
    parameters.solver.time_scheme = scheme;
    parameters.solver.newton_tolerance = 1e-13;
    let heights: Vec<f64> = (0..=layers).map(|k| HEIGHT * k as f64 / layers as f64).collect();
    let mesh = Mesh::tensor(&[0.0, RADIUS], &heights, RADIUS);
    Stepper::new(&parameters.setup(), Arc::new(Sample::from_mesh(mesh).unwrap()))
}

/// Closed form of the column pressed at a constant velocity.
fn ramp(velocity: f64) -> Ramp {
    Ramp { modulus: MODULUS, consolidation: CONSOLIDATION, height: HEIGHT, velocity }
}

/// Time of pressing, T = c t / H^2 = 0.2, and the velocity.
fn pressing() -> (f64, f64) {
    let end = 0.2 * HEIGHT * HEIGHT / CONSOLIDATION;
    (end, 1e-9 / end)
}

/// Force after pressing in equal steps.
fn pressed(layers: usize, steps: usize, scheme: TimeScheme) -> f64 {
    results(layers, steps, scheme).force
}

fn results(layers: usize, steps: usize, scheme: TimeScheme) -> Outputs {
    let mut stepper = column(layers, scheme);
    let (end, velocity) = pressing();
    let mut state = stepper.undeformed(0.0);
    let dt = end / steps as f64;
    for k in 0..steps {
        let start = velocity * dt * k as f64;
        state = tests::step(&mut stepper, &state, (start, velocity), dt);
    }
    state.outputs
}

/// Goal: the force's solid and fluid parts, each on its own, and the fluid that leaves. Set-up: T = 0.2, 40 layers, 200 steps of order
/// two. Reference: effective stress at the sealed end and pore pressure there, by the series; the swept volume. Tolerance: 0.2 %.
#[test]
fn solid_and_fluid_part_and_the_fluid_expelled() {
    let (end, velocity) = pressing();
    let o = results(40, 200, TimeScheme::Sdirk2);
    let [total, solid] =
        [ramp(velocity).stress(end), ramp(velocity).effective_stress(end)].map(|stress| area() * stress);
    for (found, exact) in
        [(o.force_solid, solid), (o.force_fluid, total - solid), (o.fluid_expelled, area() * velocity * end)]
    {
        approx::assert_relative_eq!(found, exact, max_relative = 2e-3);
    }
    // Without branches what is neither stored nor given back went into the seepage.
    let lost = o.external_work - o.stored_energy;
    assert!(lost > 0.2 * o.external_work, "{o:?}");
    approx::assert_relative_eq!(o.porous_dissipation, lost, max_relative = 5e-3);
}

/// Goal: order in time of the coupled problem.
/// Reference: 1280 SDIRK2 steps on the same 20 layers (the error in space cancels).
/// Tolerance: observed order within 0.25 of 1 (backward Euler) and of 2 (SDIRK2).
#[test]
fn order_in_time() {
    let reference = pressed(20, 1280, TimeScheme::Sdirk2);
    for (scheme, order) in [(TimeScheme::BackwardEuler, 1.0), (TimeScheme::Sdirk2, 2.0)] {
        let error = |steps| pressed(20, steps, scheme) / reference - 1.0;
        let (coarse, fine) = (error(40), error(80));
        let observed = (coarse / fine).abs().log2();
        assert!((observed - order).abs() < 0.25, "{scheme:?}: {coarse:e} {fine:e}, order {observed}");
    }
}

/// Goal: order in space, and the value.
/// Reference: closed form of the ramp; 200 SDIRK2 steps.
/// Tolerance: observed order at least 1.9 from 4 to 16 layers, error below 0.05 % with 16.
#[test]
fn order_in_space() {
    let (end, velocity) = pressing();
    let exact = area() * ramp(velocity).stress(end);
    let errors = [4, 8, 16].map(|n| (pressed(n, 200, TimeScheme::Sdirk2) / exact - 1.0).abs());
    let order = 0.5 * (errors[0] / errors[2]).log2();
    assert!(order > 1.9 && errors[2] < 5e-4, "{errors:?}, order {order}");
}

/// Goal: Terzaghi's degree of consolidation under a constant load.
/// Set-up: 40 layers; in every step the displacement is chosen such that the force is the load.
/// Reference: Terzaghi's series at T = 0.05, 0.2, 0.5. Tolerance: 0.002.
#[test]
fn degree_of_consolidation() {
    let mut stepper = column(40, TimeScheme::Sdirk2);
    let load = 1e-6 * MODULUS * area();
    let final_displacement = load * HEIGHT / (MODULUS * area());
    let unit = HEIGHT * HEIGHT / CONSOLIDATION;
    let (mut state, mut displacement) = (stepper.undeformed(0.0), 0.0);
    let mut t = 1e-6_f64;
    let mut checks = [0.05, 0.2, 0.5].into_iter().peekable();
    while let Some(&until) = checks.peek() {
        let dt = (0.03 * t).min(until * unit - state.time);
        // The problem is linear at this load: two trials give the velocity.
        let mut trial = |v: f64| -> State { tests::step(&mut stepper, &state, (displacement, v), dt) };
        let v = final_displacement / (dt * unit).sqrt();
        let (f0, f1) = (trial(0.0).outputs.force, trial(v).outputs.force);
        let velocity = v * (load - f0) / (f1 - f0);
        state = trial(velocity);
        displacement += velocity * dt;
        t = state.time.max(1e-6) * 1.03;
        assert!((state.outputs.force / load - 1.0).abs() < 1e-6);
        if state.time > until * unit * (1.0 - 1e-9) {
            let (found, expected) = (displacement / final_displacement, degree(until));
            assert!((found - expected).abs() < 2e-3, "U({until}) = {found}, expected {expected}");
            checks.next();
        }
    }
}
