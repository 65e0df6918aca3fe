//! The seam to the sparse direct solvers: structure once, factorise many times, solve.
//!
//! The multifrontal LU pivots inside its fronts only. Every solution is therefore refined once and its
//! residual checked; should it fail, faer's sparse LU with full partial pivoting takes over.

use super::multifrontal::{self, Numeric, Symbolic};
pub use super::pattern::CscPattern;
use crate::solver::parameters::LinearSolverKind;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::lu::{LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::{Conj, MatMut, Par};
use std::sync::{Arc, OnceLock};
use thiserror::Error;

/// Largest backward error of an accepted solution.
const ACCEPTED: f64 = 1e-10;

/// The matrix cannot be factorised.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("the tangent is singular")]
pub struct Singular;

/// Everything about a pattern that does not depend on values; shared by all instances.
#[derive(Debug)]
pub struct Structure {
    pattern: CscPattern,
    multifrontal: Arc<Symbolic>,
    /// Analysed when first needed.
    fallback: OnceLock<Option<SymbolicLu<u32>>>,
}

impl Structure {
    /// Analyses a pattern, which is the union of the elements of `structure`.
    ///
    /// # Errors
    /// When elements and pattern do not belong together.
    pub fn analyse(
        pattern: CscPattern,
        structure: &multifrontal::Connectivity,
    ) -> Result<Self, multifrontal::StructureError> {
        let multifrontal = Arc::new(Symbolic::analyse(structure, pattern.view())?);
        Ok(Self { pattern, multifrontal, fallback: OnceLock::new() })
    }

    /// The pattern.
    pub fn pattern(&self) -> &CscPattern {
        &self.pattern
    }

    /// Sizes of the factorisation.
    pub fn statistics(&self) -> multifrontal::FactorSizes {
        self.multifrontal.statistics()
    }

    fn fallback(&self) -> Option<&SymbolicLu<u32>> {
        // faer's own guess takes the scalar code, which is several times slower on these matrices.
        let parameters = LuSymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        self.fallback.get_or_init(|| factorize_symbolic_lu(self.pattern.view(), parameters).ok()).as_ref()
    }
}

/// Which factors are valid.
enum Factors {
    None,
    Multifrontal,
    PartialPivoting(Box<NumericLu<u32, f64>>),
}

/// Factors of one matrix; memory is kept from one factorisation to the next.
pub struct LinearSolver {
    structure: Arc<Structure>,
    kind: LinearSolverKind,
    numeric: Numeric,
    factors: Factors,
    solution: Vec<f64>,
    residual: Vec<f64>,
    sizes: Vec<f64>,
    fallbacks: u64,
}

impl LinearSolver {
    /// A solver for matrices of one structure.
    pub fn new(structure: Arc<Structure>, kind: LinearSolverKind) -> Self {
        let n = structure.pattern.unknowns();
        let numeric = Numeric::new(structure.multifrontal.clone());
        Self {
            structure,
            kind,
            numeric,
            factors: Factors::None,
            solution: vec![0.0; n],
            residual: vec![0.0; n],
            sizes: vec![0.0; n],
            fallbacks: 0,
        }
    }

    /// How often the multifrontal factors were not good enough.
    pub fn fallbacks(&self) -> u64 {
        self.fallbacks
    }

    /// Factorises the matrix with these values and solves in place for one right-hand side.
    ///
    /// # Errors
    /// When the matrix is singular or not finite.
    pub fn solve(&mut self, values: &[f64], rhs: &mut [f64]) -> Result<(), Singular> {
        self.factorise(values)?;
        self.solve_again(values, rhs)
    }

    /// Factorises the matrix with these values.
    ///
    /// # Errors
    /// When the matrix is singular or not finite.
    pub fn factorise(&mut self, values: &[f64]) -> Result<(), Singular> {
        if self.kind == LinearSolverKind::Faer {
            return self.pivot_partially(values);
        }
        match self.numeric.factorise(values) {
            Ok(()) => {
                self.factors = Factors::Multifrontal;
                Ok(())
            }
            Err(_) => self.fall_back(values),
        }
    }

    /// Solves in place for right-hand sides that stand one after the other, with the factors of `values`.
    ///
    /// # Errors
    /// When the matrix turns out to be singular.
    pub fn solve_again(&mut self, values: &[f64], rhs: &mut [f64]) -> Result<(), Singular> {
        if matches!(self.factors, Factors::Multifrontal) {
            if self.refined(values, rhs) {
                return Ok(());
            }
            self.fall_back(values)?;
        }
        self.solve_roughly(rhs)
    }

    /// Solves in place for right-hand sides that stand one after the other with the factors that there are, without a check.
    ///
    /// # Errors
    /// When there are none.
    pub fn solve_roughly(&mut self, rhs: &mut [f64]) -> Result<(), Singular> {
        match &self.factors {
            Factors::None => Err(Singular),
            Factors::Multifrontal => {
                self.numeric.solve_in_place(rhs, rhs.len() / self.structure.pattern.unknowns());
                Ok(())
            }
            Factors::PartialPivoting(numeric) => {
                let symbolic = self.structure.fallback().ok_or(Singular)?;
                solve_by_partial_pivoting(symbolic, numeric, rhs)
            }
        }
    }

    fn fall_back(&mut self, values: &[f64]) -> Result<(), Singular> {
        self.fallbacks += 1;
        self.pivot_partially(values)
    }

    fn pivot_partially(&mut self, values: &[f64]) -> Result<(), Singular> {
        self.factors = Factors::None;
        let symbolic = self.structure.fallback().ok_or(Singular)?;
        let numeric = factorise_by_partial_pivoting(&self.structure.pattern, symbolic, values)?;
        self.factors = Factors::PartialPivoting(Box::new(numeric));
        Ok(())
    }

    /// Solves with the multifrontal factors, refining where needed; leaves `rhs` alone when that is not enough.
    fn refined(&mut self, values: &[f64], rhs: &mut [f64]) -> bool {
        let Self { structure, numeric, solution, residual, sizes, .. } = self;
        let unknowns = structure.pattern.unknowns();
        solution.clear();
        solution.extend_from_slice(rhs);
        numeric.solve_in_place(solution, rhs.len() / unknowns);
        let mut accurate = |x: &[f64], b: &[f64], residual: &mut [f64]| {
            residual.copy_from_slice(b);
            let size = structure.pattern.subtract_product(values, x, residual, sizes);
            // A maximum would skip NaN.
            size.is_finite() && residual.iter().all(|r| r.abs() <= ACCEPTED * size)
        };
        let good = if rhs.len() == unknowns {
            accurate(solution, rhs, residual)
        } else {
            let (x, b) = weighted_sums(solution, rhs, unknowns);
            accurate(&x, &b, residual)
        };
        if !good {
            for (x, b) in solution.chunks_exact_mut(unknowns).zip(rhs.chunks_exact(unknowns)) {
                if accurate(x, b, residual) {
                    continue;
                }
                numeric.solve_in_place(residual, 1);
                x.iter_mut().zip(residual.iter()).for_each(|(x, r)| *x += r);
                if !accurate(x, b, residual) {
                    return false;
                }
            }
        }
        rhs.copy_from_slice(solution);
        true
    }
}

/// One linear system that is accurate only if all are: columns of solutions and of right-hand sides, each scaled
/// to one and weighted unequally, added up. One product with the matrix then checks all of them.
fn weighted_sums(solutions: &[f64], rhs: &[f64], unknowns: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut x_sum, mut b_sum) = (vec![0.0; unknowns], vec![0.0; unknowns]);
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let columns = solutions.chunks_exact(unknowns).zip(rhs.chunks_exact(unknowns));
    for (k, (x, b)) in columns.enumerate() {
        let size = if largest(x) > 0.0 { largest(x) } else { largest(b) };
        if size == 0.0 {
            continue;
        }
        // Multiples of the golden ratio are far from each other.
        let factor = (1.0 + (k as f64 * 0.618_033_988_749_894_9).fract()) / size;
        x_sum.iter_mut().zip(x).for_each(|(sum, x)| *sum += factor * x);
        b_sum.iter_mut().zip(b).for_each(|(sum, b)| *sum += factor * b);
    }
    (x_sum, b_sum)
}

