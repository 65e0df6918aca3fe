//! Method of manufactured solutions: orders of convergence at finite strain.
//!
//! Goal: the element converges as its functions allow, u with the orders 3 (L2) and 2 (H1), p with 2 and 1, on graded and on distorted
//! meshes. Mesh: n x n elements on a disc of radius and height 1; rows and columns graded like `s^1.5`; inner corners displaced by up to a
//! fifth of an element, anew on every mesh, so that its elements do not become parallelograms. Boundary conditions: u and p
//! prescribed on the whole boundary (u_r = 0 on the axis). Parameters: G = 1, lambda* = 3, n0S = 0.2, mobility 0.5, one step of 0.3 from the
//! undeformed state; strains up to 0.25. Reference: `u_r = 0.15 r cos z (1 - r^2/3)`, `u_z = -0.15 sin(1.5 z) (1 - r^2/2)`,
//! `p = cos 2z + r^2 (1 - z)`; loads are the weak form of that solution, with the laws written out below, in 5 x 5 points.

use poropunch::mesh::{CORNERS, Mesh, NODES};
use tests::poroelastic;
use tests::problem::{Fields, Place, Problem, warped};

const SHEAR: f64 = 1.0;
const BULK: f64 = 3.0;
/// Solid fraction of [`poroelastic`].
const SOLID: f64 = 0.2;
const DT: f64 = 0.3;
const SIZE: f64 = 0.15;

/// Mobility and size of the pore pressure.
#[derive(Clone, Copy)]
struct Case {
    mobility: f64,
    pressure: f64,
}

fn exact(case: Case, [r, z]: [f64; 2]) -> Fields {
    let (sin, cos) = (1.5 * z).sin_cos();
    Fields {
        u: [SIZE * r * z.cos() * (1.0 - r * r / 3.0), -SIZE * sin * (1.0 - 0.5 * r * r)],
        grad_u: [
            [SIZE * z.cos() * (1.0 - r * r), -SIZE * r * z.sin() * (1.0 - r * r / 3.0)],
            [SIZE * sin * r, -1.5 * SIZE * cos * (1.0 - 0.5 * r * r)],
        ],
        p: case.pressure * ((2.0 * z).cos() + r * r * (1.0 - z)),
        grad_p: [2.0 * r * (1.0 - z), -2.0 * (2.0 * z).sin() - r * r].map(|g| case.pressure * g),
    }
}

/// Nodal forces and fluid volumes of the exact solution at one point per unit measure, for the functions of `place`.
fn weak_form(case: Case, place: &Place) -> ([[f64; 2]; NODES], [f64; CORNERS]) {
    let f = exact(case, place.at);
    let (plane, hoop, j) = f.deformation(place.at[0]);
    let d = plane[0][0] * plane[1][1] - plane[0][1] * plane[1][0];
    let push = |g: [f64; 2]| {
        [(g[0] * plane[1][1] - g[1] * plane[1][0]) / d, (g[1] * plane[0][0] - g[0] * plane[0][1]) / d]
    };
    // b = F F^T: rr, zz, tt, rz. An Ogden term of exponent 2 is a neo-Hookean solid.
    let b = [
        plane[0][0].powi(2) + plane[0][1].powi(2),
        plane[1][0].powi(2) + plane[1][1].powi(2),
        hoop * hoop,
        plane[0][0] * plane[1][0] + plane[0][1] * plane[1][1],
    ];
    let mean = (b[0] + b[1] + b[2]) / 3.0;
    let open = 1.0 - SOLID;
    let spherical = BULK * open * open * (j / open - j / (j - SOLID)) - f.p * j;
    let isochoric = SHEAR * j.powf(-2.0 / 3.0);
    let [rr, zz, tt] = [0, 1, 2].map(|i| isochoric * (b[i] - mean) + spherical);
    let rz = isochoric * b[3];
    let radius = place.at[0] + f.u[0];
    let forces = std::array::from_fn(|a| {
        let g = push(place.gradient[a]);
        [rr * g[0] + rz * g[1] + tt * place.n[a] / radius, rz * g[0] + zz * g[1]]
    });
    let mobility = j * case.mobility * (j - SOLID) / open;
    let grad_p = push(f.grad_p);
    let volumes = std::array::from_fn(|m| {
        let g = push(place.pressure_gradient[m]);
        place.p[m] * (j - 1.0) + DT * mobility * (g[0] * grad_p[0] + g[1] * grad_p[1])
    });
    (forces, volumes)
}

/// Displaced corners: a number between -1 and 1 that belongs to a place.
fn noise(x: [f64; 2]) -> [f64; 2] {
    let hash = |a: f64, b: f64| 2.0 * ((12.9898 * a + 78.233 * b).sin() * 43_758.547).rem_euclid(1.0) - 1.0;
    [hash(x[0], x[1]), hash(x[1] + 0.5, x[0])]
}

