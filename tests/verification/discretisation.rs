//! The discretisation itself: patch test, Newton's convergence.

use poropunch::Parameters;
use poropunch::element::{Stage, undeformed};
use poropunch::law::PointMaterial;
use poropunch::law::point::DeformationGradient;
use poropunch::specimen::extrapolation::Extrapolation;
use poropunch::specimen::{Discretisation, Sample, Stepper};

/// Patch test.
/// Goal: a homogeneous finite deformation with uniform pore pressure is in equilibrium on the graded
/// mesh with its distorted and collapsed elements.
/// Set-up: u_r = 0.1 R, u_z = -0.15 Z, p = 300 Pa, viscous history consistent with it.
/// Reference: no nodal force and no fluid volume inside the sample. Tolerance: 1e-9 of the largest
/// nodal force, 1e-12 of the largest nodal volume.
#[test]
fn patch_test() {
    let parameters = Parameters::default();
    let sample = Sample::shared(&parameters.geometry, &parameters.mesh).unwrap();
    let material = PointMaterial::new(&parameters.material);
    let mesh = &sample.mesh;
    let mut x = vec![0.0; mesh.unknowns()];
    for (node, [r, z]) in mesh.nodes.iter().enumerate() {
        let u = mesh.displacement(node as u32);
        (x[u], x[u + 1]) = (0.1 * r, -0.15 * z);
        if let Some(p) = mesh.pressure(node as u32) {
            x[p] = 300.0;
        }
    }
    let mut old = undeformed(mesh.elements.len(), 2);
    let f = DeformationGradient { plane: [[1.1, 0.0], [0.0, 0.85]], hoop: 1.1 };
    old.jacobian.fill(f.determinant());
    let mut residual = vec![0.0; x.len()];
    let mut values = vec![0.0; sample.map.pattern.rows.len()];
    let stage = Stage { x: &x, old: &old, dt: 0.02 };
    sample.body(&material).assemble(&stage, &mut residual, Some(&mut values)).unwrap();

    let [r_max, z_max] = mesh.nodes.iter().fold([0.0_f64; 2], |m, x| [m[0].max(x[0]), m[1].max(x[1])]);
    let largest = residual.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
    assert!(largest > 1e-3, "the boundary must carry load");
    let volume = 1e-12 * r_max * r_max * z_max;
    for (node, [r, z]) in mesh.nodes.iter().enumerate() {
        let u = mesh.displacement(node as u32);
        if let Some(p) = mesh.pressure(node as u32) {
            assert!(residual[p].abs() < volume, "fluid volume {} at ({r}, {z})", residual[p]);
        }
        // On the axis u_r = 0 is a condition; elsewhere inside nothing may remain.
        if *r < r_max * 0.999_999 && *z > 1e-9 && *z < z_max * 0.999_999 {
            let radial = if *r > 0.0 { residual[u].abs() } else { 0.0 };
            let force = radial.max(residual[u + 1].abs());
            assert!(force < 1e-9 * largest, "force {force} at ({r}, {z})");
        }
    }
}

/// Quadratic convergence.
/// Goal: the assembled tangent is consistent with the residual, history and seepage included.
/// Set-up: four steps of 0.03 s into Table 1's material at 1.6 mm/s, then holds of 0.03 to 0.001 s, with the extrapolation
/// reset so that the starts are off by as much less; the punch is where it is to be from the start.
/// Reference: Newton's method; the first correction, by the tangent at the start, leaves at most `C` times the square of the
/// residual. Tolerance: C = 30 in dimensionless residuals, in at least two of the holds above rounding.
#[test]
fn newton_converges_quadratically() {
    let mut parameters = Parameters::default();
    parameters.solver.newton_tolerance = 1e-13;
    let sample = Sample::shared(&parameters.geometry, &parameters.mesh).unwrap();
    let mut stepper = Stepper::new(&parameters.setup(), sample);
    let mut state = stepper.undeformed(0.0);
    let mut step = |stepper: &mut Stepper, velocity: f64, dt: f64| {
        state.trend = Extrapolation::at_rest(state.x.len());
        state = tests::step(stepper, &state, (state.outputs.displacement, velocity), dt);
    };
    for _ in 0..4 {
        step(&mut stepper, 1.6e-3, 0.03);
    }
    let mut squares = 0;
    for dt in [0.03, 0.01, 0.003, 0.001] {
        step(&mut stepper, 0.0, dt);
        let norms = stepper.residual_norms();
        assert!(norms[1] < (30.0 * norms[0] * norms[0]).max(1e-11), "{norms:?}");
        squares += usize::from(norms[1] > 1e-11);
    }
    assert!(squares >= 2, "{squares}");
}
