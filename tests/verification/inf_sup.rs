//! Stability of the pair of displacement and pressure, and of the drained volumetric rule.
//!
//! Goal: the inf-sup constant `min_q max_v (q, div v) / (|q| |v|)` does not fall when the mesh is refined; no checkerboard in the effective
//! stress of a nearly incompressible skeleton. Mesh: n x n elements on a disc of radius and height 1, uniform and graded like `s^3`.
//! Boundary conditions: u = 0 on top, bottom and side, u_r = 0 on the axis; the constant pressure is left out. |v| is the norm of
//! the strain, |q| that of L2 in a measure `2 pi R dA`. Reference: for comparison the same with the displacement linear on every element side, which is
//! known to be unstable.

use nalgebra::{Cholesky, DMatrix, SymmetricEigen};
use poropunch::mesh::{Mesh, NODES};
use tests::poroelastic;
use tests::problem::{Place, Problem};

fn problem(n: usize, grading: f64) -> Problem {
    let lines: Vec<f64> = (0..=n).map(|k| (k as f64 / n as f64).powf(grading)).collect();
    // 2 G e : e = e : e.
    let mut problem = Problem::new(Mesh::tensor(&lines, &lines, 1.0), &poroelastic(0.5, 1.0 / 3.0, 1.0));
    for (node, at) in problem.sample.mesh.nodes.clone().iter().enumerate() {
        let first = problem.sample.mesh.displacement(node as u32);
        if at[0] > 1.0 - 1e-9 || at[1] < 1e-9 || at[1] > 1.0 - 1e-9 {
            problem.prescribed[first] = Some(0.0);
            problem.prescribed[first + 1] = Some(0.0);
        }
    }
    problem
}

