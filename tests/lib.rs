//! What the tests share: whole runs of the model, problems on any mesh, closed forms.

pub mod analytical;
pub mod problem;

use poropunch::motion::protocol::Protocol;
use poropunch::parameters::{
    BranchParameters, GeometryParameters, MaterialParameters, MeshPreset, OgdenParameters,
};
use poropunch::specimen::{Discretisation, Motion, Patience, State};
use poropunch::{Instance, Model, Outputs, Parameters, Snapshot, Statistics, StepError};

/// Depth of the paper's protocols (m).
pub const DEPTH: f64 = 1e-3;
/// Loading rates of protocols P1 and P2 (m/s).
pub const RATES: [f64; 2] = [1.0e-3, 1.6e-3];

/// Table 1 on the coarse mesh.
pub fn coarse() -> Parameters {
    let mut parameters = Parameters::default();
    parameters.mesh.preset = MeshPreset::Coarse;
    parameters
}

/// Moves the punch to `position` (m) within `duration` (s).
pub fn move_to(instance: &mut Instance, position: f64, duration: f64) {
    instance.set_displacement(position);
    instance.advance(duration).expect("the step converges");
}

/// Moves the punch to `position` (m) until `time` (s).
pub fn arrive(instance: &mut Instance, position: f64, time: f64) {
    let duration = time - instance.time();
    move_to(instance, position, duration);
}

/// Results of loading to [`DEPTH`] at `rate` (m/s) from first touch and holding, at the given times (s).
pub fn load_and_hold(parameters: &Parameters, rate: f64, times_s: &[f64]) -> Vec<Outputs> {
    let model = Model::new(parameters.clone()).expect("admissible parameters");
    let mut instance = Instance::new(&model, 0.0).expect("starts at the surface");
    ramp_and_hold(&mut instance, DEPTH / rate, |time| (rate * time).min(DEPTH), times_s)
}

/// Results at the given times (s) where the punch stands at `position` (m) at a time, and comes to rest at the time `ramp` (s).
pub fn ramp_and_hold(
    instance: &mut Instance,
    ramp: f64,
    position: impl Fn(f64) -> f64,
    times_s: &[f64],
) -> Vec<Outputs> {
    let mut go = |time: f64| {
        arrive(instance, position(time), time);
        instance.outputs()
    };
    let mut results = Vec::new();
    let mut held = false;
    for &time in times_s {
        if time > ramp && !held {
            go(ramp);
            held = true;
        }
        results.push(go(time));
        held |= time == ramp;
    }
    results
}

/// Results (with their times, s) at `per_leg` times of each leg of a protocol, from its first point on.
pub fn follow(parameters: &Parameters, protocol: &Protocol, per_leg: usize) -> Vec<(f64, Outputs)> {
    try_follow(parameters, protocol, per_leg).expect("the steps converge")
}

/// The same of a model that may fail.
///
/// # Errors
/// The first step that fails.
pub fn try_follow(
    parameters: &Parameters,
    protocol: &Protocol,
    per_leg: usize,
) -> Result<Vec<(f64, Outputs)>, StepError> {
    let model = Model::new(parameters.clone()).expect("admissible parameters");
    let mut instance = Instance::new(&model, protocol.points()[0].1).expect("starts above the surface");
    let mut results = Vec::new();
    for pair in protocol.points().windows(2) {
        let ((from, a), (to, b)) = (pair[0], pair[1]);
        for k in 1..=per_leg {
            let part = k as f64 / per_leg as f64;
            instance.set_displacement(a + (b - a) * part);
            instance.advance(from + (to - from) * part - instance.time())?;
            results.push((instance.time(), instance.outputs()));
        }
    }
    Ok(results)
}

