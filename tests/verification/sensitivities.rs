//! Forward sensitivities against finite differences of whole runs.

use poropunch::law::{MaterialParameter, Spring};
use poropunch::parameters::{MaterialParameters, TimeScheme};
use poropunch::{ForceSensitivity, Instance, Model, Parameters};
use tests::{DEPTH, coarse, move_to};

/// Ends of the communication steps over P2's first cycle (s).
const TIMES: [f64; 9] = [0.1, 0.3, 0.625, 0.63, 0.7, 1.6, 10.6, 30.6, 90.6];
const RAMP: f64 = 0.625;

pub fn value(m: &mut MaterialParameters, parameter: MaterialParameter) -> &mut f64 {
    match parameter {
        MaterialParameter::SolidFraction => &mut m.n0s,
        MaterialParameter::LambdaStar => &mut m.lambda_star,
        MaterialParameter::FluidViscosity => &mut m.fluid_viscosity,
        MaterialParameter::Permeability => &mut m.permeability,
        MaterialParameter::Mu(Spring::Equilibrium) => &mut m.equilibrium.mu,
        MaterialParameter::Alpha(Spring::Equilibrium) => &mut m.equilibrium.alpha,
        MaterialParameter::Mu(Spring::Branch(b)) => &mut m.branches[b].ogden.mu,
        MaterialParameter::Alpha(Spring::Branch(b)) => &mut m.branches[b].ogden.alpha,
        MaterialParameter::Eta(b) => &mut m.branches[b].eta,
    }
}

/// Force and fluid force (N), and their derivatives, at all times.
fn cycle(parameters: &Parameters) -> Vec<([f64; 2], Vec<ForceSensitivity>)> {
    let mut instance = Instance::new(&Model::new(parameters.clone()).unwrap(), 0.0).unwrap();
    let mut reached = 0.0;
    let advance = |end: f64| {
        move_to(&mut instance, DEPTH * (end / RAMP).min(1.0), end - reached);
        reached = end;
        let outputs = instance.outputs();
        ([outputs.force, outputs.force_fluid], instance.sensitivities())
    };
    TIMES.into_iter().map(advance).collect()
}

/// Parameters with step sizes that depend on nothing: the tolerance is never felt.
fn fixed_steps(scheme: TimeScheme) -> Parameters {
    let mut parameters = coarse();
    parameters.solver.time_scheme = scheme;
    parameters.solver.tolerance = 1.0;
    parameters.solver.initial_increment = 2e-5;
    parameters.solver.max_step = 4.0;
    parameters.solver.newton_tolerance = 1e-12;
    // Permeable and compressible enough for the pore fluid to matter.
    parameters.material.lambda_star = 3e3;
    parameters.material.permeability = 1e-12;
    parameters
}

/// Central difference of fourth order of both forces at all times by one parameter.
fn difference(parameters: &Parameters, parameter: MaterialParameter) -> Vec<[f64; 2]> {
    const STEP: f64 = 2e-3;
    let start = *value(&mut parameters.material.clone(), parameter);
    let moved = |steps: f64| {
        let mut moved = parameters.clone();
        moved.solver.sensitivities = false;
        *value(&mut moved.material, parameter) = start * (1.0 + STEP * steps);
        cycle(&moved)
    };
    let runs = [-2.0, -1.0, 1.0, 2.0].map(moved);
    (0..TIMES.len())
        .map(|k| {
            std::array::from_fn(|force| {
                let f = |run: usize| runs[run][k].0[force];
                (f(0) - 8.0 * f(1) + 8.0 * f(2) - f(3)) / (12.0 * STEP * start)
            })
        })
        .collect()
}

/// Goal: dF/dtheta and dF_fluid/dtheta of all twelve parameters are exact along a whole P2 cycle, ramp, kink
/// and hold, for both time schemes. Set-up: coarse mesh, fixed steps, Newton to 1e-12; lambda* = 3 kPa and
/// K0 = 1e-6 mm^2 so that every parameter matters. Reference: central differences of fourth order.
/// Tolerance: 1e-5 of the largest value along the curve.
fn sensitivities_match_finite_differences(scheme: TimeScheme) {
    let mut parameters = fixed_steps(scheme);
    parameters.solver.sensitivities = true;
    let exact = cycle(&parameters);
    for parameter in MaterialParameter::all(2) {
        let numeric = difference(&parameters, parameter);
        for part in 0..2 {
            let largest = numeric.iter().fold(0.0_f64, |m, d| m.max(d[part].abs()));
            assert!(largest > 0.0, "{parameter:?} does not matter");
            for (k, time) in TIMES.into_iter().enumerate() {
                let s = exact[k].1[parameter.index()];
                let analytic = [s.force, s.fluid][part];
                let error = (analytic - numeric[k][part]).abs() / largest;
                assert!(
                    error < 1e-5,
                    "{scheme:?} {parameter:?} part {part} at {time} s: {analytic:e} against {:e}, {error:.1e}",
                    numeric[k][part]
                );
            }
        }
    }
}

#[test]
fn sensitivities_match_finite_differences_of_sdirk2() {
    sensitivities_match_finite_differences(TimeScheme::Sdirk2);
}

#[test]
#[ignore = "long: five seconds"]
fn sensitivities_match_finite_differences_of_backward_euler() {
    sensitivities_match_finite_differences(TimeScheme::BackwardEuler);
}

/// Goal: under error control the derivatives belong to the curve, whose steps they take as given. Set-up:
/// coarse mesh, a tenth of the default tolerance; differences over 20 % of each modulus of Table 1, above the
/// noise of changing steps. Tolerance: 1 % of the largest value along the curve.
#[test]
fn error_control_does_not_disturb_the_derivatives() {
    let mut parameters = coarse();
    parameters.solver.sensitivities = true;
    parameters.solver.tolerance = 3e-5;
    let exact = cycle(&parameters);
    for parameter in MaterialParameter::all(2).filter(|p| matches!(p, MaterialParameter::Mu(_))) {
        let start = *value(&mut parameters.material.clone(), parameter);
        let moved = |factor: f64| {
            let mut moved = parameters.clone();
            moved.solver.sensitivities = false;
            *value(&mut moved.material, parameter) = start * factor;
            cycle(&moved)
        };
        let (up, down) = (moved(1.1), moved(0.9));
        let slope = |k: usize| (up[k].0[0] - down[k].0[0]) / (0.2 * start);
        let largest = (0..TIMES.len()).fold(0.0_f64, |m, k| m.max(slope(k).abs()));
        for (k, (_, s)) in exact.iter().enumerate() {
            let error = (s[parameter.index()].force - slope(k)).abs() / largest;
            assert!(error < 1e-2, "{parameter:?} at {} s: {error:.1e}", TIMES[k]);
        }
    }
}

/// Goal: computing sensitivities changes nothing else. Tolerance: none, bit for bit.
#[test]
fn sensitivities_leave_the_forces_alone() {
    let mut parameters = coarse();
    let plain = cycle(&parameters);
    parameters.solver.sensitivities = true;
    for ((a, none), (b, some)) in plain.iter().zip(cycle(&parameters)) {
        assert_eq!(*a, b);
        assert!(none.is_empty() && some.len() == MaterialParameter::count(2));
    }
}
