//! The first loading and hold of protocol P2 through the native API.
//!
//! ```text
//! cargo run --release -p poropunch --example p2_cycle [mesh.edge_size_mm] [growth] [divisions] [tolerance]
//! ```

use poropunch::{Instance, Model, Parameters};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut parameters = Parameters::default();
    let mut arguments = std::env::args().skip(1).map(|a| a.parse::<f64>());
    if let Some(edge_mm) = arguments.next() {
        parameters.mesh.edge_size = edge_mm? * 1e-3;
    }
    if let Some(growth) = arguments.next() {
        parameters.mesh.growth = growth?;
    }
    if let Some(divisions) = arguments.next() {
        parameters.mesh.divisions = divisions? as u32;
    }
    if let Some(tolerance) = arguments.next() {
        parameters.solver.tolerance = tolerance?;
    }
    let model = Model::new(parameters)?;
    println!("{} elements, {} unknowns", model.elements(), model.unknowns());
    let mut instance = Instance::new(&model, 0.0)?;

    // 1 mm at 1.6 mm/s, then hold.
    let (depth, ramp) = (1e-3, 1e-3 / 1.6e-3);
    let start = std::time::Instant::now();
    println!("time_s,displacement_mm,force_mN,force_fluid_mN,force_traction_mN");
    let mut report = |time: f64| -> Result<(), Box<dyn std::error::Error>> {
        instance.set_displacement(depth * (time / ramp).min(1.0));
        instance.advance(time - instance.time())?;
        let o = instance.outputs();
        let [depth, force, fluid, traction] =
            [o.displacement, o.force, o.force_fluid, o.force_traction].map(|x| x * 1e3);
        println!("{time},{depth:.4},{force:.4},{fluid:.4},{traction:.4}");
        Ok(())
    };
    for time in [0.1, 0.3, 0.5, ramp, ramp + 1.0, ramp + 10.0, ramp + 30.0, ramp + 90.0] {
        report(time)?;
    }
    let (o, s) = (instance.outputs(), instance.statistics());
    let dissipated = o.viscous_dissipation + o.porous_dissipation;
    println!("work {:.4e} J = stored {:.4e} + dissipated {dissipated:.4e}", o.external_work, o.stored_energy);
    println!("{s:?}, {:.2} s", start.elapsed().as_secs_f64());
    Ok(())
}