/// Smallest constants, ascending: roots of the eigenvalues of `M^-1 B A^-1 B^T` for a basis of the displacements (columns of `basis`).
fn constants(a: &DMatrix<f64>, b: &DMatrix<f64>, mass: &DMatrix<f64>, basis: &DMatrix<f64>) -> Vec<f64> {
    let (a, b) = (basis.transpose() * a * basis, b * basis);
    let schur = &b * Cholesky::new(a).expect("rigid supports").solve(&b.transpose());
    let root = Cholesky::new(mass.clone()).expect("a norm").l();
    let half = root.solve_lower_triangular(&schur).expect("a norm");
    let whole = root.solve_lower_triangular(&half.transpose()).expect("a norm");
    let mut values: Vec<f64> = SymmetricEigen::new(0.5 * (&whole + whole.transpose()))
        .eigenvalues
        .iter()
        .map(|v| v.max(0.0).sqrt())
        .collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Norm of the strain, and free displacement unknowns.
fn strain_norm(problem: &Problem) -> (DMatrix<f64>, Vec<usize>) {
    let mesh = &problem.sample.mesh;
    let mask = mesh.pressure_mask();
    let free: Vec<usize> =
        (0..mesh.unknowns()).filter(|&k| !mask[k] && problem.prescribed[k].is_none()).collect();
    let (_, values) = problem.internal(&vec![0.0; mesh.unknowns()], &problem.undeformed(), 1.0);
    let pattern = &problem.sample.map.pattern;
    let entry = |i: usize, j: usize| {
        let (first, rows) = pattern.column(free[j]);
        rows.binary_search(&(free[i] as u32)).map_or(0.0, |k| values[first + k])
    };
    (DMatrix::from_fn(free.len(), free.len(), entry), free)
}

/// Constants of the pair; with `linear`, of displacements that are linear between corners.
fn of_the_pair(n: usize, grading: f64, linear: bool) -> Vec<f64> {
    let problem = problem(n, grading);
    let mesh = &problem.sample.mesh;
    let (a, free) = strain_norm(&problem);
    let mut place_of = vec![usize::MAX; mesh.unknowns()];
    free.iter().enumerate().for_each(|(k, &unknown)| place_of[unknown] = k);
    let pressures: Vec<usize> = (0..mesh.nodes.len() as u32).filter_map(|node| mesh.pressure(node)).collect();
    pressures.iter().enumerate().for_each(|(k, &unknown)| place_of[unknown] = k);
    let mut b = DMatrix::zeros(pressures.len(), free.len());
    let mut mass = DMatrix::zeros(pressures.len(), pressures.len());
    problem.at_points(&vec![0.0; mesh.unknowns()], |element, place, _| {
        let unknowns = problem.sample.map.unknowns[element].map(|u| place_of[u as usize]);
        for m in 0..4 {
            let row = unknowns[2 * NODES + m];
            for k in 0..4 {
                mass[(row, unknowns[2 * NODES + k])] += place.measure * place.p[m] * place.p[k];
            }
            for (k, divergence) in divergence(place).into_iter().enumerate() {
                if unknowns[k] != usize::MAX {
                    b[(row, unknowns[k])] += place.measure * place.p[m] * divergence;
                }
            }
        }
    });
    let basis = if linear {
        between_corners(&problem, &free, &place_of)
    } else {
        DMatrix::identity(free.len(), free.len())
    };
    constants(&a, &b, &mass, &basis)
}

/// Divergence of every displacement unknown of an element.
fn divergence(place: &Place) -> [f64; 2 * NODES] {
    std::array::from_fn(|k| {
        let g = place.gradient[k / 2];
        if k % 2 == 0 { g[0] + place.n[k / 2] / place.at[0] } else { g[1] }
    })
}

/// Displacements whose values at the middles of sides and elements are the means of the corners'.
fn between_corners(problem: &Problem, free: &[usize], place_of: &[usize]) -> DMatrix<f64> {
    let mesh = &problem.sample.mesh;
    let mut columns = Vec::new();
    for (node, at) in mesh.nodes.iter().enumerate().filter(|(node, _)| mesh.pressure(*node as u32).is_some())
    {
        for component in 0..2 {
            if place_of[mesh.displacement(node as u32) + component] == usize::MAX {
                continue;
            }
            let mut column = vec![0.0; free.len()];
            for element in &mesh.elements {
                let Some(corner) = [0, 2, 6, 8].iter().position(|&k| element.nodes[k] as usize == node)
                else {
                    continue;
                };
                for (k, &other) in element.nodes.iter().enumerate() {
                    let weight = tests::problem::Functions::at([(k % 3) as f64 - 1.0, (k / 3) as f64 - 1.0])
                        .linear[corner];
                    let place = place_of[mesh.displacement(other) + component];
                    if place != usize::MAX {
                        column[place] = weight;
                    }
                }
            }
            assert!(at[0] >= 0.0);
            columns.push(column);
        }
    }
    DMatrix::from_fn(free.len(), columns.len(), |i, j| columns[j][i])
}

/// Constants of the drained skeleton's rule: pressures at the 2 x 2 points, each with the measure of its point.
fn of_the_drained_rule(n: usize, grading: f64) -> Vec<f64> {
    let problem = problem(n, grading);
    let (a, free) = strain_norm(&problem);
    let mesh = &problem.sample.mesh;
    let mut place_of = vec![usize::MAX; mesh.unknowns()];
    free.iter().enumerate().for_each(|(k, &unknown)| place_of[unknown] = k);
    let x = 1.0 / 3.0_f64.sqrt();
    let points = mesh.elements.len() * 4;
    let (mut b, mut mass) = (DMatrix::zeros(points, free.len()), DMatrix::zeros(points, points));
    for (element, e) in mesh.elements.iter().enumerate() {
        for (k, xi) in [[-x, -x], [x, -x], [-x, x], [x, x]].into_iter().enumerate() {
            let (row, place) = (4 * element + k, Place::new(&e.corners, xi, 1.0));
            mass[(row, row)] = place.measure;
            for (divergence, &unknown) in
                divergence(&place).into_iter().zip(&problem.sample.map.unknowns[element])
            {
                if place_of[unknown as usize] != usize::MAX {
                    b[(row, place_of[unknown as usize])] += place.measure * divergence;
                }
            }
        }
    }
    constants(&a, &b, &mass, &DMatrix::identity(free.len(), free.len()))
}

/// Tolerance: from 4 x 4 to 8 x 8 elements the constant falls by less than 3 %, and the constant pressure is the only one that no displacement
/// feels; linear displacements lose a third of theirs, or feel some pressures not at all.
#[test]
fn the_pair_is_stable() {
    for grading in [1.0, 3.0] {
        let [coarse, fine] = [4, 8].map(|n| of_the_pair(n, grading, false));
        let unstable = [4, 8].map(|n| of_the_pair(n, grading, true)[1]);
        println!("grading {grading}: {:.4} {:.4}; linear {unstable:.4?}", coarse[1], fine[1]);
        assert!(coarse[0] < 1e-6 && fine[0] < 1e-6, "the constant pressure");
        assert!(fine[1] > 0.97 * coarse[1], "{} {}", coarse[1], fine[1]);
        assert!(unstable[1] < 0.67 * fine[1], "{unstable:?}");
    }
}

/// Goal: what the drained 2 x 2 rule has. It is not stable in this sense: its constant falls nearly like the element's size, although the constant pressure is the only one
/// without effect. So nearly incompressible skeletons are looked at on their own below. Tolerance: the constant of 8 x 8 elements is between 0.5 and 0.7 of that of 4 x 4.
#[test]
fn the_drained_rule_is_weakly_stable() {
    for grading in [1.0, 3.0] {
        let [coarse, fine] = [4, 8].map(|n| of_the_drained_rule(n, grading));
        println!("grading {grading}: {:.4?} {:.4?}", &coarse[..3], &fine[..3]);
        assert!(coarse[0] < 1e-6 && fine[0] < 1e-6 && fine[1] > 1e-2, "the constant pressure alone");
        assert!((0.5..0.7).contains(&(fine[1] / coarse[1])), "{} {}", coarse[1], fine[1]);
    }
}

/// Ratio of lambda* to G under Table 1.
const STIFF: f64 = 430.0;
/// So small that what is of second order in the strain does not matter, times [`STIFF`].
const SIZE: f64 = 1e-8;

/// A displacement whose divergence is `(1 - r^2) cos 3z / STIFF`: one without any, and an axial one.
fn nearly_isochoric([r, z]: [f64; 2]) -> ([f64; 2], [[f64; 2]; 2], f64) {
    let ((s2, c2), (s3, c3), q) = ((2.0 * z).sin_cos(), (3.0 * z).sin_cos(), 1.0 / STIFF);
    let u = [-2.0 * r * (1.0 + r * r) * c2, (2.0 + 4.0 * r * r) * s2 + q * (1.0 - r * r) * s3 / 3.0];
    let grad = [
        [-2.0 * (1.0 + 3.0 * r * r) * c2, 4.0 * r * (1.0 + r * r) * s2],
        [8.0 * r * s2 - 2.0 * q * r * s3 / 3.0, (4.0 + 8.0 * r * r) * c2 + q * (1.0 - r * r) * c3],
    ];
    (u.map(|v| SIZE * v), grad.map(|row| row.map(|v| SIZE * v)), (1.0 - r * r) * c3)
}

/// Error of the effective mean stress at the 2 x 2 points, and that of its means over elements, over its norm.
fn mean_stress_errors(n: usize, distortion: f64) -> [f64; 2] {
    let lines: Vec<f64> = (0..=n).map(|k| k as f64 / n as f64).collect();
    let inside = |v: f64| v > 1e-9 && v < 1.0 - 1e-9;
    let wave = |x: [f64; 2]| (37.0 * x[0] + 91.0 * x[1]).sin() * distortion / n as f64;
    let mesh = tests::problem::warped(Mesh::tensor(&lines, &lines, 1.0), |x| {
        if inside(x[0]) && inside(x[1]) { [x[0] + wave(x), x[1] + wave([x[1], x[0]])] } else { x }
    });
    let mut problem = Problem::new(mesh, &poroelastic(1.0, STIFF, 1.0));
    let mesh = problem.sample.mesh.clone();
    let mut x = vec![0.0; mesh.unknowns()];
    for (node, at) in mesh.nodes.iter().enumerate() {
        let (first, (u, ..)) = (mesh.displacement(node as u32), nearly_isochoric(*at));
        (x[first], x[first + 1]) = (u[0], u[1]);
        if at[0] > 1.0 - 1e-9 || at[1] < 1e-9 || at[1] > 1.0 - 1e-9 {
            problem.prescribed[first] = Some(u[0]);
            problem.prescribed[first + 1] = Some(u[1]);
        }
        mesh.pressure(node as u32).into_iter().for_each(|p| problem.prescribed[p] = Some(0.0));
    }
    // Loads of small strain: `2 G dev e + K tr e`.
    let mut loads = vec![0.0; x.len()];
    problem.at_points(&x, |element, place, _| {
        let (u, grad, s) = nearly_isochoric(place.at);
        let third = SIZE * s / STIFF / 3.0;
        let mean = SIZE * s;
        let [rr, zz, tt] = [grad[0][0], grad[1][1], u[0] / place.at[0]].map(|e| 2.0 * (e - third) + mean);
        let rz = grad[0][1] + grad[1][0];
        for a in 0..NODES {
            let g = place.gradient[a];
            let unknowns = &problem.sample.map.unknowns[element];
            loads[unknowns[2 * a] as usize] +=
                place.measure * (rr * g[0] + rz * g[1] + tt * place.n[a] / place.at[0]);
            loads[unknowns[2 * a + 1] as usize] += place.measure * (rz * g[0] + zz * g[1]);
        }
    });
    problem.loads = loads;
    problem.step(&mut x, &problem.undeformed(), 1.0).expect("a solution");
    let (mut errors, mut norm) = ([0.0; 2], 0.0);
    let gauss = 1.0 / 3.0_f64.sqrt();
    for (e, element) in mesh.elements.iter().enumerate() {
        let x_e = problem.sample.map.gather(e, &x);
        let (mut difference, mut volume) = (0.0, 0.0);
        for xi in [[-gauss, -gauss], [gauss, -gauss], [-gauss, gauss], [gauss, gauss]] {
            let place = Place::new(&element.corners, xi, 1.0);
            let f = place.fields(&x_e);
            let found = STIFF * (f.grad_u[0][0] + f.grad_u[1][1] + f.u[0] / place.at[0]) / SIZE;
            let exact = nearly_isochoric(place.at).2;
            errors[0] += place.measure * (found - exact).powi(2);
            norm += place.measure * exact * exact;
            difference += place.measure * (found - exact);
            volume += place.measure;
        }
        errors[1] += difference * difference / volume;
    }
    errors.map(|e| (e / norm).sqrt())
}

/// Goal: no checkerboard in the effective stress at lambda* = 430 G. Reference: a manufactured solution whose mean stress is of the size of its shear. Tolerance: from 8 x 8 to
/// 16 x 16 elements the error falls at least fourfold on squares, and on distorted elements 2.5-fold at the points and eightfold in the elements' means, between
/// which a checkerboard would stay.
#[test]
fn effective_stress_of_a_nearly_incompressible_skeleton() {
    for (distortion, falls) in [(0.0, [4.0, 8.0]), (0.15, [2.5, 8.0])] {
        let [coarse, fine] = [8, 16].map(|n| mean_stress_errors(n, distortion));
        println!("distortion {distortion}: {coarse:.2?}, {fine:.2?}");
        for k in 0..2 {
            assert!(coarse[k] > falls[k] * fine[k], "{coarse:?} {fine:?}");
        }
    }
}
