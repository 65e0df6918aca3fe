//! Protocol P2's first loading and hold on the paper's three-dimensional mesh: force, cost, memory.
//!
//! ```text
//! cargo run --release -p poropunch --example paper_3d [paper | coarse] [solver.newton_tolerance] [seconds of hold]
//! ```

use cpu_time::ProcessTime;
use poropunch::motion::path::Path;
use poropunch::solid3d::forest::{COARSE, PAPER};
use poropunch::solid3d::sample::SolidSample;
use poropunch::solid3d::step::SolidStepper;
use poropunch::{Parameters, Statistics};
use std::sync::Arc;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let refinement = if arguments.next().as_deref() == Some("coarse") { COARSE } else { PAPER };
    let mut parameters = Parameters::default();
    if let Some(tolerance) = arguments.next() {
        parameters.solver.newton_tolerance = tolerance.parse()?;
    }
    let hold: f64 = arguments.next().map_or(Ok(90.0), |t| t.parse())?;
    let sample = Arc::new(SolidSample::new(&parameters.geometry, refinement)?);
    let mesh = &sample.mesh;
    println!(
        "{} cells, {} unknowns ({} with those of hanging nodes), edge cell {:.4} mm, {:?}",
        mesh.cells.len(),
        mesh.unknowns(),
        mesh.unknowns_with_hanging(),
        1e3 * mesh.edge_size(),
        sample.symbolic.statistics()
    );
    let mut stepper = SolidStepper::new(&parameters, sample.clone());
    println!("set-up: {:.1} s of CPU", ProcessTime::now().as_duration().as_secs_f64());
    let mut path = Path::touch(&stepper, 0.0);
    let mut statistics = Statistics::default();
    let (ramp, depth, radius) = (1e-3 / 1.6e-3, 1e-3, parameters.geometry.punch_radius);
    let (mut now, mut from) = (0.0, 0.0);
    println!(
        "time_s,displacement_mm,force_mN,force_fluid_mN,force_traction_mN  steps, iterations, factorisations"
    );
    let hold_times = [0.3, 1.0, 3.0, 10.0, 30.0, 90.0].into_iter().filter(|t| *t <= hold).map(|t| ramp + t);
    for end in [0.001, 0.01, 0.1, 0.3, 0.5, ramp].into_iter().chain(hold_times) {
        let to = depth * (end / ramp).min(1.0);
        let solver = &parameters.solver;
        let o = path.advance(&mut stepper, solver, radius, (now, from), (end, to), &mut statistics)?;
        (now, from) = (end, to);
        println!(
            "{end:.4},{:.4},{:.4},{:.4},{:.4}  {statistics:?}, {} GMRES iterations, {:.1} s of CPU",
            1e3 * o.displacement,
            1e3 * o.force,
            1e3 * o.force_fluid,
            1e3 * o.force_traction,
            stepper.linear_iterations(),
            ProcessTime::now().as_duration().as_secs_f64()
        );
    }
    // Linux keeps the largest resident set.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status.lines().filter(|l| l.starts_with("VmHWM")).for_each(|l| println!("{l}"));
    Ok(())
}
