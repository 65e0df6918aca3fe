//! The seam to the sparse direct solver: pattern once, factorise many times, solve.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::lu::{LuRef, LuSymbolicParams, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par};
use std::sync::Arc;
use thiserror::Error;

/// Compressed sparse column pattern, structurally symmetric.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CscPattern {
    /// Start of every column, and the total.
    pub column_pointers: Vec<u32>,
    /// Rows of every column, ascending.
    pub rows: Vec<u32>,
}

impl CscPattern {
    /// The union of the dense blocks of `elements` (lists of unknowns).
    pub fn from_elements<const N: usize>(unknowns: usize, elements: &[[u32; N]]) -> Self {
        let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); unknowns];
        for element in elements {
            for &column in element {
                neighbours[column as usize].extend_from_slice(element);
            }
        }
        let mut column_pointers = vec![0];
        let mut rows = Vec::new();
        for mut column in neighbours {
            column.sort_unstable();
            column.dedup();
            rows.extend(column);
            column_pointers.push(rows.len() as u32);
        }
        Self { column_pointers, rows }
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.column_pointers.len() - 1
    }

    /// Rows of a column with the position of the first.
    #[inline]
    pub fn column(&self, column: usize) -> (usize, &[u32]) {
        let (a, b) = (self.column_pointers[column] as usize, self.column_pointers[column + 1] as usize);
        (a, &self.rows[a..b])
    }

    /// Position of an entry of the pattern in the values.
    pub fn position(&self, row: u32, column: u32) -> u32 {
        let (first, rows) = self.column(column as usize);
        (first + rows.partition_point(|&r| r < row)) as u32
    }

    /// `y = A x`.
    pub fn multiply(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for (column, &x_c) in x.iter().enumerate() {
            let (first, rows) = self.column(column);
            for (k, &row) in rows.iter().enumerate() {
                y[row as usize] += values[first + k] * x_c;
            }
        }
    }

    fn view(&self) -> SymbolicSparseColMatRef<'_, u32> {
        let n = self.unknowns();
        SymbolicSparseColMatRef::new_checked(n, n, &self.column_pointers, None, &self.rows)
    }
}

/// The matrix cannot be factorised.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("the tangent is singular")]
pub struct Singular;

/// Everything about a pattern that does not depend on values; shared by all instances.
pub struct Structure {
    pattern: CscPattern,
    symbolic: SymbolicLu<u32>,
}

impl std::fmt::Debug for Structure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Structure").field("unknowns", &self.pattern.unknowns()).finish_non_exhaustive()
    }
}

impl Structure {
    /// Analyses a pattern.
    ///
    /// # Errors
    /// When memory runs out.
    pub fn analyse(pattern: CscPattern) -> Result<Self, Singular> {
        // faer's own guess takes the scalar code, which is several times slower on these matrices.
        let parameters = LuSymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic = factorize_symbolic_lu(pattern.view(), parameters).map_err(|_| Singular)?;
        Ok(Self { pattern, symbolic })
    }

    /// The pattern.
    pub fn pattern(&self) -> &CscPattern {
        &self.pattern
    }
}

/// Factors of one matrix; memory is kept from one factorisation to the next.
pub struct LinearSolver {
    structure: Arc<Structure>,
    numeric: NumericLu<u32, f64>,
    workspace: MemBuffer,
}

impl LinearSolver {
    /// A solver for matrices of one structure.
    pub fn new(structure: Arc<Structure>) -> Self {
        let symbolic = &structure.symbolic;
        let factorise = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
        let solve = symbolic.solve_in_place_scratch::<f64>(1, Par::Seq);
        let workspace = MemBuffer::new(factorise.or(solve));
        Self { structure, numeric: NumericLu::new(), workspace }
    }

    /// Factorises the matrix with these values.
    ///
    /// # Errors
    /// When a pivot vanishes or is not finite.
    pub fn factorise(&mut self, values: &[f64]) -> Result<(), Singular> {
        let Structure { pattern, symbolic } = &*self.structure;
        let matrix = SparseColMatRef::new(pattern.view(), values);
        let stack = MemStack::new(&mut self.workspace);
        symbolic
            .factorize_numeric_lu(&mut self.numeric, matrix, Par::Seq, stack, Default::default())
            .map(|_| ())
            .map_err(|_| Singular)
    }

    /// Solves in place with the last factors.
    pub fn solve(&mut self, rhs: &mut [f64]) {
        let n = rhs.len();
        let stack = MemStack::new(&mut self.workspace);
        let factors = LuRef::new_unchecked(&self.structure.symbolic, &self.numeric);
        factors.solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, n, 1),
            Par::Seq,
            stack,
        );
    }
}
