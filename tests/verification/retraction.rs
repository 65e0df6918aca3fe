//! The retraction in the mesh.
//!
//! Goal: while the punch leaves, and peels off the surface, the force converges as it does while it comes. Mesh: the presets. Boundary conditions and parameters:
//! Table 1, P2's first cycle, forces at twenty depths of the unloading leg. Reference: `fine`, and its differences from the coarser ones. Tolerances below.

use poropunch::parameters::MeshPreset;
use poropunch::{Instance, Model, Parameters};
use tests::{DEPTH, move_to};

/// Forces (N): the peak, then at every twentieth of the depth on the way back.
fn forces(preset: MeshPreset) -> Vec<f64> {
    let mut parameters = Parameters::default();
    parameters.mesh.preset = preset;
    let mut instance = Instance::new(&Model::new(parameters).unwrap(), 0.0).unwrap();
    let mut to = |displacement: f64, duration: f64| {
        move_to(&mut instance, displacement, duration);
        instance.outputs().force
    };
    let mut found = vec![to(DEPTH, 0.625)];
    to(DEPTH, 90.0);
    found.extend((1..=20).map(|k| to(DEPTH * (1.0 - 0.05 * f64::from(k)), 0.05)));
    found
}

/// Largest difference over the peak.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / b[0]
}

/// Tolerance: `standard` is nearer to `fine` than `coarse` is by a factor of two, and within 0.2 % of the peak.
#[test]
fn retraction_converges() {
    let [coarse, standard, fine] = [MeshPreset::Coarse, MeshPreset::Standard, MeshPreset::Fine].map(forces);
    let [far, near] = [&coarse, &standard].map(|curve| distance(curve, &fine));
    println!("coarse {far:.2e}, standard {near:.2e} of the peak");
    assert!(2.0 * near < far && near < 2e-3, "{far} {near}");
    // The leg is no trivial one: the punch peels while it is still pressed in.
    assert!(fine[8] > 0.0 && fine[9] == 0.0 && fine[1] > 0.1 * fine[0], "{fine:?}");
}
