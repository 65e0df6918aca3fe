//! The seam to the sparse direct solvers: structure once, factorise many times, solve.
//!
//! The multifrontal LU pivots inside its fronts only. Every solution is therefore refined once and its
//! residual checked; should it fail, faer's sparse LU with full partial pivoting takes over.

use super::multifrontal::{self, Numeric, Symbolic};
pub use super::pattern::CscPattern;
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
        structure: &multifrontal::Structure,
    ) -> Result<Self, multifrontal::StructureError> {
        let multifrontal = Arc::new(Symbolic::analyse(structure, pattern.view())?);
        Ok(Self { pattern, multifrontal, fallback: OnceLock::new() })
    }

    /// The pattern.
    pub fn pattern(&self) -> &CscPattern {
        &self.pattern
    }

    /// Sizes of the factorisation.
    pub fn statistics(&self) -> multifrontal::Statistics {
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

/// Factors of one matrix; memory is kept from one factorisation to the next.
pub struct LinearSolver {
    structure: Arc<Structure>,
    numeric: Numeric,
    residual: Vec<f64>,
    sizes: Vec<f64>,
    fallbacks: u64,
}

impl LinearSolver {
    /// A solver for matrices of one structure.
    pub fn new(structure: Arc<Structure>) -> Self {
        let n = structure.pattern.unknowns();
        let numeric = Numeric::new(structure.multifrontal.clone());
        Self { structure, numeric, residual: vec![0.0; n], sizes: vec![0.0; n], fallbacks: 0 }
    }

    /// How often the multifrontal factors were not good enough.
    pub fn fallbacks(&self) -> u64 {
        self.fallbacks
    }

    /// Factorises the matrix with these values and solves in place.
    ///
    /// # Errors
    /// When the matrix is singular or not finite.
    pub fn solve(&mut self, values: &[f64], rhs: &mut [f64]) -> Result<(), Singular> {
        if self.numeric.factorise(values).is_ok() && self.refined(values, rhs) {
            return Ok(());
        }
        self.fallbacks += 1;
        let structure = &*self.structure;
        solve_by_partial_pivoting(&structure.pattern, structure.fallback().ok_or(Singular)?, values, rhs)
    }

    /// Solves with the multifrontal factors, refining once; leaves `rhs` alone when that is not enough.
    fn refined(&mut self, values: &[f64], rhs: &mut [f64]) -> bool {
        let Self { structure, numeric, residual, sizes, .. } = self;
        let mut x = rhs.to_vec();
        numeric.solve_in_place(&mut x, 1);
        for refinements in 0..2 {
            residual.copy_from_slice(rhs);
            let size = structure.pattern.subtract_product(values, &x, residual, sizes);
            let error = residual.iter().fold(0.0, |m, r| f64::max(m, r.abs()));
            if error <= ACCEPTED * size && size.is_finite() {
                rhs.copy_from_slice(&x);
                return true;
            }
            if refinements == 0 {
                numeric.solve_in_place(residual, 1);
                x.iter_mut().zip(residual.iter()).for_each(|(x, r)| *x += r);
            }
        }
        false
    }
}

fn solve_by_partial_pivoting(
    pattern: &CscPattern,
    symbolic: &SymbolicLu<u32>,
    values: &[f64],
    rhs: &mut [f64],
) -> Result<(), Singular> {
    let n = rhs.len();
    let scratch = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
    let mut workspace = MemBuffer::new(scratch.or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq)));
    let stack = MemStack::new(&mut workspace);
    let mut numeric = NumericLu::new();
    let matrix = SparseColMatRef::new(pattern.view(), values);
    symbolic
        .factorize_numeric_lu(&mut numeric, matrix, Par::Seq, stack, Default::default())
        .map_err(|_| Singular)?;
    let factors = LuRef::new_unchecked(symbolic, &numeric);
    factors.solve_in_place_with_conj(
        Conj::No,
        MatMut::from_column_major_slice_mut(rhs, n, 1),
        Par::Seq,
        stack,
    );
    if rhs.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(Singular) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unknowns per element in a chain; the first diagonal vanishes within its front.
    fn chain() -> (Arc<Structure>, CscPattern) {
        let elements: Vec<[u32; 2]> = (0..9).map(|k| [k, k + 1]).collect();
        let pattern = CscPattern::from_elements(10, &elements);
        let structure = multifrontal::Structure {
            unknowns: 10,
            elements: elements.iter().map(|e| e.to_vec()).collect(),
            centroids: (0..9).map(|k| [f64::from(k), 0.0, 0.0]).collect(),
            rank: vec![0; 10],
        };
        (Arc::new(Structure::analyse(pattern.clone(), &structure).unwrap()), pattern)
    }

    fn solves(diagonal: f64) -> u64 {
        let (structure, pattern) = chain();
        let mut solver = LinearSolver::new(structure);
        let mut values = vec![1.0; pattern.rows.len()];
        for k in 0..10 {
            values[pattern.position(k, k) as usize] = diagonal;
        }
        let exact: Vec<f64> = (0..10).map(|k| f64::from(k) - 3.0).collect();
        let mut rhs = vec![0.0; 10];
        pattern.subtract_product(&values, &exact, &mut rhs, &mut [0.0; 10]);
        rhs.iter_mut().for_each(|r| *r = -*r);
        solver.solve(&values, &mut rhs).unwrap();
        for (a, b) in rhs.iter().zip(&exact) {
            approx::assert_relative_eq!(a, b, max_relative = 1e-9, epsilon = 1e-12);
        }
        solver.fallbacks()
    }

    #[test]
    fn regular_matrices_need_no_fallback() {
        assert_eq!(solves(3.0), 0);
    }

    #[test]
    fn vanishing_pivots_fall_back_to_partial_pivoting() {
        // A zero diagonal leaves single-unknown fronts without a pivot.
        assert_eq!(solves(1e-30), 1);
    }

    #[test]
    fn singular_matrices_are_refused() {
        let (structure, pattern) = chain();
        let values = vec![0.0; pattern.rows.len()];
        assert_eq!(LinearSolver::new(structure).solve(&values, &mut [1.0; 10]), Err(Singular));
    }
}
