//! Strain-dependent permeability.

use poropunch::mesh::Mesh;
use poropunch::specimen::{Discretisation, Sample, Stepper};
use std::f64::consts::PI;
use std::sync::Arc;
use tests::poroelastic;

const SHEAR: f64 = 300.0;
const BULK: f64 = 1000.0;
const MOBILITY: f64 = 1e-9;
const SOLID: f64 = 0.2;
const HEIGHT: f64 = 1e-3;
const RADIUS: f64 = 0.5e-3;
/// Final strain, and duration (s): T = 0.2 of the undeformed column.
const STRAIN: f64 = 0.15;
const END: f64 = 0.2 * HEIGHT * HEIGHT / (MOBILITY * (BULK + 4.0 * SHEAR / 3.0));

/// Force of a confined column, drained at the punch only, pressed by 15 %.
fn column(exponent: f64) -> f64 {
    let mut p = tests::confined_column(poroelastic(SHEAR, BULK, MOBILITY), RADIUS, HEIGHT);
    p.effect.permeability.exponent = exponent;
    p.boundary.drained_bottom = false;
    p.boundary.drained_punch = true;
    p.solver.newton_tolerance = 1e-12;
    // Layers that become thin towards the punch, where the compacted skin is.
    let below = |k: i32| 1.0 - f64::from(k) / 60.0;
    let heights: Vec<f64> = (0..=60).map(|k| HEIGHT * (1.0 - below(k) * below(k))).collect();
    let mesh = Mesh::tensor(&[0.0, RADIUS], &heights, RADIUS);
    let mut stepper = Stepper::new(&p.setup(), Arc::new(Sample::from_mesh(mesh).unwrap()));
    let (mut state, steps) = (stepper.undeformed(0.0), 200);
    let (dt, velocity) = (END / f64::from(steps), STRAIN * HEIGHT / END);
    for k in 0..steps {
        let start = velocity * dt * f64::from(k);
        state = tests::step(&mut stepper, &state, (start, velocity), dt);
    }
    state.outputs.force
}

/// The same from `dJ/dt = d/dZ (D dJ/dZ)`, `D = M(J) P'(J) / J^2`, P the axial first Piola-Kirchhoff stress of
/// the skeleton and M the referential mobility: finite volumes, explicit Euler. The flux through the punch is
/// its velocity, and the pore pressure there is zero.
fn diffusion(exponent: f64, cells: usize) -> f64 {
    let spring = |e: f64| SHEAR * 2.0 / 3.0 * ((2.0 * e).exp() - (-e).exp());
    let open = 1.0 - SOLID;
    let stress = |j: f64| {
        let volumetric = BULK * open * open * (j / open - j / (j - SOLID));
        (spring(2.0 / 3.0 * j.ln()) + volumetric) / j
    };
    let diffusivity = |j: f64| {
        let slope = (stress(j + 1e-6) - stress(j - 1e-6)) / 2e-6;
        let mobility = MOBILITY * j * (j - SOLID) / open * ((j - SOLID) / open).powf(exponent);
        mobility * slope / (j * j)
    };
    let dz = HEIGHT / cells as f64;
    let steps = (END * diffusivity(1.0) * 8.0 / (dz * dz)) as usize;
    let (dt, velocity) = (END / steps as f64, STRAIN * HEIGHT / END);
    let mut j = vec![1.0; cells];
    let mut face = 1.0;
    let mut flux = vec![0.0; cells + 1];
    flux[cells] = -velocity;
    for _ in 0..steps {
        for k in 1..cells {
            flux[k] = diffusivity(0.5 * (j[k - 1] + j[k])) * (j[k] - j[k - 1]) / dz;
        }
        for k in 0..cells {
            j[k] += dt / dz * (flux[k + 1] - flux[k]);
        }
    }
    for _ in 0..100 {
        face = j[cells - 1] - velocity * 0.5 * dz / diffusivity(0.5 * (face + j[cells - 1]));
    }
    -stress(face) * PI * RADIUS * RADIUS
}

/// Goal: the permeability's law inside a strongly compressed column. Set-up: confined, 15 %, drained at the
/// punch; m = 0 and 3. Reference: nonlinear diffusion of J by 200 finite volumes.
/// Tolerance: 0.2 %; m = 3 makes the force more than twice as large.
#[test]
fn compressed_column_against_nonlinear_diffusion() {
    let mut forces = [0.0; 2];
    for (force, exponent) in forces.iter_mut().zip([0.0, 3.0]) {
        *force = column(exponent);
        let exact = diffusion(exponent, 200);
        assert!((*force / exact - 1.0).abs() < 2e-3, "m = {exponent}: {force:e}, {exact:e}");
    }
    assert!(forces[1] > 2.0 * forces[0], "{forces:?}");
}