fn mesh(n: usize, grading: f64, distortion: f64) -> Mesh {
    let lines: Vec<f64> = (0..=n).map(|k| (k as f64 / n as f64).powf(grading)).collect();
    let inside = |v: f64| v > 1e-9 && v < 1.0 - 1e-9;
    warped(Mesh::tensor(&lines, &lines, 1.0), |x| {
        if !(inside(x[0]) && inside(x[1])) {
            return x;
        }
        let shift = noise(x);
        // A fifth of the local distance of the lines.
        let step = |v: f64| (v.powf(1.0 / grading) + 1.0 / n as f64).powf(grading) - v;
        std::array::from_fn(|d| x[d] + distortion * step(x[d]) / 2.0_f64.powf(grading - 1.0) * shift[d])
    })
}

/// Errors of u (L2, H1) and p (L2, H1) relative to the exact norms.
fn errors(case: Case, n: usize, grading: f64, distortion: f64) -> [f64; 4] {
    let mut problem = Problem::new(mesh(n, grading, distortion), &poroelastic(SHEAR, BULK, case.mobility));
    let nodes = problem.sample.mesh.nodes.clone();
    let mut x = vec![0.0; problem.sample.mesh.unknowns()];
    let edge = |v: f64| !(1e-9..=1.0 - 1e-9).contains(&v);
    for (node, at) in nodes.iter().enumerate() {
        let (first, pressure) =
            (problem.sample.mesh.displacement(node as u32), problem.sample.mesh.pressure(node as u32));
        let value = exact(case, *at);
        (x[first], x[first + 1]) = (value.u[0], value.u[1]);
        if let Some(p) = pressure {
            x[p] = value.p;
        }
        // The axis is no boundary of the axial displacement nor of the pressure.
        if edge(at[1]) || at[0] > 1.0 - 1e-9 {
            problem.prescribed[first] = Some(value.u[0]);
            problem.prescribed[first + 1] = Some(value.u[1]);
            if let Some(p) = pressure {
                problem.prescribed[p] = Some(value.p);
            }
        }
    }
    let mut loads = vec![0.0; x.len()];
    problem.at_points(&x, |element, place, _| {
        let (forces, volumes) = weak_form(case, place);
        let unknowns = &problem.sample.map.unknowns[element];
        let values = forces.as_flattened().iter().chain(&volumes);
        unknowns.iter().zip(values).for_each(|(&u, value)| loads[u as usize] += place.measure * value);
    });
    problem.loads = loads;
    problem.step(&mut x, &problem.undeformed(), DT).expect("a solution");
    let (mut error, mut norm) = ([0.0; 4], [0.0; 4]);
    problem.at_points(&x, |_, place, found| {
        let sought = exact(case, place.at);
        let squares = |f: &Fields| {
            let gradient = f.grad_u.as_flattened().iter().map(|g| g * g).sum::<f64>();
            [
                f.u[0] * f.u[0] + f.u[1] * f.u[1],
                gradient + (f.u[0] / place.at[0]).powi(2),
                f.p * f.p,
                f.grad_p[0] * f.grad_p[0] + f.grad_p[1] * f.grad_p[1],
            ]
        };
        let pair = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
        let difference = Fields {
            u: pair(found.u, sought.u),
            grad_u: [pair(found.grad_u[0], sought.grad_u[0]), pair(found.grad_u[1], sought.grad_u[1])],
            p: found.p - sought.p,
            grad_p: pair(found.grad_p, sought.grad_p),
        };
        for k in 0..4 {
            error[k] += place.measure * squares(&difference)[k];
            norm[k] += place.measure * squares(&sought)[k];
        }
    });
    std::array::from_fn(|k| (error[k] / norm[k]).sqrt())
}

/// Tolerance: orders at most 0.25 below `expected` from the second finest mesh to the finest.
fn check(case: Case, expected: [f64; 4], sizes: &[usize]) {
    for (name, grading, distortion) in [("uniform", 1.0, 0.0), ("graded", 1.5, 0.0), ("distorted", 1.5, 0.2)]
    {
        let mut last: Option<[f64; 4]> = None;
        let mut orders = [0.0; 4];
        for &n in sizes {
            let found = errors(case, n, grading, distortion);
            if let Some(last) = last {
                orders = std::array::from_fn(|k| (last[k] / found[k]).log2());
            }
            let errors = found.map(|e| format!("{e:.2e}")).join(" ");
            println!("{name:9} {n:3}  {errors}  {orders:.2?}");
            last = Some(found);
        }
        assert!(
            orders.iter().zip(expected).all(|(order, expected)| order - expected > -0.25),
            "{name}: {orders:?}"
        );
    }
}

const DRAINING: (Case, [f64; 4]) = (Case { mobility: 0.5, pressure: 1.0 }, [2.0, 2.0, 2.0, 1.0]);
const UNDRAINED: (Case, [f64; 4]) = (Case { mobility: 1e-9, pressure: 1.0 }, [3.0, 2.0, 2.0, 1.0]);

#[test]
fn orders_of_convergence() {
    for (case, expected) in [DRAINING, UNDRAINED] {
        check(case, expected, &[8, 16]);
    }
}

#[test]
#[ignore = "long: meshes of up to 32 x 32 elements"]
fn orders_of_convergence_on_fine_meshes() {
    for (case, expected) in [DRAINING, UNDRAINED] {
        check(case, expected, &[4, 8, 16, 32]);
    }
}
