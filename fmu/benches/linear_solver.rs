//! Multifrontal LU against faer's sparse LU: numeric factorisation and one solve, symbolic work reused.
//!
//! On the model's own tangents (viscous, finite strain; indenting undrained, holding drained, retracting) and on
//! those of linear poroelasticity on tensor grids, axisymmetric and 3D.
//!
//! ```text
//! cargo bench -p poropunch --bench linear_solver [-- LARGEST_3D_SIZE]  (10000, 30000, 88000)
//! ```
//! The two solvers take turns within one run, so that their ratio does not depend on the machine's load.

#[path = "../src/solver/multifrontal/test_matrices.rs"]
mod test_matrices;

use faer::prelude::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMat, Triplet};
use poropunch::parameters::{MeshParameters, MeshPreset};
use poropunch::solver::multifrontal::{Connectivity, Numeric, Symbolic};
use poropunch::specimen::sample::{Sample, connectivity};
use poropunch::specimen::{Discretisation, Motion, Patience, Stepper};
use poropunch::{Parameters, Statistics};
use std::{sync::Arc, time::Instant};
use test_matrices::{Case, System};

/// Largest rate of faer's dense product on one thread (Gflop/s): what the machine can do.
fn peak() -> f64 {
    const N: usize = 1024;
    let a = faer::Mat::from_fn(N, N, |i, j| ((i * 31 + j * 17) % 97) as f64 / 97.0);
    let mut c = faer::Mat::zeros(N, N);
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        timed(&mut best, || {
            faer::linalg::matmul::matmul(&mut c, faer::Accum::Replace, &a, &a, 1.0, faer::Par::Seq);
        });
    }
    2.0 * (N as f64).powi(3) / (best * 1e6)
}

fn main() {
    println!("dense product of 1024 x 1024, one thread: {:.1} Gflop/s", peak());
    let largest: usize = std::env::args().skip(1).find_map(|a| a.parse().ok()).unwrap_or(0);
    println!("numeric factorisation and one solve [ms], one thread, best of several");
    println!(
        "{:>22} {:>8} {:>8} {:>8} {:>8} {:>7} {:>8} {:>8} {:>8} {:>7} {:>8} {:>8} {:>9} {:>9}",
        "matrix",
        "unknowns",
        "analyse",
        "factor",
        "faer",
        "ratio",
        "solve",
        "solve 9",
        "faer",
        "Mflop",
        "f32",
        "Mfactor",
        "residual",
        "faer's"
    );
    for (growth, divisions) in [(2.0, 3), (1.5, 6), (1.3, 9)] {
        for phase in [Phase::Indenting, Phase::Holding, Phase::Retracting] {
            measure(&format!("own, {phase:?}"), &own(growth, divisions, phase), 40);
        }
    }
    for (name, permeability) in [("undrained", 0.0), ("drained", 1e-2)] {
        for size in [2_000, 6_000, 15_000] {
            measure(&format!("axisymmetric {name}"), &Case::axisymmetric(size, permeability).assemble(), 40);
        }
        for size in [10_000, 30_000, 88_000].into_iter().filter(|&s| s <= largest) {
            measure(&format!("3D {name}"), &Case::solid(size, permeability).assemble(), 3);
        }
    }
}

/// When in a test the tangent is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    /// Half way into the sample, undrained.
    Indenting,
    /// After 90 s of hold, drained (permeable sample).
    Holding,
    /// On the way out again, undrained.
    Retracting,
}

