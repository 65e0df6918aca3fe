//! Factorise and solve tangents of poroelasticity, and check against the residual and faer.

use super::test_matrices::{Case, System};
use super::*;
use faer::prelude::Solve;
use faer::sparse::SparseColMat;
use std::sync::Arc;

fn structure(system: &System) -> Connectivity {
    Connectivity {
        unknowns: system.unknowns,
        elements: system.elements.clone(),
        centroids: system.centroids.clone(),
        rank: system.rank.clone(),
    }
}

fn analyse(system: &System) -> Arc<Symbolic> {
    Arc::new(Symbolic::analyse(&structure(system), system.matrix.symbolic()).unwrap())
}

/// Largest entry of b - A x over the largest of b.
fn residual(matrix: &SparseColMat<usize, f64>, x: &[f64], b: &[f64]) -> f64 {
    let mut r = b.to_vec();
    for (column, &x) in x.iter().enumerate() {
        for (row, value) in matrix.row_idx_of_col(column).zip(matrix.val_of_col(column)) {
            r[row] -= value * x;
        }
    }
    let largest = |v: &[f64]| v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    largest(&r) / largest(b)
}

fn right_hand_side(n: usize, seed: usize) -> Vec<f64> {
    (0..n).map(|i| ((i * 7919 + seed * 104_729) % 1009) as f64 / 1009.0 - 0.5).collect()
}

const UNDRAINED: f64 = 0.0;
const DRAINED: f64 = 1e-2;

#[test]
fn axisymmetric_and_solid_tangents_are_solved_to_rounding() {
    for permeability in [UNDRAINED, 1e-9, DRAINED] {
        for case in [
            Case::axisymmetric(300, permeability),
            Case::axisymmetric(2000, permeability),
            Case::axisymmetric(6000, permeability),
            Case { elements: [31, 3, 0], permeability, disturbance: 0.1 },
            Case { elements: [1, 1, 0], permeability, disturbance: 0.0 },
            Case::solid(2500, permeability),
        ] {
            let system = case.assemble();
            let mut numeric: Numeric = Numeric::new(analyse(&system));
            numeric.factorise(system.matrix.val()).unwrap();
            let b = right_hand_side(system.unknowns, 0);
            let mut x = b.clone();
            numeric.solve_in_place(&mut x, 1);
            let r = residual(&system.matrix, &x, &b);
            assert!(r < 1e-9, "{case:?}: residual {r:e}");
        }
    }
}

#[test]
fn solution_is_that_of_faer() {
    let system = Case::axisymmetric(1500, DRAINED).assemble();
    let mut numeric: Numeric = Numeric::new(analyse(&system));
    numeric.factorise(system.matrix.val()).unwrap();
    let b = right_hand_side(system.unknowns, 3);
    let mut x = b.clone();
    numeric.solve_in_place(&mut x, 1);
    let mut expected = faer::Col::from_fn(b.len(), |i| b[i]);
    system.matrix.sp_lu().unwrap().solve_in_place(expected.as_mat_mut());
    let scale = expected.norm_max();
    assert!(x.iter().enumerate().all(|(i, x)| (x - expected[i]).abs() < 1e-9 * scale));
}

#[test]
fn several_right_hand_sides_equal_single_ones() {
    let system = Case::axisymmetric(800, UNDRAINED).assemble();
    let mut numeric: Numeric = Numeric::new(analyse(&system));
    numeric.factorise(system.matrix.val()).unwrap();
    for columns in [0, 1, 2, 3, 8, 9, 12] {
        let mut together: Vec<f64> = (0..columns).flat_map(|c| right_hand_side(system.unknowns, c)).collect();
        numeric.solve_in_place(&mut together, columns);
        for (c, x) in together.chunks(system.unknowns).enumerate() {
            let r = residual(&system.matrix, x, &right_hand_side(system.unknowns, c));
            assert!(r < 1e-10, "column {c} of {columns}: residual {r:e}");
        }
    }
}

#[test]
fn factorising_again_gives_the_same_bits() {
    let system = Case::axisymmetric(1000, DRAINED).assemble();
    let other = Case::axisymmetric(1000, UNDRAINED).assemble();
    let symbolic = analyse(&system);
    let solve = |numeric: &mut Numeric, system: &System| {
        numeric.factorise(system.matrix.val()).unwrap();
        let mut x = right_hand_side(system.unknowns, 1);
        numeric.solve_in_place(&mut x, 1);
        x
    };
    let mut numeric = Numeric::new(Arc::clone(&symbolic));
    let fresh = solve(&mut numeric, &system);
    solve(&mut numeric, &other);
    assert_eq!(solve(&mut numeric, &system), fresh);
    assert_eq!(solve(&mut Numeric::new(symbolic), &system), fresh);
}

#[test]
fn single_precision_reaches_its_own_rounding() {
    let system = Case::axisymmetric(2000, DRAINED).assemble();
    let mut numeric = Numeric::<f32>::new(analyse(&system));
    numeric.factorise(system.matrix.val()).unwrap();
    let b = right_hand_side(system.unknowns, 0);
    let mut x = b.clone();
    numeric.solve_in_place(&mut x, 1);
    assert!(residual(&system.matrix, &x, &b) < 1e-2);
}

