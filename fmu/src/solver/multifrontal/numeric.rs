//! Numeric factorisation, front by front.

use super::assembly::Blocks;
use super::dense::{BLOCK, COLUMNS, Factor, Scalar, solve_from_right, subtract_product};
use super::symbolic::{Front, Symbolic};
use super::{SingularMatrix, lu};
use std::sync::Arc;

/// Factors and workspace of one instance; nothing is allocated after `new`.
#[derive(Debug, Clone)]
pub struct Numeric<T = f64> {
    pub(super) symbolic: Arc<Symbolic>,
    /// Slabs of all fronts: F11 | L21 | U12^T.
    pub(super) factors: Vec<T>,
    /// Row interchanges within each front's own unknowns.
    pub(super) swaps: Vec<u32>,
    /// Contributions waiting for their parents, at even and at odd depths.
    stacks: [Vec<T>; 2],
    packed: Vec<[T; COLUMNS]>,
    pub(super) solution: Vec<T>,
    pub(super) border: Vec<T>,
}

impl<T: Scalar> Numeric<T> {
    /// Allocates for a given structure.
    pub fn new(symbolic: Arc<Symbolic>) -> Self {
        let largest_own = symbolic.fronts.iter().map(|f| f.own).max().unwrap_or(0);
        let largest_border = symbolic.fronts.iter().map(|f| f.height).max().unwrap_or(0);
        let unknowns = symbolic.unknowns();
        Self {
            factors: vec![T::default(); symbolic.factor_entries],
            swaps: vec![0; unknowns],
            stacks: symbolic.stack_entries.map(|entries| vec![T::default(); entries]),
            packed: vec![[T::default(); COLUMNS]; largest_own.max(BLOCK)],
            solution: vec![T::default(); unknowns * super::solve::LANES],
            border: vec![T::default(); largest_border * super::solve::LANES],
            symbolic,
        }
    }

    /// The structure it was made for.
    pub fn symbolic(&self) -> &Arc<Symbolic> {
        &self.symbolic
    }

    /// Factorises the matrix whose values stand in the order of the analysed pattern.
    ///
    /// # Errors
    /// When a front has no pivot; the factors are then of no use.
    ///
    /// # Panics
    /// When `values` has another length than the pattern.
    pub fn factorise(&mut self, values: &[f64]) -> Result<(), SingularMatrix> {
        let symbolic = Arc::clone(&self.symbolic);
        assert_eq!(values.len(), symbolic.nonzeros, "one value per entry of the pattern");
        let arch = pulp::Arch::new();
        for front in &symbolic.fronts {
            arch.dispatch(FactorisePivots { numeric: self, symbolic: &symbolic, front, values }).map_err(
                |column| SingularMatrix { unknown: symbolic.order[front.first + column] as usize },
            )?;
            self.eliminate(arch, front);
        }
        Ok(())
    }

    /// Eliminates a front's own unknowns, whose pivots are factorised: the rest of its factors, and its contribution.
    fn eliminate(&mut self, arch: pulp::Arch, front: &Front) {
        let (own, height, border) = (front.own, front.height, front.border.len());
        let (pivot, off_diagonal) = self.factors[front.slab.clone()].split_at_mut(front.lower_start());
        let (lower, upper) = off_diagonal.split_at_mut(height * own);
        let contribution = &mut self.stacks[front.parity][front.contribution.clone()];
        let packed = &mut self.packed;
        let by_columns = Factor { values: &*pivot, row_stride: 1, column_stride: own };
        let transposed = Factor { values: &*pivot, row_stride: own, column_stride: 1 };
        solve_from_right(arch, lower, (height, own), by_columns, false, packed);
        solve_from_right(arch, upper, (height, own), transposed, true, packed);
        let upper = Factor { values: &*upper, row_stride: height, column_stride: 1 };
        subtract_product(arch, (contribution, height), (height, border, own), (lower, height), upper, packed);
    }
}

/// A front's assembly and the factors of its pivots, compiled for the machine's vector instructions.
struct FactorisePivots<'a, T> {
    numeric: &'a mut Numeric<T>,
    symbolic: &'a Symbolic,
    front: &'a Front,
    values: &'a [f64],
}

impl<T: Scalar> pulp::NullaryFnOnce for FactorisePivots<'_, T> {
    type Output = Result<(), usize>;

    #[inline(always)]
    fn call(self) -> Result<(), usize> {
        let Self { numeric, symbolic, front, values } = self;
        let (own, height) = (front.own, front.height);
        let slab = &mut numeric.factors[front.slab.clone()];
        slab.fill(T::default());
        for entry in &symbolic.entries[front.entries.clone()] {
            slab[entry.target as usize] = T::from_f64(values[entry.source as usize]);
        }
        let [even, odd] = &mut numeric.stacks;
        let (stack, children_stack) = if front.parity == 0 { (even, &*odd) } else { (odd, &*even) };
        let contribution = &mut stack[front.contribution.clone()];
        contribution.fill(T::default());

        let (pivot, off_diagonal) = slab.split_at_mut(front.lower_start());
        let (lower, upper) = off_diagonal.split_at_mut(height * own);
        let mut blocks = Blocks { own, height, pivot, lower, upper, contribution };
        for &child in &symbolic.children[front.children.clone()] {
            let child = &symbolic.fronts[child as usize];
            let (to_own, to_border) =
                (&symbolic.runs[child.to_own.clone()], &symbolic.runs[child.to_border.clone()]);
            blocks.extend_add(&children_stack[child.contribution.clone()], child.height, to_own, to_border);
        }

        let Blocks { pivot, upper, .. } = blocks;
        let swaps = &mut numeric.swaps[front.first..][..own];
        lu::factorise(pivot, own, swaps, &mut numeric.packed)?;
        for (k, &row) in swaps.iter().enumerate().filter(|&(k, &row)| row as usize != k) {
            let (head, tail) = upper.split_at_mut(row as usize * height);
            head[k * height..][..height].swap_with_slice(&mut tail[..height]);
        }
        Ok(())
    }
}
