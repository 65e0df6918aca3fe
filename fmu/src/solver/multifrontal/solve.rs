//! Forward and back substitution.

use super::dense::{ROWS, Scalar};
use super::numeric::Numeric;
use super::symbolic::Front;
use std::sync::Arc;

/// Right-hand sides solved for at a time.
pub(super) const LANES: usize = 8;

impl<T: Scalar> Numeric<T> {
    /// Solves A X = B with the factors; `rhs` holds `columns` right-hand sides one after the other and takes
    /// the solutions.
    ///
    /// # Panics
    /// When `rhs` is not `columns` vectors long.
    pub fn solve_in_place(&mut self, rhs: &mut [f64], columns: usize) {
        let unknowns = self.symbolic.unknowns();
        assert_eq!(rhs.len(), unknowns * columns, "one entry per unknown and right-hand side");
        if unknowns == 0 {
            return;
        }
        let arch = pulp::Arch::new();
        for chunk in rhs.chunks_mut(LANES * unknowns) {
            // A few right-hand sides are cheaper one by one than in eight lanes.
            if chunk.len() < 3 * unknowns {
                chunk.chunks_mut(unknowns).for_each(|one| arch.dispatch(Substitution::<T, 1>(self, one)));
            } else {
                arch.dispatch(Substitution::<T, LANES>(self, chunk));
            }
        }
    }
}

/// Solves for up to W right-hand sides; entry i of all of them stands together in the workspace.
struct Substitution<'a, T, const W: usize>(&'a mut Numeric<T>, &'a mut [f64]);

impl<T: Scalar, const W: usize> pulp::NullaryFnOnce for Substitution<'_, T, W> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self(numeric, rhs) = self;
        let symbolic = Arc::clone(&numeric.symbolic);
        let unknowns = symbolic.unknowns();
        let x = &mut numeric.solution.as_chunks_mut::<W>().0[..unknowns];
        let border = numeric.border.as_chunks_mut::<W>().0;
        for (x, &unknown) in x.iter_mut().zip(&symbolic.order) {
            for (x, column) in x.iter_mut().zip(rhs.chunks_exact(unknowns)) {
                *x = T::from_f64(column[unknown as usize]);
            }
        }
        for front in &symbolic.fronts {
            let slab = &numeric.factors[front.slab.clone()];
            let swaps = &numeric.swaps[front.first..][..front.own];
            let border = &mut border[..front.height];
            forward(front, slab, swaps, &mut x[front.first..][..front.own], border);
            for (&place, &y) in symbolic.borders[front.border.clone()].iter().zip(&*border) {
                for (x, y) in x[place as usize].iter_mut().zip(y) {
                    *x -= y;
                }
            }
        }
        for front in symbolic.fronts.iter().rev() {
            let slab = &numeric.factors[front.slab.clone()];
            let border = &mut border[..front.height];
            for (y, &place) in border.iter_mut().zip(&symbolic.borders[front.border.clone()]) {
                *y = x[place as usize];
            }
            border[front.border.len()..].fill([T::default(); W]); // padding
            backward(front, slab, &mut x[front.first..][..front.own], border);
        }
        for (x, &unknown) in x.iter().zip(&symbolic.order) {
            for (x, column) in x.iter().zip(rhs.chunks_exact_mut(unknowns)) {
                column[unknown as usize] = x.to_f64();
            }
        }
    }
}

/// x <- L11^-1 P x; border <- L21 x.
#[inline(always)]
fn forward<T: Scalar, const W: usize>(
    front: &Front,
    slab: &[T],
    swaps: &[u32],
    x: &mut [[T; W]],
    border: &mut [[T; W]],
) {
    for (k, &row) in swaps.iter().enumerate() {
        x.swap(k, row as usize);
    }
    for (k, column) in slab[..front.lower_start()].chunks_exact(front.own.max(1)).enumerate() {
        let (head, tail) = x.split_at_mut(k + 1);
        subtract_scaled(tail, &column[k + 1..], &head[k]);
    }
    border.fill([T::default(); W]);
    let lower = &slab[front.lower_start()..front.upper_start()];
    for (column, x) in lower.chunks_exact(front.height.max(1)).zip(&*x) {
        for (y, &l) in border.iter_mut().zip(column) {
            for (y, &x) in y.iter_mut().zip(x) {
                *y = l.mul_add(x, *y);
            }
        }
    }
}

/// x <- U11^-1 (x - U12 border).
#[inline(always)]
fn backward<T: Scalar, const W: usize>(front: &Front, slab: &[T], x: &mut [[T; W]], border: &[[T; W]]) {
    for (x, row) in x.iter_mut().zip(slab[front.upper_start()..].chunks_exact(front.height.max(1))) {
        // One sum per row of a tile, so that a single right-hand side vectorises, too.
        let mut sums = [[T::default(); W]; ROWS];
        let (row, border) = (row.as_chunks::<ROWS>().0, border.as_chunks::<ROWS>().0);
        for (u, y) in row.iter().zip(border) {
            for (sum, (&u, y)) in sums.iter_mut().zip(u.iter().zip(y)) {
                for (sum, &y) in sum.iter_mut().zip(y) {
                    *sum = u.mul_add(y, *sum);
                }
            }
        }
        for sum in &sums {
            for (x, &sum) in x.iter_mut().zip(sum) {
                *x -= sum;
            }
        }
    }
    for (k, column) in slab[..front.lower_start()].chunks_exact(front.own.max(1)).enumerate().rev() {
        let (head, tail) = x.split_at_mut(k);
        tail[0].iter_mut().for_each(|x| *x *= column[k]); // the inverse pivot
        subtract_scaled(head, &column[..k], &tail[0]);
    }
}

/// x -= column factor.
#[inline(always)]
fn subtract_scaled<T: Scalar, const W: usize>(x: &mut [[T; W]], column: &[T], factor: &[T; W]) {
    for (x, &l) in x.iter_mut().zip(column) {
        for (x, &factor) in x.iter_mut().zip(factor) {
            *x = (-l).mul_add(factor, *x);
        }
    }
}
