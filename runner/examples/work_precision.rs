//! Error of the force against the work it takes, in time and in space: the tables and the two figures of
//! `tests/verification/README.md`. Protocol P2, Table 1.
//!
//! ```text
//! cargo run --release -p runner --example work_precision [FOLDER]     (about five minutes)
//! ```

use poropunch::parameters::{MeshPreset, TimeScheme};
use poropunch::{Instance, Model, Parameters, Statistics};
use runner::report::plot::palette;
use runner::report::plot::{Axis, Chart, Mark};
use std::path::Path;

type Error = Box<dyn std::error::Error>;

/// Ramp of protocol P2 (s), depth (m).
const RAMP: f64 = 0.625;
const DEPTH: f64 = 1e-3;
/// Times after the end of the ramp (s).
const HOLD: [f64; 5] = [0.0, 1.0, 10.0, 30.0, 90.0];
/// Tight enough for the error in time not to matter (-).
const TIGHT: f64 = 2e-5;

struct Run {
    forces: [f64; 5],
    unknowns: usize,
    statistics: Statistics,
}

impl Run {
    /// Largest relative difference from the reference at the five times.
    fn error(&self, reference: &Self) -> f64 {
        self.forces.iter().zip(&reference.forces).fold(0.0, |m, (f, r)| f64::max(m, (f / r - 1.0).abs()))
    }
}

fn run(parameters: &Parameters) -> Result<Run, Error> {
    let model = Model::new(parameters.clone())?;
    let mut instance = Instance::new(&model, 0.0)?;
    let mut forces = [0.0; 5];
    for (force, time) in forces.iter_mut().zip(HOLD) {
        instance.set_displacement(DEPTH);
        instance.advance(RAMP + time - instance.time())?;
        *force = instance.outputs().force;
    }
    Ok(Run { forces, unknowns: model.unknowns(), statistics: instance.statistics() })
}

fn row(name: &str, run: &Run, reference: &Run) {
    print!("| {name} | {} ", run.unknowns);
    for (f, r) in run.forces.iter().zip(&reference.forces) {
        print!("| {:.4} ({:+.2} %) ", f * 1e3, 100.0 * (f / r - 1.0));
    }
    println!("| {} | {} |", run.statistics.steps, run.statistics.iterations);
}

fn header(title: &str) {
    println!("\n**{title}** - force in mN (difference from the reference)\n");
    println!("| | unknowns | peak | 1 s | 10 s | 30 s | 90 s | steps | iterations |");
    println!("|---|---|---|---|---|---|---|---|---|");
}

fn main() -> Result<(), Error> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "tests/verification/pictures".to_owned());
    std::fs::create_dir_all(&folder)?;
    let finest = presets()?;
    space(Path::new(&folder), &finest)?;
    time(Path::new(&folder))
}

/// The presets against a far finer mesh, which is returned.
fn presets() -> Result<Run, Error> {
    let mut reference = Parameters::default();
    reference.mesh.preset = MeshPreset::Fine;
    reference.mesh.edge_size = 2e-6;
    reference.mesh.growth = 1.5;
    reference.mesh.divisions = 5;
    reference.solver.tolerance = TIGHT;
    let finest = run(&reference)?;
    header("Mesh and time together");
    row("reference: edge 0.002 mm, growth 1.5, 5 divisions, tolerance 2e-5", &finest, &finest);
    for preset in [MeshPreset::Coarse, MeshPreset::Standard, MeshPreset::Fine] {
        let mut parameters = Parameters::default();
        parameters.mesh.preset = preset;
        row(&format!("{preset:?}"), &run(&parameters)?, &finest);
    }
    header("Edge size alone: growth 1.5, 4 divisions, tolerance 2e-5");
    for edge_mm in [0.25, 0.12, 0.06, 0.03, 0.015, 0.008, 0.004] {
        let mut parameters = reference.clone();
        parameters.mesh.edge_size = edge_mm * 1e-3;
        parameters.mesh.divisions = 4;
        row(&format!("{edge_mm} mm"), &run(&parameters)?, &finest);
    }
    Ok(finest)
}

