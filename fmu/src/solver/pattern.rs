//! Pattern of a sparse matrix.

use faer::sparse::SymbolicSparseColMatRef;

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

    /// `r -= A x`, and returns the largest `sum |a| |x|` of a row, which rounding is measured by.
    pub fn subtract_product(&self, values: &[f64], x: &[f64], r: &mut [f64], sizes: &mut [f64]) -> f64 {
        sizes.fill(0.0);
        for (column, &x_c) in x.iter().enumerate() {
            let (first, rows) = self.column(column);
            for (value, &row) in values[first..].iter().zip(rows) {
                let product = value * x_c;
                r[row as usize] -= product;
                sizes[row as usize] += product.abs();
            }
        }
        sizes.iter().fold(0.0, |m, s| f64::max(m, *s))
    }

    /// The pattern as faer sees it, which checks it: not for inner loops.
    pub fn view(&self) -> SymbolicSparseColMatRef<'_, u32> {
        let n = self.unknowns();
        SymbolicSparseColMatRef::new_checked(n, n, &self.column_pointers, None, &self.rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn union_of_elements() {
        let pattern = CscPattern::from_elements(4, &[[0, 1], [1, 3]]);
        assert_eq!(pattern.column_pointers, [0, 2, 5, 5, 7]);
        assert_eq!(pattern.rows, [0, 1, 0, 1, 3, 1, 3]);
        assert_eq!(pattern.position(3, 1), 4);
        let mut r = vec![1.0; 4];
        let values = [2.0, 0.0, 0.0, -3.0, 0.0, 1.0, 0.0];
        let size = pattern.subtract_product(&values, &[1.0, 2.0, 0.0, 4.0], &mut r, &mut [0.0; 4]);
        assert_eq!((r, size), (vec![-1.0, 3.0, 1.0, 1.0], 10.0));
    }
}
