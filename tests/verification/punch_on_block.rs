//! A bonded flat punch on a large block: undrained, then drained.

use approx::assert_relative_eq;
use poropunch::parameters::{BoundaryParameters, GeometryParameters};
use poropunch::{Instance, Model, Parameters};
use tests::analytical::half_space::{bonded_punch, flat_punch};
use tests::{move_to, poroelastic};

const SHEAR: f64 = 500.0;
const DEPTH: f64 = 1e-6;

/// Force over `G a d` of a punch of 2 mm radius, pressed 1 um deep within `ramp` (s) and held for `hold` (s).
fn stiffness(size: f64, bulk: f64, mobility: f64, ramp: f64, hold: f64, bonded: bool) -> [f64; 2] {
    let mut parameters = Parameters { material: poroelastic(SHEAR, bulk, mobility), ..Default::default() };
    parameters.geometry =
        GeometryParameters { sample_radius: size, sample_height: size, ..Default::default() };
    parameters.boundary = BoundaryParameters { bonded_punch: bonded, ..Default::default() };
    let model = Model::new(parameters).unwrap();
    let mut instance = Instance::new(&model, 0.0).unwrap();
    move_to(&mut instance, DEPTH, ramp);
    let early = instance.outputs().force;
    instance.advance(hold).unwrap();
    let late = instance.outputs().force;
    [early, late].map(|f| f / (SHEAR * 2e-3 * DEPTH))
}

/// Goal: instantaneous response is that of an incompressible half-space, F = 8 G a d.
/// Set-up: block R = H = 400 mm, a = 2 mm, seepage switched off by a tiny permeability.
/// Reference: 8 G a d, times 1.006 for the finite block (design, independent solver). Tolerance: 0.3 %.
#[test]
fn undrained_punch() {
    let [force, _] = stiffness(0.4, 1e4, 1e-25, 1e-3, 1e-3, true);
    assert_relative_eq!(force, 1.006 * flat_punch(1.0, 0.5, 1.0, 1.0), max_relative = 3e-3);
}

/// Goal: long-time response is that of the drained skeleton.
/// Set-up: as above with fast seepage; bulk modulus for nu = 0.2.
/// Reference: Spence 1968, bonded punch, F = 4 G a d ln(3 - 4 nu) / (1 - 2 nu). The block's stiffening
/// is of order a / R = 0.5 %. Tolerance: 1 %, and the block may only stiffen beyond 0.3 % of mesh error.
#[test]
fn drained_bonded_punch_of_spence() {
    let nu: f64 = 0.2;
    let bulk = 2.0 * SHEAR * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu));
    let [_, force] = stiffness(0.4, bulk, 1e-3, 1.0, 1e3, true);
    let spence = bonded_punch(1.0, nu, 1.0, 1.0);
    assert_relative_eq!(force, spence, max_relative = 1e-2);
    assert!(force > 0.997 * spence);
}

/// Goal: the frictionless punch.
/// Reference: Boussinesq-Sneddon, F = 4 G a d / (1 - nu), drained, nu = 0.2. Tolerance: 1 %.
#[test]
fn drained_frictionless_punch_of_sneddon() {
    let nu: f64 = 0.2;
    let bulk = 2.0 * SHEAR * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu));
    let [_, force] = stiffness(0.4, bulk, 1e-3, 1.0, 1e3, false);
    assert_relative_eq!(force, flat_punch(1.0, nu, 1.0, 1.0), max_relative = 1e-2);
}

/// Goal: one history goes from the undrained to the drained limit.
/// Set-up: consolidation time a^2 / c = 4e-6 / (1e-9 * 1333) = 3000 s; ramp 0.01 s, hold 1e9 s.
/// Reference: the two closed forms above. Tolerance: 1.5 %.
#[test]
fn undrained_then_drained() {
    let nu: f64 = 0.2;
    let bulk = 2.0 * SHEAR * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu));
    let [early, late] = stiffness(0.2, bulk, 1e-12, 1e-2, 1e9, true);
    assert_relative_eq!(early, 1.012 * flat_punch(1.0, 0.5, 1.0, 1.0), max_relative = 1.5e-2);
    assert_relative_eq!(late, bonded_punch(1.0, nu, 1.0, 1.0), max_relative = 1.5e-2);
}
