//! Scratch: cost of a recorded motion.
use poropunch::parameters::*;
use poropunch::{Instance, Model, Parameters};
fn main() {
    let t: Vec<(f64, f64)> = std::env::var("CLEAN")
        .unwrap()
        .split(',')
        .map(|p| {
            let (a, b) = p.split_once(':').unwrap();
            (a.parse().unwrap(), 1e-3 * b.parse::<f64>().unwrap())
        })
        .collect();
    let end = t.last().unwrap().0;
    let protocol = poropunch::motion::protocol::Protocol::new(t).unwrap();
    let mut times = vec![];
    let mut x = 0.0;
    while x < end {
        times.push(x);
        x = if x < 3.0 { x + 0.01 } else { x * 1.01 };
    }
    times.push(end);
    let mut p = Parameters::default();
    p.mesh.preset = MeshPreset::Coarse;
    if std::env::var("SPHERE").is_ok() {
        p.indenter = IndenterParameters {
            profile: IndenterProfile::Sphere,
            sphere_radius: 1.5e-4,
            ..Default::default()
        };
        p.geometry.punch_radius = 1.5e-4;
    }
    if std::env::var("FREE").is_ok() {
        p.boundary.bonded_punch = false;
    }
    if let Ok(f) = std::env::var("STIFF") {
        let f: f64 = f.parse().unwrap();
        p.material.equilibrium.mu *= f;
        for b in &mut p.material.branches {
            b.ogden.mu *= f;
            b.eta *= f;
        }
    }
    let var = |n: &str| std::env::var(n).ok().and_then(|v| v.parse::<f64>().ok());
    if let Some(v) = var("TOL") {
        p.solver.tolerance = v;
    }
    if let Some(v) = var("NT") {
        p.solver.newton_tolerance = v;
    }
    if let Some(v) = var("INC") {
        p.solver.initial_increment = v;
    }
    if let Some(v) = var("GROW") {
        p.mesh.growth = v;
    }
    if let Some(v) = var("EDGE") {
        p.mesh.edge_size = v;
    }
    if std::env::var("STD").is_ok() {
        p.mesh.preset = MeshPreset::Standard;
    }
    if let Some(v) = var("LAM") {
        p.material.lambda_star = v;
    }
    if let Some(v) = var("K0") {
        p.material.permeability = v;
    }
    if let Some(v) = var("SIZE") {
        p.geometry.sample_radius = v;
        p.geometry.sample_height = v;
    }
    if std::env::var("SENS").is_ok() {
        p.solver.sensitivities = true;
    }
    let clock = std::time::Instant::now();
    let t0 = protocol.start_time();
    let model = Model::new(p).unwrap();
    let mut i = Instance::new(&model, protocol.displacement(t0)).unwrap();
    let mut t = t0;
    let mut peak = (0.0_f64, 0.0);
    for &target in times.iter() {
        let stops: Vec<f64> =
            protocol.breakpoints_between(t, target).iter().map(|p| p.0).chain([target]).collect();
        for s in stops {
            if s > t {
                i.set_displacement(protocol.displacement(s));
                if let Err(e) = i.advance(s - t) {
                    println!("failed at {t}: {e}");
                    return;
                }
                t = s;
            }
        }
        if std::env::var("P").is_ok() {
            let s = i.statistics();
            println!("{t:.3} {:.4} {} {} {}", i.outputs().force * 1e3, s.steps, s.iterations, s.cuts);
        }
        if i.outputs().force > peak.0 {
            peak = (i.outputs().force, t);
        }
    }
    println!(
        "peak {:.5} mN at {} end {:.5}; {:?}; {:.2} s",
        peak.0 * 1e3,
        peak.1,
        i.outputs().force * 1e3,
        i.statistics(),
        clock.elapsed().as_secs_f64()
    );
}
