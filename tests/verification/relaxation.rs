//! Viscous relaxation of one element in unconfined, drained compression.

use poropunch::Parameters;
use poropunch::mesh::Mesh;
use poropunch::parameters::TimeScheme;
use poropunch::specimen::{Discretisation, Sample, Stepper};
use std::f64::consts::PI;
use std::sync::Arc;
use tests::analytical::rising_zero;
use tests::drained_element;

const RADIUS: f64 = 1e-3;
const HEIGHT: f64 = 1e-3;

fn parameters(scheme: TimeScheme) -> Parameters {
    let mut parameters = drained_element(RADIUS, HEIGHT);
    parameters.solver.time_scheme = scheme;
    parameters
}

/// Force (N) and viscous dissipation (J) after pressing by `strain` of the height within `ramp` and holding for as long, in
/// `steps` each.
fn element(scheme: TimeScheme, strain: f64, ramp: f64, steps: usize) -> [f64; 2] {
    let mesh = Mesh::tensor(&[0.0, RADIUS], &[0.0, HEIGHT], RADIUS);
    let mut stepper = Stepper::new(&parameters(scheme).setup(), Arc::new(Sample::from_mesh(mesh).unwrap()));
    let mut state = stepper.undeformed(0.0);
    let (dt, depth) = (ramp / steps as f64, strain * HEIGHT);
    for k in 0..2 * steps {
        let (start, v) =
            if k < steps { (depth * k as f64 / steps as f64, depth / ramp) } else { (depth, 0.0) };
        state = tests::step(&mut stepper, &state, (start, v), dt);
    }
    [state.outputs.force, state.outputs.viscous_dissipation]
}

/// The same by integrating the flow rule `d eps_e / dt = d eps / dt - beta / (2 eta)` of the deviatoric
/// elastic strain with the classical Runge-Kutta method; the lateral stretch follows from zero stress.
/// Shares nothing with the element but the parameters.
fn by_ode(strain: f64, ramp: f64, steps: usize) -> [f64; 2] {
    let p = parameters(TimeScheme::BackwardEuler).material;
    let (n, s) = (p.n0s, 1.0 - p.n0s);
    let b = p.branches[0];
    let ogden = |mu: f64, alpha: f64, e: f64| {
        // Axial deviatoric strain e, lateral -e/2: axial deviatoric stress.
        let (q_z, q_r) = ((alpha * e).exp(), (-0.5 * alpha * e).exp());
        mu * (2.0 / 3.0) * (q_z - q_r)
    };
    // State: axial viscous strain (deviatoric). eps_z(t) is given; eps_r solves tau_r = 0.
    let axial = |t: f64| (1.0 - strain * (t / ramp).min(1.0)).ln();
    let stresses = |eps_z: f64, eps_v: f64| {
        let tau = |eps_r: f64| {
            let j = (eps_z + 2.0 * eps_r).exp();
            let e = 2.0 / 3.0 * (eps_z - eps_r);
            let beta = ogden(b.ogden.mu, b.ogden.alpha, e - eps_v);
            let dev = ogden(p.equilibrium.mu, p.equilibrium.alpha, e) + beta;
            let vol = p.lambda_star * s * s * (j / s - j / (j - n));
            (vol - 0.5 * dev, vol + dev, beta)
        };
        let (_, tau_z, beta) = tau(rising_zero(|eps_r| tau(eps_r).0));
        // Kirchhoff stress over the axial stretch is force per reference area.
        (tau_z / eps_z.exp(), beta)
    };
    let rate = |t: f64, eps_v: f64| stresses(axial(t), eps_v).1 / (2.0 * b.eta);
    // Principal stresses beta, -beta/2, -beta/2 flow with beta / (2 eta) each.
    let dissipation = |t: f64, eps_v: f64| 0.75 * stresses(axial(t), eps_v).1.powi(2) / b.eta;
    let (dt, mut eps_v, mut dissipated) = (ramp / steps as f64, 0.0, 0.0);
    for k in 0..2 * steps {
        let t = k as f64 * dt;
        let k1 = rate(t, eps_v);
        let k2 = rate(t + 0.5 * dt, eps_v + 0.5 * dt * k1);
        let k3 = rate(t + 0.5 * dt, eps_v + 0.5 * dt * k2);
        let k4 = rate(t + dt, eps_v + dt * k3);
        // Simpson's rule, the middle value by the same stage as the third.
        let ends = dissipation(t, eps_v) + 4.0 * dissipation(t + 0.5 * dt, eps_v + 0.5 * dt * k2);
        eps_v += dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        dissipated += dt / 6.0 * (ends + dissipation(t + dt, eps_v));
    }
    let area = PI * RADIUS * RADIUS;
    [-stresses(axial(2.0 * ramp), eps_v).0 * area, dissipated * area * HEIGHT]
}

/// Goal: finite-strain viscous flow, force and dissipated energy, order in time.
/// Set-up: 30 % compression in 0.6 s, relaxation time 0.5 s, hold 0.6 s.
/// Reference: Runge-Kutta with 400 steps. Tolerance: order of the force within 0.15 of 1 (backward Euler) and of 2
/// (SDIRK2); SDIRK2 with 80 steps within 1e-4, the energy within 1e-3.
#[test]
fn finite_strain_relaxation_against_an_ode() {
    let [force, dissipation] = by_ode(0.3, 0.6, 400);
    for (scheme, order) in [(TimeScheme::BackwardEuler, 1.0), (TimeScheme::Sdirk2, 2.0)] {
        let error = |steps| element(scheme, 0.3, 0.6, steps)[0] / force - 1.0;
        let (coarse, fine) = (error(40), error(80));
        let observed = (coarse / fine).abs().log2();
        assert!((observed - order).abs() < 0.15, "{scheme:?}: {coarse:e} {fine:e}, order {observed}");
        if scheme == TimeScheme::Sdirk2 {
            assert!(fine.abs() < 1e-4, "{fine:e}");
            let found = element(scheme, 0.3, 0.6, 80)[1];
            approx::assert_relative_eq!(found, dissipation, max_relative = 1e-3);
        }
    }
}

/// Goal: the small-strain relaxation time is eta / (mu alpha / 2).
/// Set-up: 0.01 % compression in a tiny ramp; drained bulk so stiff that the branch alone relaxes.
/// Reference: force(t) - force(inf) falls by exp(-1) in 0.5 s. Tolerance: 0.5 %.
#[test]
fn small_strain_relaxation_time() {
    let mut parameters = parameters(TimeScheme::Sdirk2);
    parameters.material.lambda_star = 1e8;
    let mesh = Mesh::tensor(&[0.0, RADIUS], &[0.0, HEIGHT], RADIUS);
    let mut stepper = Stepper::new(&parameters.setup(), Arc::new(Sample::from_mesh(mesh).unwrap()));
    let (depth, ramp) = (1e-4 * HEIGHT, 1e-6);
    let mut state = stepper.undeformed(0.0);
    state = tests::step(&mut stepper, &state, (0.0, depth / ramp), ramp);
    let mut forces = vec![state.outputs.force];
    for _ in 0..600 {
        state = tests::step(&mut stepper, &state, (depth, 0.0), 0.01);
        forces.push(state.outputs.force);
    }
    let end = forces[600];
    let decay = ((forces[0] - end) / (forces[50] - end)).ln();
    approx::assert_relative_eq!(0.5 / decay, 0.5, max_relative = 5e-3);
}
