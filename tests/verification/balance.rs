//! Energy and dissipation.

use poropunch::{Instance, Model};
use tests::{DEPTH, RATES, coarse, load_and_hold, move_to};

/// Goal: external work = stored energy + viscous dissipation + porous dissipation.
/// Set-up: P2's load and hold, Table 1, coarse mesh, tight time tolerance.
/// Tolerance: 0.2 % of the work at every checked time.
#[test]
fn work_is_stored_or_dissipated() {
    let mut parameters = coarse();
    parameters.solver.tolerance = 1e-5;
    for o in load_and_hold(&parameters, RATES[1], &[0.1, 0.625, 1.0, 10.0, 90.0]) {
        let spent = o.stored_energy + o.viscous_dissipation + o.porous_dissipation;
        approx::assert_relative_eq!(o.external_work, spent, max_relative = 2e-3);
    }
}

/// Goal: dissipated energies never fall (the viscous one's value is held against an
/// equation in `relaxation.rs`, the porous one's in `consolidation.rs`). Set-up: Table 1 and corners of the paper's bounds scaled to stay solvable, coarse
/// mesh, partial unloading included, five communication points per leg. Tolerance: rounding of the total. Between the model's own
/// steps `fmu/src/motion/tests.rs` looks.
#[test]
fn dissipated_energies_never_fall() {
    let points = 5;
    for (scale_g, scale_eta, scale_k) in [(1.0, 1.0, 1.0), (1.5, 0.5, 1e3)] {
        let mut parameters = coarse();
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
        let mut reached = 0.0;
        for (duration, depth) in path {
            for k in 1..=points {
                let part = f64::from(k) / f64::from(points);
                move_to(
                    &mut instance,
                    (reached + (depth - reached) * part) * DEPTH,
                    duration / f64::from(points),
                );
                let o = instance.outputs();
                let rounding = 1e-12 * o.external_work;
                assert!(
                    o.viscous_dissipation >= last.viscous_dissipation - rounding,
                    "viscous {:e} after {:e}",
                    o.viscous_dissipation,
                    last.viscous_dissipation
                );
                assert!(
                    o.porous_dissipation >= last.porous_dissipation - rounding,
                    "{} of {depth}: porous {:e} after {:e}",
                    k,
                    o.porous_dissipation,
                    last.porous_dissipation
                );
                last = o;
            }
            reached = depth;
        }
    }
}