/// The model's tangent on a mesh between the presets and far finer.
fn own(growth: f64, divisions: u32, phase: Phase) -> System {
    let mesh = MeshParameters { preset: MeshPreset::Fine, growth, divisions, ..Default::default() };
    let mut parameters = Parameters { mesh, ..Default::default() };
    if phase == Phase::Holding {
        parameters.material.permeability = 1e-12;
    }
    let sample = Sample::shared(&parameters.geometry, &parameters.mesh).expect("a mesh");
    let mut stepper = Stepper::new(&parameters.setup(), Arc::clone(&sample));
    let mut state = stepper.undeformed(0.0);
    let mut statistics = Statistics::default();
    let mut go = |velocity: f64, step: f64, steps: usize| {
        let (end, mut dt) = (state.time + step * steps as f64, step);
        while state.time < end * (1.0 - 1e-12) {
            let start = state.outputs.displacement;
            let (motion, dt_left) = (Motion { start, velocity }, dt.min(end - state.time));
            match stepper.step(&state, motion, dt_left, Patience::Little, &mut statistics) {
                Ok(next) => state = next.state,
                Err(_) => dt *= 0.25,
            }
        }
    };
    // Short steps first: a very permeable sample answers the first touch at once.
    (0..8).for_each(|k| go(1.6e-3, 1e-4 * 2.0_f64.powi(k), 1));
    go(1.6e-3, 0.0125, 23);
    match phase {
        Phase::Indenting => {}
        Phase::Holding => (0..20).for_each(|k| go(0.0, 1e-4 * 2.0_f64.powi(k), 1)),
        Phase::Retracting => go(-1e-3, 0.0125, 5),
    }
    let pattern = sample.structure.pattern();
    let entries = (0..pattern.unknowns()).flat_map(|column| {
        let (first, rows) = pattern.column(column);
        let values = &stepper.tangent()[first..first + rows.len()];
        rows.iter().zip(values).map(move |(&row, &value)| Triplet::new(row as usize, column, value))
    });
    let entries: Vec<_> = entries.collect();
    let n = pattern.unknowns();
    let Connectivity { unknowns, elements, centroids, rank } = connectivity(&sample.mesh);
    let matrix = SparseColMat::try_new_from_triplets(n, n, &entries).expect("a matrix");
    System { unknowns, elements, centroids, rank, matrix }
}

fn measure(name: &str, system: &System, repetitions: usize) {
    let structure = Connectivity {
        unknowns: system.unknowns,
        elements: system.elements.clone(),
        centroids: system.centroids.clone(),
        rank: system.rank.clone(),
    };
    let matrix = &system.matrix;
    let n = system.unknowns;
    let b: Vec<f64> = (0..n).map(|i| (i * 7919 % 1009) as f64 / 1009.0 - 0.5).collect();
    let mut times = [f64::INFINITY; 7];
    let [analyse, factor, faer_factor, solve, solve_nine, faer_solve, single] = &mut times;

    let symbolic =
        Arc::new(timed(analyse, || Symbolic::analyse(&structure, matrix.symbolic()).expect("a mesh")));
    let statistics = symbolic.statistics();
    let mut numeric: Numeric = Numeric::new(Arc::clone(&symbolic));
    let mut numeric_single = Numeric::<f32>::new(symbolic);
    let faer_symbolic = SymbolicLu::try_new(matrix.symbolic()).expect("enough memory");
    let (mut residual, mut faer_residual) = (0.0, 0.0);
    for _ in 0..repetitions {
        timed(factor, || numeric.factorise(matrix.val()).expect("a regular matrix"));
        let mut x = b.clone();
        timed(solve, || numeric.solve_in_place(&mut x, 1));
        residual = relative_residual(system, &x, &b);
        let mut nine = b.repeat(9);
        timed(solve_nine, || numeric.solve_in_place(&mut nine, 9));
        timed(single, || numeric_single.factorise(matrix.val()).expect("a regular matrix"));

        let lu = timed(faer_factor, || {
            Lu::try_new_with_symbolic(faer_symbolic.clone(), matrix.as_ref()).expect("a regular matrix")
        });
        let mut x = b.clone();
        timed(faer_solve, || {
            lu.solve_in_place(faer::MatMut::from_column_major_slice_mut(&mut x, n, 1));
        });
        faer_residual = relative_residual(system, &x, &b);
    }
    let [analyse, factor, faer_factor, solve, solve_nine, faer_solve, single] = times;
    println!(
        "{name:>22} {n:8} {analyse:8.1} {factor:8.2} {faer_factor:8.2} {:7.1} {solve:8.2} {solve_nine:8.2} \
         {faer_solve:8.2} {:7.1} {single:8.2} {:8.2} {residual:9.1e} {faer_residual:9.1e}",
        faer_factor / factor,
        statistics.flops as f64 * 1e-6,
        statistics.factor_entries as f64 * 1e-6,
    );
}

/// Runs the work and keeps the shortest time [ms].
fn timed<R>(best: &mut f64, work: impl FnOnce() -> R) -> R {
    let start = Instant::now();
    let result = work();
    *best = best.min(start.elapsed().as_secs_f64() * 1e3);
    result
}

/// Largest entry of b - A x over the largest of b.
fn relative_residual(system: &System, x: &[f64], b: &[f64]) -> f64 {
    let mut r = b.to_vec();
    for (column, &x) in x.iter().enumerate() {
        let rows = system.matrix.row_idx_of_col(column);
        rows.zip(system.matrix.val_of_col(column)).for_each(|(row, value)| r[row] -= value * x);
    }
    let largest = |v: &[f64]| v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    largest(&r) / largest(b)
}