/// Checks that what follows a saved state is the same to the bit, in the instance that saved it and in another one; `starts` (m) are
/// where the two begin. It is saved in the middle of a step that was integrated ahead; returned as it is.
pub fn check_restored(model: &Model, starts: [f64; 2], outputs: fn(&Outputs) -> Vec<f64>) -> Snapshot {
    let [mut first, mut second] = starts.map(|start| Instance::new(model, start).expect("above the surface"));
    move_to(&mut first, 3e-4, 0.25);
    let snapshot = first.save();
    let run = |instance: &mut Instance| -> Vec<u64> {
        instance.restore(&snapshot).expect("its own state");
        let mut bits = Vec::new();
        for k in 0..40 {
            move_to(instance, 3e-4 + 1e-5 * f64::from(k.min(20)), 0.007);
            bits.extend(outputs(&instance.outputs()).into_iter().map(f64::to_bits));
        }
        bits
    };
    let reference = run(&mut first);
    assert_eq!(reference, run(&mut first));
    assert_eq!(reference, run(&mut second));
    snapshot
}

/// The state `dt` (s) later, the punch moving from `start` (m) at `velocity` (m/s).
pub fn step(
    specimen: &mut dyn Discretisation,
    state: &State,
    (start, velocity): (f64, f64),
    dt: f64,
) -> State {
    let motion = Motion { start, velocity };
    let step = specimen.step(state, motion, dt, Patience::Little, &mut Statistics::default());
    step.expect("the step converges").state
}

/// A cylinder of this radius and height (m) under a platen, a little wider than the mesh that is made for it.
fn under_a_platen(material: MaterialParameters, radius: f64, height: f64) -> Parameters {
    let geometry =
        GeometryParameters { punch_radius: radius, sample_radius: 1.1 * radius, sample_height: height };
    Parameters { material, geometry, ..Default::default() }
}

/// The same in a smooth ring, drained at the bottom alone.
pub fn confined_column(material: MaterialParameters, radius: f64, height: f64) -> Parameters {
    let mut parameters = under_a_platen(material, radius, height);
    let boundary = &mut parameters.boundary;
    (boundary.drained_side, boundary.drained_top, boundary.confined_side) = (false, false, true);
    parameters
}

/// A drained element between smooth plates of this radius and height (m): G = 200 Pa, a branch of 800 Pa and 0.5 s.
pub fn drained_element(radius: f64, height: f64) -> Parameters {
    let mut parameters = under_a_platen(poroelastic(200.0, 3000.0, 1e-6), radius, height);
    parameters.material.branches = vec![branch(800.0, -5.0, 0.5)];
    parameters.boundary.bonded_punch = false;
    parameters.boundary.bonded_bottom = false;
    parameters.boundary.drained_punch = true;
    parameters.solver.newton_tolerance = 1e-13;
    parameters
}

/// A material without viscous branches: shear modulus (Pa), bulk modulus (Pa), mobility K0/mu_FR (m^4/(N s)).
pub fn poroelastic(shear_modulus: f64, bulk_modulus: f64, mobility: f64) -> MaterialParameters {
    MaterialParameters {
        n0s: 0.2,
        lambda_star: bulk_modulus,
        fluid_viscosity: 1e-3,
        permeability: mobility * 1e-3,
        equilibrium: OgdenParameters { mu: shear_modulus, alpha: 2.0 },
        branches: Vec::new(),
    }
}

/// A viscous branch with shear modulus (Pa) and relaxation time (s) at small strain.
pub fn branch(shear_modulus: f64, alpha: f64, relaxation_time: f64) -> BranchParameters {
    let ogden = OgdenParameters { mu: 2.0 * shear_modulus / alpha, alpha };
    BranchParameters { ogden, eta: shear_modulus * relaxation_time }
}

/// Columns of a CSV file of this folder, without its header.
pub fn read_columns(path: &str) -> Vec<Vec<f64>> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for line in text.lines().skip(1) {
        for (k, field) in line.split(',').enumerate() {
            if columns.len() == k {
                columns.push(Vec::new());
            }
            columns[k].push(field.trim().parse().expect("a number"));
        }
    }
    columns
}

/// Linear interpolation in a table.
pub fn interpolate(x: &[f64], y: &[f64], at: f64) -> f64 {
    let k = x.partition_point(|&v| v < at).clamp(1, x.len() - 1);
    y[k - 1] + (y[k] - y[k - 1]) * (at - x[k - 1]) / (x[k] - x[k - 1])
}
