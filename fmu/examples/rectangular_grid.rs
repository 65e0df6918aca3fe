//! The axisymmetric model on a rectangular grid graded towards the punch's edge, the section of the
//! three-dimensional mesh: what the edge element size alone does to the force along P2.
//!
//! ```text
//! cargo run --release -p poropunch --example rectangular_grid [edge size in mm]...
//! ```

use poropunch::mesh::Mesh;
use poropunch::motion::path::Path;
use poropunch::specimen::Sample;
use poropunch::specimen::Stepper;
use poropunch::{Parameters, Statistics};
use std::sync::Arc;

/// Distances from the edge: sizes start with `first` twice and grow by 1.6 to at most `largest`, up to `length`.
fn graded(length: f64, first: f64, largest: f64) -> Vec<f64> {
    let mut sizes = vec![first];
    let mut size = first;
    while sizes.iter().sum::<f64>() < length {
        sizes.push(size);
        size = (1.6 * size).min(largest);
    }
    let total: f64 = sizes.iter().sum();
    // The excess is taken out of the larger elements.
    let excess = total - length;
    let weight: f64 = sizes.iter().map(|s| s * s).sum();
    let mut distance = 0.0;
    let mut lines: Vec<f64> = sizes
        .iter()
        .map(|s| {
            distance += s - excess * s * s / weight;
            distance
        })
        .collect();
    *lines.last_mut().expect("not empty") = length;
    lines
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let parameters = Parameters::default();
    let g = &parameters.geometry;
    println!("edge_mm,unknowns,peak_mN,after_1_s_mN,after_10_s_mN,after_90_s_mN");
    let edges: Result<Vec<f64>, _> = std::env::args().skip(1).map(|a| a.parse()).collect();
    for edge_mm in edges? {
        let (a, b, h) = (g.punch_radius, g.sample_radius, g.sample_height);
        let edge = edge_mm * 1e-3;
        let mut radii: Vec<f64> = graded(a, edge, 0.5e-3).into_iter().rev().map(|x| a - x).collect();
        radii[0] = 0.0;
        radii.push(a);
        radii.extend(graded(b - a, edge, 2e-3).into_iter().map(|x| a + x));
        let mut heights: Vec<f64> = graded(h, edge, 2e-3).into_iter().rev().map(|x| h - x).collect();
        heights[0] = 0.0;
        heights.push(h);
        let mesh = Mesh::tensor(&radii, &heights, a);
        let unknowns = mesh.unknowns();
        let mut stepper = Stepper::new(&parameters.setup(), Arc::new(Sample::from_mesh(mesh)?));
        let mut path = Path::touch(&stepper, 0.0);
        let mut statistics = Statistics::default();
        let (ramp, depth) = (1e-3 / 1.6e-3, 1e-3);
        let (mut now, mut from) = (0.0, 0.0);
        print!("{edge_mm},{unknowns}");
        for end in [ramp, ramp + 1.0, ramp + 10.0, ramp + 90.0] {
            let o = path.advance(
                &mut stepper,
                &parameters.solver,
                a,
                (now, from),
                (end, depth),
                &mut statistics,
            )?;
            (now, from) = (end, depth);
            print!(",{:.4}", 1e3 * o.force);
        }
        println!("  {statistics:?}");
    }
    Ok(())
}
