//! Convergence of the force in space and time: the tables of `tests/verification/README.md`.
//!
//! ```text
//! cargo run --release -p poropunch --example convergence
//! ```

use poropunch::parameters::{MeshPreset, TimeScheme};
use poropunch::{Instance, Model, Parameters, Statistics};

type Error = Box<dyn std::error::Error>;

/// Ramp of protocol P2 (s), depth (m).
const RAMP: f64 = 0.625;
const DEPTH: f64 = 1e-3;
/// Times after the end of the ramp (s).
const HOLD: [f64; 5] = [0.0, 1.0, 10.0, 30.0, 90.0];

struct Run {
    forces: [f64; 5],
    unknowns: usize,
    statistics: Statistics,
    seconds: f64,
}

fn run(parameters: &Parameters) -> Result<Run, Error> {
    let model = Model::new(parameters.clone())?;
    let start = std::time::Instant::now();
    let mut instance = Instance::new(&model, 0.0)?;
    let mut forces = [0.0; 5];
    for (force, time) in forces.iter_mut().zip(HOLD) {
        instance.set_displacement(DEPTH);
        instance.advance(RAMP + time - instance.time())?;
        *force = instance.outputs().force;
    }
    let seconds = start.elapsed().as_secs_f64();
    Ok(Run { forces, unknowns: model.unknowns(), statistics: instance.statistics(), seconds })
}

fn row(name: &str, run: &Run, reference: &Run) {
    print!("| {name} | {} ", run.unknowns);
    for (f, r) in run.forces.iter().zip(&reference.forces) {
        print!("| {:.4} ({:+.2} %) ", f * 1e3, 100.0 * (f / r - 1.0));
    }
    println!("| {} | {} | {:.2} |", run.statistics.steps, run.statistics.iterations, run.seconds);
}

fn header(title: &str) {
    println!("\n**{title}** - force in mN (difference from the reference)\n");
    println!("| | unknowns | peak | 1 s | 10 s | 30 s | 90 s | steps | iterations | wall s |");
    println!("|---|---|---|---|---|---|---|---|---|---|");
}

fn main() -> Result<(), Error> {
    let mut reference = Parameters::default();
    reference.mesh.preset = MeshPreset::Fine;
    reference.mesh.edge_size = 2e-6;
    reference.mesh.growth = 1.5;
    reference.mesh.divisions = 5;
    reference.solver.tolerance = 2e-5;
    let finest = run(&reference)?;

    header("Mesh and time together, P2, Table 1");
    row("reference: edge 0.002 mm, growth 1.5, 5 divisions, tolerance 2e-5", &finest, &finest);
    for preset in [MeshPreset::Coarse, MeshPreset::Standard, MeshPreset::Fine] {
        let mut parameters = Parameters::default();
        parameters.mesh.preset = preset;
        row(&format!("{preset:?}"), &run(&parameters)?, &finest);
    }

    header("Edge size, growth 1.5, 4 divisions, tolerance 2e-5");
    for edge_mm in [0.25, 0.12, 0.06, 0.03, 0.015, 0.008, 0.004] {
        let mut parameters = reference.clone();
        parameters.mesh.edge_size = edge_mm * 1e-3;
        parameters.mesh.divisions = 4;
        row(&format!("{edge_mm} mm"), &run(&parameters)?, &finest);
    }

    header("Time, standard mesh");
    let mut tight = Parameters::default();
    tight.solver.tolerance = 1e-6;
    let exact = run(&tight)?;
    for scheme in [TimeScheme::Sdirk2, TimeScheme::BackwardEuler] {
        for tolerance in [1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5] {
            let mut parameters = Parameters::default();
            parameters.solver.tolerance = tolerance;
            parameters.solver.time_scheme = scheme;
            row(&format!("{scheme:?}, tolerance {tolerance:.0e}"), &run(&parameters)?, &exact);
        }
    }
    Ok(())
}
