//! LU of a front's pivot block, with row interchanges that prefer the diagonal.

use super::dense::{BLOCK, COLUMNS, Factor, Scalar, subtract_packed};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_unit_lower_triangular_in_place;
use faer::{Accum, MatMut, MatRef, Par};
use std::ops::Range;

/// A diagonal entry serves as pivot if it is at least this fraction of the largest one of its column.
const THRESHOLD: f64 = 0.1;
/// Columns eliminated one by one before the rest is updated.
const PANEL: usize = 8;

/// Factorises the `order` x `order` block `a` (by columns) in place, P a = L U: unit L below the diagonal, U above,
/// *inverse* pivots on the diagonal. Row `k` was exchanged with row `swaps[k]`, in this order.
///
/// Err: the column without pivot.
#[inline(always)]
pub(super) fn factorise<T: Scalar>(
    a: &mut [T],
    order: usize,
    swaps: &mut [u32],
    packed: &mut [[T; COLUMNS]],
) -> Result<(), usize> {
    for block in (0..order).step_by(BLOCK) {
        let block_end = (block + BLOCK).min(order);
        for start in (block..block_end).step_by(PANEL) {
            let end = (start + PANEL).min(block_end);
            for k in start..end {
                let row = pivot_row(&a[k * order..][..order], k)?;
                swaps[k] = row as u32;
                if row != k {
                    a.chunks_exact_mut(order).for_each(|column| column.swap(k, row));
                }
                eliminate(a, order, k, end);
            }
            update_block(&mut a[..block_end * order], order, start..end, packed);
        }
        if block_end < order {
            update_rest(a, order, block..block_end);
        }
    }
    Ok(())
}

/// Row of the pivot of column `k`.
#[inline(always)]
fn pivot_row<T: Scalar>(column: &[T], k: usize) -> Result<usize, usize> {
    let mut row = k;
    let mut largest = column[k].magnitude();
    for (i, x) in column.iter().enumerate().skip(k + 1) {
        if x.magnitude() > largest {
            (row, largest) = (i, x.magnitude());
        }
    }
    // `largest` misses a NaN below the diagonal; it spreads to a later pivot or to the residual.
    if largest > T::default() && largest.is_number() {
        let diagonal_serves = column[k].magnitude() >= T::from_f64(THRESHOLD) * largest;
        Ok(if diagonal_serves { k } else { row })
    } else {
        Err(k)
    }
}

/// Scales column `k` and subtracts its outer product from the columns before `end`.
#[inline(always)]
fn eliminate<T: Scalar>(a: &mut [T], order: usize, k: usize, end: usize) {
    let (left, right) = a.split_at_mut((k + 1) * order);
    let pivot_column = &mut left[k * order..];
    let inverse = T::from_f64(1.0 / pivot_column[k].to_f64());
    pivot_column[k] = inverse;
    pivot_column[k + 1..].iter_mut().for_each(|x| *x *= inverse);
    let lower = &pivot_column[k + 1..];
    for column in right.chunks_exact_mut(order).take(end - k - 1) {
        let factor = -column[k];
        for (x, &l) in column[k + 1..].iter_mut().zip(lower) {
            *x = l.mul_add(factor, *x);
        }
    }
}

/// Applies the eliminated `panel` to the columns after it.
#[inline(always)]
fn update_block<T: Scalar>(a: &mut [T], order: usize, panel: Range<usize>, packed: &mut [[T; COLUMNS]]) {
    let (left, right) = a.split_at_mut(panel.end * order);
    let left = &left[panel.start * order..];
    let packed = &mut packed[..panel.len()];
    for columns in right.chunks_mut(COLUMNS * order) {
        for column in columns.chunks_exact_mut(order) {
            for (k, lower) in panel.clone().zip(left.chunks_exact(order)) {
                let factor = -column[k];
                for (x, &l) in column[k + 1..panel.end].iter_mut().zip(&lower[k + 1..panel.end]) {
                    *x = l.mul_add(factor, *x);
                }
            }
        }
        let width = columns.len() / order;
        Factor { values: &columns[panel.start..], row_stride: 1, column_stride: order }
            .pack(packed, 0, width);
        let rows = order - panel.end;
        subtract_packed(
            (&mut columns[panel.end..], order),
            (rows, width),
            (&left[panel.end..], order),
            packed,
        );
    }
}

/// Applies an eliminated block of large fronts to the columns after it, by faer.
#[inline(never)]
fn update_rest<T: Scalar>(a: &mut [T], order: usize, block: Range<usize>) {
    let (left, right) = a.split_at_mut(block.end * order);
    let left = MatRef::from_column_major_slice_with_stride(
        &left[block.start * order + block.start..],
        order - block.start,
        block.len(),
        order,
    );
    let columns = order - block.end;
    let right = MatMut::from_column_major_slice_mut(right, order, columns).get_mut(block.start.., ..);
    let (diagonal, below) = left.split_at_row(block.len());
    let (mut upper, trailing) = right.split_at_row_mut(block.len());
    solve_unit_lower_triangular_in_place(diagonal, upper.as_mut(), Par::Seq);
    matmul(trailing, Accum::Add, below, upper, -T::ONE, Par::Seq);
}
