//! Forward sensitivities through separation and a second touch.

use poropunch::material::{MaterialParameter, Spring};
use poropunch::parameters::MeshPreset;
use poropunch::{Instance, Model, Parameters};
use tests::DEPTH;

/// Ends of the communication steps (s) with the punch's place (m): load, hold, unload, away, load again, hold.
const PATH: [(f64, f64); 12] = [
    (0.625, DEPTH),
    (10.0, DEPTH),
    (10.1, 0.9 * DEPTH),
    (10.2, 0.8 * DEPTH),
    (11.0, 0.0),
    (12.0, -DEPTH),
    (70.0, -DEPTH),
    (71.0, 0.0),
    (71.3, 0.3 * DEPTH),
    (72.0, DEPTH),
    (73.0, DEPTH),
    (100.0, DEPTH),
];

fn run(parameters: &Parameters) -> Vec<(f64, Vec<f64>)> {
    let mut instance = Instance::new(&Model::new(parameters.clone()).unwrap(), 0.0).unwrap();
    PATH.into_iter()
        .map(|(end, displacement)| {
            instance.set_displacement(displacement);
            instance.advance(end - instance.time()).unwrap();
            let derivatives = instance.sensitivities().iter().map(|s| s.force).collect();
            (instance.outputs().force, derivatives)
        })
        .collect()
}

/// Goal: dF/dtheta stays right through unloading, separation and a second loading. The force is a continuous,
/// piecewise smooth function of the parameters; within a stage the set of nodes in contact is held fixed, so
/// the derivative is exact but for steps in which nodes open or close at slightly other parameters. Set-up:
/// coarse mesh, a tenth of the default tolerance, differences over 4 % of the modulus and of eta_2.
/// Tolerance: 2 % of the largest value along the path.
#[test]
fn second_loading_matches_finite_differences() {
    let mut parameters = Parameters::default();
    parameters.mesh.preset = MeshPreset::Coarse;
    parameters.solver.tolerance = 3e-5;
    let mut with = parameters.clone();
    with.solver.sensitivities = true;
    let exact = run(&with);
    let moved = |index: usize, factor: f64| {
        let mut moved = parameters.clone();
        let m = &mut moved.material;
        match index {
            0 => m.equilibrium.mu *= factor,
            1 => m.branches[1].ogden.mu *= factor,
            _ => m.branches[1].eta *= factor,
        }
        run(&moved)
    };
    let starts = [
        parameters.material.equilibrium.mu,
        parameters.material.branches[1].ogden.mu,
        parameters.material.branches[1].eta,
    ];
    let which = [
        MaterialParameter::Mu(Spring::Equilibrium),
        MaterialParameter::Mu(Spring::Branch(1)),
        MaterialParameter::Eta(1),
    ];
    for (index, (start, parameter)) in starts.into_iter().zip(which).enumerate() {
        let (up, down) = (moved(index, 1.02), moved(index, 0.98));
        let slope = |k: usize| (up[k].0 - down[k].0) / (0.04 * start);
        let largest = (0..PATH.len()).fold(0.0_f64, |m, k| m.max(slope(k).abs()));
        for (k, (_, derivatives)) in exact.iter().enumerate() {
            let error = (derivatives[parameter.index()] - slope(k)).abs() / largest;
            assert!(error < 2e-2, "{parameter:?} at {} s: {error:.1e}", PATH[k].0);
        }
    }
}

/// Goal: computing sensitivities changes no force through contact changes. Tolerance: none, bit for bit.
#[test]
fn sensitivities_leave_the_forces_alone() {
    let mut parameters = Parameters::default();
    parameters.mesh.preset = MeshPreset::Coarse;
    let plain = run(&parameters);
    parameters.solver.sensitivities = true;
    for ((a, _), (b, derivatives)) in plain.iter().zip(run(&parameters)) {
        assert_eq!(a.to_bits(), b.to_bits());
        assert_eq!(derivatives.len(), MaterialParameter::count(2));
    }
}
