//! Local balance of the fluid.
//!
//! Goal: what a region inside the sample loses of its volume flows out through its boundary. Mesh: n x n elements on a disc of radius and height 1. Boundary
//! conditions: bonded plates, the upper one pressed by 20 % in one go; the side is drained. Parameters: G = 1, K = 2, mobility 0.3, a step of 0.05 after one of
//! 0.02. Region: r < 1/2, z > 1/4, whose boundary inside the sample runs along element sides. Reference, by two ways that share nothing:
//! the change of J in 5 x 5 points, and the Darcy flux (Eq. 11) through the sides from the gradient of the pressure at both of their elements.

use poropunch::element::History;
use poropunch::mesh::Mesh;
use std::f64::consts::TAU;
use tests::poroelastic;
use tests::problem::{GAUSS_5, Place, Problem};

const MOBILITY: f64 = 0.3;
const SOLID: f64 = 0.2;

/// Volume that the region loses in the second step, and what flows out meanwhile.
fn balance(n: usize) -> (f64, f64) {
    let lines: Vec<f64> = (0..=n).map(|k| k as f64 / n as f64).collect();
    let mut problem = Problem::new(Mesh::tensor(&lines, &lines, 1.0), &poroelastic(1.0, 2.0, MOBILITY));
    for (node, at) in problem.sample.mesh.nodes.clone().iter().enumerate() {
        let first = problem.sample.mesh.displacement(node as u32);
        if at[1] < 1e-9 || at[1] > 1.0 - 1e-9 {
            problem.prescribed[first] = Some(0.0);
            problem.prescribed[first + 1] = Some(if at[1] > 0.5 { -0.2 } else { 0.0 });
        }
        if let Some(p) = problem.sample.mesh.pressure(node as u32).filter(|_| at[0] > 1.0 - 1e-9) {
            problem.prescribed[p] = Some(0.0);
        }
    }
    // Homogeneous compression to start from.
    let mut x = vec![0.0; problem.sample.mesh.unknowns()];
    for (node, at) in problem.sample.mesh.nodes.iter().enumerate() {
        x[problem.sample.mesh.displacement(node as u32) + 1] = -0.2 * at[1];
    }
    let undeformed = problem.undeformed();
    problem.step(&mut x, &undeformed, 0.02).expect("a solution");
    let old: History = problem.advanced(&x, &undeformed, 0.02);
    let volume = |x: &[f64]| {
        let mut sum = 0.0;
        problem.at_points(x, |_, place, fields| {
            if place.at[0] < 0.5 && place.at[1] > 0.25 {
                sum += place.measure * fields.deformation(place.at[0]).2;
            }
        });
        sum
    };
    let before = volume(&x);
    let dt = 0.05;
    let mut later = Problem::new(problem.sample.mesh.clone(), &poroelastic(1.0, 2.0, MOBILITY));
    later.prescribed.clone_from(&problem.prescribed);
    later.step(&mut x, &old, dt).expect("a solution");
    let lost = before - volume(&x);

    // Reference flux through a side: J k F^-1 F^-T Grad p . N.
    let mut outflow = 0.0;
    for (e, element) in problem.sample.mesh.elements.iter().enumerate() {
        let x_e = problem.sample.map.gather(e, &x);
        let [low, high] = [element.corners[0], element.corners[3]];
        let (radial, axial) = ([low[0], high[0]], [low[1], high[1]]);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        // The side r = 1/2 above z = 1/4 and the side z = 1/4 within r = 1/2, seen from both sides.
        for (d, at, inside) in [(0, 0.5, axial[0] > 0.25 - 1e-9), (1, 0.25, radial[1] < 0.5 + 1e-9)] {
            let bounds = [radial, axial][d];
            let Some(end) = bounds.iter().position(|&b| near(b, at)).filter(|_| inside) else { continue };
            let length = [axial[1] - axial[0], radial[1] - radial[0]][d];
            for (s, weight) in GAUSS_5 {
                let mut xi = [s, s];
                xi[d] = [-1.0, 1.0][end];
                let place = Place::new(&element.corners, xi, 1.0);
                let fields = place.fields(&x_e);
                let (f, _, j) = fields.deformation(place.at[0]);
                let det = f[0][0] * f[1][1] - f[0][1] * f[1][0];
                let inverse = [[f[1][1] / det, -f[0][1] / det], [-f[1][0] / det, f[0][0] / det]];
                let spatial: [f64; 2] = std::array::from_fn(|i| {
                    inverse[0][i] * fields.grad_p[0] + inverse[1][i] * fields.grad_p[1]
                });
                let reference = inverse[d][0] * spatial[0] + inverse[d][1] * spatial[1];
                let flux = -j * MOBILITY * (j - SOLID) / (1.0 - SOLID) * reference;
                let outwards = [1.0, -1.0][d];
                // Half from each side.
                outflow += 0.5 * outwards * flux * TAU * place.at[0] * 0.5 * length * weight * dt;
            }
        }
    }
    (lost, outflow)
}

/// Tolerance: 2 % on 8 x 8 elements, and the difference falls at least threefold from there to 16 x 16 (order 1.6).
#[test]
fn a_region_loses_what_flows_out() {
    let relative = |n: usize| {
        let (lost, outflow) = balance(n);
        println!("{n} x {n}: lost {lost:.6}, flown out {outflow:.6}");
        (outflow / lost - 1.0).abs()
    };
    let (coarse, fine) = (relative(8), relative(16));
    assert!(coarse < 2e-2 && 3.0 * fine < coarse, "{coarse:e} {fine:e}");
}