#[test]
fn fronts_of_several_blocks_use_faer_and_agree() {
    // One element list holding everything: a single dense front larger than a block.
    let n = 2 * dense::BLOCK + 37;
    let value = |i: usize, j: usize| ((i * 31 + j * 17 + (i * j) % 13) % 101) as f64 / 101.0 - 0.5;
    let triplets: Vec<_> = (0..n * n)
        .map(|k| (k % n, k / n))
        .map(|(i, j)| {
            faer::sparse::Triplet::new(i, j, if i == j { 0.0 } else { value(i, j) + value(j * j, i) })
        })
        .collect();
    let matrix = SparseColMat::try_new_from_triplets(n, n, &triplets).unwrap();
    let structure = Connectivity {
        unknowns: n,
        elements: vec![(0..n as u32).collect()],
        centroids: vec![[0.0; 3]],
        rank: vec![0; n],
    };
    let symbolic = Symbolic::analyse(&structure, matrix.symbolic()).unwrap();
    let mut numeric: Numeric = Numeric::new(Arc::new(symbolic));
    numeric.factorise(matrix.val()).unwrap();
    let b = right_hand_side(n, 0);
    let mut x = b.clone();
    numeric.solve_in_place(&mut x, 1);
    assert!(residual(&matrix, &x, &b) < 1e-8);
}

#[test]
fn singular_and_non_finite_matrices_are_reported() {
    let system = Case::axisymmetric(300, DRAINED).assemble();
    let mut numeric: Numeric = Numeric::new(analyse(&system));
    let zeros = vec![0.0; system.matrix.val().len()];
    assert!(numeric.factorise(&zeros).is_err());
    let mut values = system.matrix.val().to_vec();
    let column = system.unknowns / 2;
    values[system.matrix.col_range(column)].fill(0.0);
    assert_eq!(numeric.factorise(&values), Err(SingularMatrix { unknown: column }));
    values[system.matrix.col_range(column)].fill(f64::NAN);
    assert!(numeric.factorise(&values).is_err());
    numeric.factorise(system.matrix.val()).unwrap();
}

#[test]
fn entries_outside_the_elements_are_reported() {
    let system = Case::axisymmetric(300, DRAINED).assemble();
    let n = system.unknowns;
    let far = faer::sparse::Triplet::new(0, n - 1, 1.0);
    let matrix = SparseColMat::try_new_from_triplets(n, n, &[far]).unwrap();
    let error = Symbolic::analyse(&structure(&system), matrix.symbolic()).unwrap_err();
    assert_eq!(error, StructureError::EntryOutsideElements { row: 0, column: n - 1 });
    let mut wrong = structure(&system);
    wrong.rank.pop();
    assert!(matches!(
        Symbolic::analyse(&wrong, system.matrix.symbolic()),
        Err(StructureError::Inconsistent(_))
    ));
}

#[test]
fn unknowns_of_no_element_and_separate_bodies_are_solved() {
    let system = Case::axisymmetric(300, DRAINED).assemble();
    let n = system.unknowns;
    // Two copies side by side and one unknown that only has a diagonal.
    let mut doubled = structure(&system);
    doubled.unknowns = 2 * n + 1;
    for (element, centroid) in system.elements.iter().zip(&system.centroids) {
        doubled.elements.push(element.iter().map(|u| u + n as u32).collect());
        doubled.centroids.push([centroid[0] + 5.0, centroid[1], centroid[2]]);
    }
    doubled.rank = [&system.rank[..], &system.rank[..], &[0]].concat();
    let mut triplets = vec![faer::sparse::Triplet::new(2 * n, 2 * n, 4.0)];
    for column in 0..n {
        for (row, &value) in system.matrix.row_idx_of_col(column).zip(system.matrix.val_of_col(column)) {
            triplets.push(faer::sparse::Triplet::new(row, column, value));
            triplets.push(faer::sparse::Triplet::new(row + n, column + n, value));
        }
    }
    let matrix = SparseColMat::try_new_from_triplets(2 * n + 1, 2 * n + 1, &triplets).unwrap();
    let mut numeric: Numeric =
        Numeric::new(Arc::new(Symbolic::analyse(&doubled, matrix.symbolic()).unwrap()));
    numeric.factorise(matrix.val()).unwrap();
    let b = right_hand_side(2 * n + 1, 0);
    let mut x = b.clone();
    numeric.solve_in_place(&mut x, 1);
    assert!(residual(&matrix, &x, &b) < 1e-10);
    assert_eq!(x[2 * n], b[2 * n] / 4.0);
}

#[test]
fn fill_and_operations_stay_where_they_are() {
    let statistics = |case: Case| analyse(&case.assemble()).statistics();
    let plane = statistics(Case::axisymmetric(6000, DRAINED));
    let solid = statistics(Case::solid(2500, DRAINED));
    println!("{plane:?}\n{solid:?}");
}
