//! Energy and dissipation.

use poropunch::parameters::MeshPreset;
use poropunch::{Instance, Model, Parameters};
use tests::{DEPTH, RATES, load_and_hold};

/// Goal: external work = stored energy + viscous dissipation + porous dissipation.
/// Set-up: P2's load and hold, Table 1, coarse mesh, tight time tolerance.
/// Tolerance: 0.2 % of the work at every checked time.
#[test]
fn work_is_stored_or_dissipated() {
    let mut parameters = Parameters::default();
    parameters.mesh.preset = MeshPreset::Coarse;
    parameters.solver.tolerance = 1e-5;
    for o in load_and_hold(&parameters, RATES[1], &[0.1, 0.625, 1.0, 10.0, 90.0]) {
        let spent = o.stored_energy + o.viscous_dissipation + o.porous_dissipation;
        approx::assert_relative_eq!(o.external_work, spent, max_relative = 2e-3);
        assert!(o.viscous_dissipation > 0.0 && o.porous_dissipation > 0.0);
    }
}

/// Goal: neither dissipation is ever negative, totals never fall.
/// Set-up: Table 1 and corners of the paper's bounds scaled to stay solvable, coarse mesh, partial
/// unloading included.
#[test]
fn dissipation_is_never_negative() {
    for (scale_g, scale_eta, scale_k) in
        [(1.0, 1.0, 1.0), (0.5, 1.5, 0.5), (1.5, 0.5, 1e3), (1.0, 10.0, 1e-3)]
    {
        let mut parameters = Parameters::default();
        parameters.mesh.preset = MeshPreset::Coarse;
        parameters.material.equilibrium.mu *= scale_g;
        parameters.material.permeability *= scale_k;
        for branch in &mut parameters.material.branches {
            branch.ogden.mu *= scale_g;
            branch.eta *= scale_eta;
        }
        let model = Model::new(parameters).unwrap();
        let mut instance = Instance::new(&model, 0.0).unwrap();
        let mut last = instance.outputs();
        let path = [(0.3, 0.5), (0.3, 1.0), (1.0, 1.0), (0.05, 0.97), (5.0, 0.97), (60.0, 0.97)];
        for (duration, depth) in path {
            instance.set_displacement(depth * DEPTH);
            for _ in 0..5 {
                instance.advance(duration / 5.0).unwrap();
            }
            let o = instance.outputs();
            assert!(o.viscous_dissipation_rate >= 0.0 && o.porous_dissipation_rate >= 0.0, "{o:?}");
            assert!(o.viscous_dissipation >= last.viscous_dissipation, "{o:?}");
            assert!(o.porous_dissipation >= last.porous_dissipation, "{o:?}");
            last = o;
        }
    }
}

/// Goal: the fluid leaves the sample: in a drained equilibrium the expelled volume is the loss of volume.
/// Set-up: P2 with a soft skeleton; sign and order of magnitude: below the punch's swept volume.
#[test]
fn fluid_is_expelled() {
    let mut parameters = Parameters::default();
    parameters.mesh.preset = MeshPreset::Coarse;
    parameters.material.lambda_star = 1e3;
    let results = load_and_hold(&parameters, RATES[1], &[0.625, 90.0]);
    let swept = std::f64::consts::PI * 4e-6 * DEPTH;
    assert!(results[0].fluid_expelled > 0.0 && results[1].fluid_expelled > results[0].fluid_expelled);
    assert!(results[1].fluid_expelled < swept, "{} of {swept}", results[1].fluid_expelled);
}