fn factorise_by_partial_pivoting(
    pattern: &CscPattern,
    symbolic: &SymbolicLu<u32>,
    values: &[f64],
) -> Result<NumericLu<u32, f64>, Singular> {
    let scratch = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
    let mut workspace = MemBuffer::new(scratch);
    let mut numeric = NumericLu::new();
    let matrix = SparseColMatRef::new(pattern.view(), values);
    symbolic
        .factorize_numeric_lu(
            &mut numeric,
            matrix,
            Par::Seq,
            MemStack::new(&mut workspace),
            Default::default(),
        )
        .map_err(|_| Singular)?;
    Ok(numeric)
}

fn solve_by_partial_pivoting(
    symbolic: &SymbolicLu<u32>,
    numeric: &NumericLu<u32, f64>,
    rhs: &mut [f64],
) -> Result<(), Singular> {
    let n = symbolic.nrows();
    let columns = rhs.len() / n;
    let mut workspace = MemBuffer::new(symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq));
    LuRef::new_unchecked(symbolic, numeric).solve_in_place_with_conj(
        Conj::No,
        MatMut::from_column_major_slice_mut(rhs, n, columns),
        Par::Seq,
        MemStack::new(&mut workspace),
    );
    if rhs.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(Singular) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: u32 = 202;

    /// A chain of elements with two unknowns each: a tridiagonal matrix.
    fn chain() -> (Arc<Structure>, CscPattern) {
        let elements: Vec<[u32; 2]> = (0..N - 1).map(|k| [k, k + 1]).collect();
        let pattern = CscPattern::from_elements(N as usize, &elements);
        let structure = multifrontal::Connectivity {
            unknowns: N as usize,
            elements: elements.iter().map(|e| e.to_vec()).collect(),
            centroids: (0..N - 1).map(|k| [f64::from(k), 0.0, 0.0]).collect(),
            rank: vec![0; N as usize],
        };
        (Arc::new(Structure::analyse(pattern.clone(), &structure).unwrap()), pattern)
    }

    /// Solves with ones beside a constant diagonal and returns how often the fallback was needed.
    fn solves(diagonal: f64) -> u64 {
        let (structure, pattern) = chain();
        let mut solver = LinearSolver::new(structure, LinearSolverKind::Multifrontal);
        let mut values = vec![1.0; pattern.rows.len()];
        for k in 0..N {
            values[pattern.position(k, k) as usize] = diagonal;
        }
        let exact: Vec<f64> = (0..N).map(|k| f64::from(k % 7) - 2.5).collect();
        let mut rhs = vec![0.0; N as usize];
        pattern.subtract_product(&values, &exact, &mut rhs, &mut vec![0.0; N as usize]);
        rhs.iter_mut().for_each(|r| *r = -*r);
        solver.solve(&values, &mut rhs).unwrap();
        for (a, b) in rhs.iter().zip(&exact) {
            approx::assert_relative_eq!(a, b, max_relative = 1e-8);
        }
        solver.fallbacks()
    }

    #[test]
    fn both_solvers_agree() {
        let (structure, pattern) = chain();
        let values: Vec<f64> =
            (0..pattern.rows.len()).map(|k| 4.0 * f64::from(u8::from(k % 3 == 0)) + 0.1 * k as f64).collect();
        let solve = |kind| {
            let mut rhs: Vec<f64> = (0..2 * N).map(|k| f64::from(k % 11)).collect();
            let mut solver = LinearSolver::new(structure.clone(), kind);
            solver.factorise(&values).unwrap();
            solver.solve_again(&values, &mut rhs).unwrap();
            rhs
        };
        let (a, b) = (solve(LinearSolverKind::Multifrontal), solve(LinearSolverKind::Faer));
        for (a, b) in a.iter().zip(b) {
            approx::assert_relative_eq!(*a, b, max_relative = 1e-9, epsilon = 1e-9);
        }
    }

    #[test]
    fn regular_matrices_need_no_fallback() {
        assert_eq!(solves(3.0), 0);
    }

    #[test]
    fn vanishing_pivots_fall_back_to_partial_pivoting() {
        // With a zero diagonal every front with an odd number of own unknowns is singular.
        assert_eq!(solves(0.0), 1);
    }

    /// Factors of a matrix that is a little another one: by 1e-7 refinement helps, by 1e-2 only the fallback. Zeros
    /// in the first column say nothing about the others; the third cancels the second in a plain sum.
    #[test]
    fn every_right_hand_side_is_accurate() {
        let (structure, pattern) = chain();
        let n = N as usize;
        for (other, fallbacks) in [(1e-7, 0), (1e-2, 1)] {
            let mut values = vec![1.0; pattern.rows.len()];
            for k in 0..N {
                values[pattern.position(k, k) as usize] = 3.0;
            }
            let mut solver = LinearSolver::new(structure.clone(), LinearSolverKind::Multifrontal);
            solver.factorise(&values).unwrap();
            for k in 0..N {
                values[pattern.position(k, k) as usize] += other * f64::from(1 + k % 3);
            }
            let exact: Vec<f64> = (0..N).map(|k| f64::from(k % 7) - 2.5).collect();
            let mut rhs = vec![0.0; 3 * n];
            pattern.subtract_product(&values, &exact, &mut rhs[2 * n..], &mut vec![0.0; n]);
            for k in 0..n {
                rhs[n + k] = -rhs[2 * n + k];
            }
            solver.solve_again(&values, &mut rhs).unwrap();
            assert_eq!(solver.fallbacks(), fallbacks);
            for (k, x) in exact.iter().enumerate() {
                assert_eq!(rhs[k], 0.0);
                approx::assert_relative_eq!(rhs[n + k], x, max_relative = 1e-10);
                approx::assert_relative_eq!(rhs[2 * n + k], -x, max_relative = 1e-10);
            }
        }
    }

    #[test]
    fn singular_matrices_are_refused() {
        let (structure, pattern) = chain();
        let values = vec![0.0; pattern.rows.len()];
        assert_eq!(
            LinearSolver::new(structure, LinearSolverKind::Multifrontal)
                .solve(&values, &mut [1.0; N as usize]),
            Err(Singular)
        );
    }
}
