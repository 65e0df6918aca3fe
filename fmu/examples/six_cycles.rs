//! All cycles of protocol P1 or P2 through the native API: force curve on standard output, cost on standard error.
//!
//! ```text
//! cargo run --release -p poropunch --example six_cycles [P1|P2] [coarse|standard|fine] [cycles] [sensitivities]
//! ```

use poropunch::motion::protocol::Trapezoid;
use poropunch::parameters::MeshPreset;
use poropunch::{Instance, Model, Parameters};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let given = |k: usize| arguments.get(k).map(String::as_str);
    let trapezoid = if given(0) == Some("P1") { Trapezoid::p1() } else { Trapezoid::p2() };
    let cycles = given(2).map_or(Ok(6), str::parse)?;
    let mut parameters = Parameters::default();
    parameters.mesh.preset = match given(1) {
        Some("coarse") => MeshPreset::Coarse,
        Some("fine") => MeshPreset::Fine,
        _ => MeshPreset::Standard,
    };
    parameters.solver.sensitivities = given(3) == Some("sensitivities");
    if let Ok(f) = std::env::var("MU") {
        parameters.boundary.friction = f.parse()?;
    }
    let model = Model::new(parameters)?;
    let protocol = Trapezoid { cycles, ..trapezoid }.protocol()?;
    let points = protocol.points();
    let mut instance = Instance::new(&model, points[0].1)?;
    println!("time_s,displacement_mm,force_mN,force_fluid_mN,work_uJ,stored_uJ,dissipated_uJ");
    let start = std::time::Instant::now();
    let mut before = instance.statistics();
    for pair in points.windows(2) {
        let ((from, a), (to, b)) = (pair[0], pair[1]);
        for k in 1..=40 {
            // A rest is sampled ever more sparsely.
            let part = f64::from(k) / 40.0;
            let part = if a == b { part * part * part } else { part };
            let time = if k == 40 { to } else { from + part * (to - from) };
            instance.set_displacement(a + (b - a) * part);
            if time - instance.time() <= 0.0 {
                continue;
            }
            instance.advance(time - instance.time())?;
            let o = instance.outputs();
            println!(
                "{time:.6},{:.6},{:.6},{:.6},{:.6},{:.6},{:.6}",
                o.displacement * 1e3,
                o.force * 1e3,
                o.force_fluid * 1e3,
                o.external_work * 1e6,
                o.stored_energy * 1e6,
                (o.viscous_dissipation + o.porous_dissipation) * 1e6
            );
        }
        let s = instance.statistics();
        eprintln!(
            "to {to:8.3} s, {:7.3} mm: {:3} steps, {:4} iterations, {:2} cuts",
            b * 1e3,
            s.steps - before.steps,
            s.iterations - before.iterations,
            s.cuts - before.cuts
        );
        before = s;
    }
    eprintln!("{:?}, {:.2} s", instance.statistics(), start.elapsed().as_secs_f64());
    Ok(())
}