/// Families of meshes: every edge size, growth and number of divisions.
fn space(folder: &Path, finest: &Run) -> Result<(), Error> {
    let mut chart = Chart::new(
        "Error of the force against the size of the mesh",
        Axis::log("unknowns"),
        Axis::log("largest error (%)"),
        (760.0, 430.0),
    );
    println!("\n**Families of meshes** (outer elements as `fine`), tolerance 2e-5\n");
    println!("| divisions | growth | edge, mm | unknowns | largest error, % |");
    println!("|---|---|---|---|---|");
    for (divisions, colour) in [(2, palette::BLUE), (3, palette::VERMILION), (4, palette::GREEN)] {
        for growth in [3.0, 2.0, 1.5] {
            let (mut unknowns, mut errors) = (Vec::new(), Vec::new());
            for edge_mm in [0.06, 0.02, 0.006, 0.002] {
                let mut parameters = Parameters::default();
                parameters.mesh.preset = MeshPreset::Fine;
                parameters.mesh.edge_size = edge_mm * 1e-3;
                parameters.mesh.growth = growth;
                parameters.mesh.divisions = divisions;
                parameters.solver.tolerance = TIGHT;
                let run = run(&parameters)?;
                let error = 100.0 * run.error(finest);
                println!("| {divisions} | {growth} | {edge_mm} | {} | {error:.3} |", run.unknowns);
                unknowns.push(run.unknowns as f64);
                errors.push(error);
            }
            let label = format!("{divisions} divisions, growth {growth}");
            let mark = if growth == 2.0 { Mark::Line } else { Mark::Dashed };
            chart = chart.with(Some(&label), colour, mark, &unknowns, &errors);
        }
    }
    let (mut unknowns, mut errors) = (Vec::new(), Vec::new());
    for preset in [MeshPreset::Coarse, MeshPreset::Standard, MeshPreset::Fine] {
        let mut parameters = Parameters::default();
        parameters.mesh.preset = preset;
        parameters.solver.tolerance = TIGHT;
        let run = run(&parameters)?;
        unknowns.push(run.unknowns as f64);
        errors.push(100.0 * run.error(finest));
    }
    println!("\npresets: {unknowns:?} unknowns, {errors:.3?} %");
    let chart = chart.with(Some("the presets"), palette::INK, Mark::Points, &unknowns, &errors);
    let chart = chart.with_reference(0.5).with_reference(0.2);
    std::fs::write(folder.join("work-precision-space.svg"), chart.to_svg())?;
    Ok(())
}

/// Both time schemes on the standard mesh, against a tolerance of 1e-6.
fn time(folder: &Path) -> Result<(), Error> {
    let mut chart = Chart::new(
        "Error of the force against the steps of P2's first cycle",
        Axis::log("accepted steps"),
        Axis::log("largest error (%)"),
        (760.0, 430.0),
    );
    let mut tight = Parameters::default();
    tight.solver.tolerance = 1e-6;
    let exact = run(&tight)?;
    header("Time, standard mesh, against a tolerance of 1e-6");
    for (scheme, name, colour) in [
        (TimeScheme::Sdirk2, "SDIRK2 (two stages)", palette::BLUE),
        (TimeScheme::BackwardEuler, "backward Euler", palette::VERMILION),
    ] {
        let (mut steps, mut errors) = (Vec::new(), Vec::new());
        for tolerance in [3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5] {
            let mut parameters = Parameters::default();
            parameters.solver.tolerance = tolerance;
            parameters.solver.time_scheme = scheme;
            let run = run(&parameters)?;
            row(&format!("{scheme:?}, tolerance {tolerance:.0e}"), &run, &exact);
            steps.push(run.statistics.steps as f64);
            errors.push(100.0 * run.error(&exact));
        }
        chart = chart.with(Some(name), colour, Mark::Line, &steps, &errors);
        chart = chart.with(None, colour, Mark::Points, &steps, &errors);
    }
    std::fs::write(folder.join("work-precision-time.svg"), chart.to_svg())?;
    Ok(())
}
