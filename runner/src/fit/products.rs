//! Products with each other of columns that are zero at most points: nalgebra's `tr_mul` forms each of them twice, over all points.

use nalgebra::DMatrix;
use std::ops::Range;

/// `V'V`, of which some products are known: of hundreds of errors most do not grow, and most have a part of the points only. It would be
/// most of the work of a fit.
pub fn products(columns: &DMatrix<f64>, known: impl Fn(usize, usize) -> Option<f64>) -> DMatrix<f64> {
    let supports: Vec<Range<usize>> =
        columns.column_iter().map(|column| support(column.as_slice())).collect();
    let product = |i: usize, j: usize| {
        let both = supports[i].start.max(supports[j].start)..supports[i].end.min(supports[j].end);
        if both.is_empty() {
            0.0
        } else {
            columns.view_range(both.clone(), i).dot(&columns.view_range(both, j))
        }
    };
    let mut products = DMatrix::zeros(columns.ncols(), columns.ncols());
    for i in 0..columns.ncols() {
        for j in 0..=i {
            let product = known(i, j).unwrap_or_else(|| product(i, j));
            (products[(i, j)], products[(j, i)]) = (product, product);
        }
    }
    products
}

/// The rows outside of which there are zeros only, in whole blocks: a product over these is the sum over all to the last digit.
fn support(column: &[f64]) -> Range<usize> {
    const BLOCK: usize = 8;
    let is_something = |value: &f64| *value != 0.0;
    let first = column.iter().position(is_something).unwrap_or(column.len());
    let last = column.iter().rposition(is_something).map_or(first, |last| last + 1);
    first / BLOCK * BLOCK..last.next_multiple_of(BLOCK).min(column.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;

    /// Columns of 30 points that begin and end anywhere, one of them nowhere: the sums over parts are those over all to the last digit.
    #[test]
    fn products_of_parts_are_those_of_all() {
        let mut random = Random::new(1);
        let part = |j: usize| (3 * j..30 - 2 * j).filter(move |_| j != 4);
        let mut columns = DMatrix::zeros(30, 6);
        (0..6).for_each(|j| part(j).for_each(|i| columns[(i, j)] = random.normal()));
        assert_eq!(products(&columns, |_, _| None), columns.tr_mul(&columns));
        assert_eq!(products(&columns, |i, j| (i == 5 && j == 2).then_some(7.0))[(2, 5)], 7.0);
    }
}
