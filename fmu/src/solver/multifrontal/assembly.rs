//! Index maps into fronts, and the additions they describe.

use super::dense::Scalar;
use super::symbolic::Front;

/// Value `source` of the matrix is assembled at `target` of its front's slab.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    pub source: u32,
    pub target: u32,
}

/// Consecutive border unknowns of a child that are consecutive in the parent, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Run {
    pub from: u32,
    pub to: u32,
    pub length: u32,
}

impl Run {
    fn pairs(self) -> impl Iterator<Item = (usize, usize)> {
        (self.from as usize..).zip(self.to as usize..).take(self.length as usize)
    }
}

/// Groups the targets of the sources `first`, `first + 1`, ... into runs.
pub(super) fn runs(first: u32, targets: impl Iterator<Item = u32>) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (from, to) in (first..).zip(targets) {
        match runs.last_mut() {
            Some(run) if run.to + run.length == to => run.length += 1,
            _ => runs.push(Run { from, to, length: 1 }),
        }
    }
    runs
}

/// Place of the entry (`row`, `column`), in elimination indices, in the slab of the front that eliminates the
/// first of the two; `None` if the other is not in that front.
pub(super) fn entry_target(front: &Front, border: &[u32], row: usize, column: usize) -> Option<u32> {
    let own = |u: usize| (u < front.first + front.own).then(|| u - front.first);
    let outer = |u: usize| border.binary_search(&(u as u32)).ok();
    let target = match (own(row), own(column)) {
        (Some(i), Some(j)) => i + j * front.own,
        (None, Some(j)) => front.lower_start() + outer(row)? + j * front.height,
        (Some(i), None) => front.upper_start() + outer(column)? + i * front.height,
        (None, None) => return None,
    };
    Some(target as u32)
}

/// A front being assembled: F11 and L21 by columns, U12 by rows, contribution by columns.
pub(super) struct Blocks<'a, T> {
    pub own: usize,
    pub height: usize,
    pub pivot: &'a mut [T],
    pub lower: &'a mut [T],
    pub upper: &'a mut [T],
    pub contribution: &'a mut [T],
}

impl<T: Scalar> Blocks<'_, T> {
    /// Adds the contribution of a child (column stride `height`).
    #[inline(always)]
    pub fn extend_add(&mut self, child: &[T], height: usize, to_own: &[Run], to_border: &[Run]) {
        for (from, to) in to_own.iter().flat_map(|r| r.pairs()) {
            let source = &child[from * height..][..height];
            add_runs(&mut self.pivot[to * self.own..][..self.own], source, to_own);
            add_runs(&mut self.lower[to * self.height..][..self.height], source, to_border);
        }
        for run in to_border {
            for (from, to) in run.pairs() {
                let source = &child[from * height..][..height];
                add_runs(&mut self.contribution[to * self.height..][..self.height], source, to_border);
                for (i, row) in to_own.iter().flat_map(|r| r.pairs()) {
                    self.upper[row * self.height + to] += source[i];
                }
            }
        }
    }
}

#[inline(always)]
fn add_runs<T: Scalar>(target: &mut [T], source: &[T], runs: &[Run]) {
    for run in runs {
        let (from, to, length) = (run.from as usize, run.to as usize, run.length as usize);
        for (x, &y) in target[to..][..length].iter_mut().zip(&source[from..][..length]) {
            *x += y;
        }
    }
}
