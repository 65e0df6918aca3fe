//! A punch on a layer.
//!
//! Goal: the rigid base below a thin sample is felt as it should be. Mesh: `standard`, radius of the sample twelve times its height. Boundary conditions:
//! bonded base, frictionless punch. Parameters: a/h = 0.2 and 0.4, 1e-6 of the height deep; drained skeleton with nu = 0.3 and 0.45, and undrained
//! (nu = 1/2). Reference: Hayes et al. 1972 (`analytical/layer.rs`). Tolerance: 1 %.

use poropunch::parameters::{BoundaryParameters, GeometryParameters};
use poropunch::{Instance, Model, Parameters};
use tests::analytical::{half_space, layer};
use tests::{move_to, poroelastic};

const SHEAR: f64 = 500.0;
const RADIUS: f64 = 1e-3;

/// Force (N) on the layer a second after it was touched.
fn force(nu: Option<f64>, height: f64, depth: f64) -> f64 {
    let bulk = nu.map_or(1e4, |nu| 2.0 * SHEAR * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu)));
    let mobility = if nu.is_some() { 1.0 } else { 1e-25 };
    let mut parameters = Parameters { material: poroelastic(SHEAR, bulk, mobility), ..Default::default() };
    parameters.geometry =
        GeometryParameters { punch_radius: RADIUS, sample_radius: 12.0 * height, sample_height: height };
    let drained = nu.is_some();
    parameters.boundary = BoundaryParameters {
        bonded_punch: false,
        drained_bottom: drained,
        drained_side: drained,
        drained_top: drained,
        ..Default::default()
    };
    let mut instance = Instance::new(&Model::new(parameters).unwrap(), 0.0).unwrap();
    move_to(&mut instance, depth, 1.0);
    instance.advance(1e3).unwrap();
    instance.outputs().force
}

#[test]
fn punch_on_a_layer_of_hayes() {
    for (nu, ratio) in [(Some(0.3), 0.2), (Some(0.45), 0.2), (None, 0.2), (None, 0.4)] {
        let (height, depth) = (RADIUS / ratio, 1e-6 * RADIUS / ratio);
        let poisson = nu.unwrap_or(0.5);
        let kappa = force(nu, height, depth) / half_space::flat_punch(SHEAR, poisson, RADIUS, depth);
        let exact = layer::kappa(poisson, ratio);
        println!("nu = {poisson}, a/h = {ratio}: {kappa:.4}, {exact:.4}");
        assert!((kappa / exact - 1.0).abs() < 1e-2, "nu = {poisson}, a/h = {ratio}: {kappa} {exact}");
    }
}
