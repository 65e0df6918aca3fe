//! Sparse linear systems of one pattern: faer's LU, its symbolic part done once.

use crate::error::Failure;
use faer::linalg::solvers::Solve;
use faer::mat::MatMut;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};

/// Pattern of the matrix and its symbolic factors.
pub struct Pattern {
    structure: SymbolicSparseColMat<usize>,
    symbolic: SymbolicLu<usize>,
}

/// Factors of one matrix.
pub struct Factors(Lu<usize, f64>);

impl Pattern {
    /// The pattern of elements with these unknowns, and for every element where its entries, row by row, are stored;
    /// `usize::MAX` for entries of fixed unknowns (`None`).
    ///
    /// # Errors
    /// When memory is exhausted.
    pub fn new(size: usize, elements: &[Vec<Option<usize>>]) -> Result<(Self, Vec<Vec<u32>>), Failure> {
        let mut columns: Vec<Vec<usize>> = vec![Vec::new(); size];
        for element in elements {
            for &column in element.iter().flatten() {
                columns[column].extend(element.iter().flatten());
            }
        }
        let mut starts = vec![0];
        let mut rows = Vec::new();
        for column in &mut columns {
            column.sort_unstable();
            column.dedup();
            rows.extend_from_slice(column);
            starts.push(rows.len());
        }
        let place = |row: Option<usize>, column: Option<usize>| {
            let (Some(row), Some(column)) = (row, column) else { return u32::MAX };
            let offset = columns[column].partition_point(|&r| r < row);
            (starts[column] + offset) as u32
        };
        let places = |e: &Vec<Option<usize>>| e.iter().flat_map(|&r| e.iter().map(move |&c| place(r, c))).collect();
        let places = elements.iter().map(places).collect();
        let structure = SymbolicSparseColMat::new_checked(size, size, starts, None, rows);
        let symbolic = SymbolicLu::try_new(structure.as_ref()).map_err(|_| Failure::Singular)?;
        Ok((Self { structure, symbolic }, places))
    }

    /// Number of entries.
    pub fn entries(&self) -> usize {
        self.structure.row_idx().len()
    }

    /// Factorises the matrix with these entries.
    ///
    /// # Errors
    /// When it is singular.
    pub fn factorise(&self, values: &[f64]) -> Result<Factors, Failure> {
        let matrix = SparseColMatRef::new(self.structure.as_ref(), values);
        let lu = Lu::try_new_with_symbolic(self.symbolic.clone(), matrix).map_err(|_| Failure::Singular)?;
        Ok(Factors(lu))
    }
}

impl Factors {
    /// Solves in place.
    pub fn solve(&self, right: &mut [f64]) {
        let rows = right.len();
        self.0.solve_in_place(MatMut::from_column_major_slice_mut(right, rows, 1));
    }
}
