//! Everything about a factorisation that does not depend on the values; shared by all instances.

use super::assembly::{Entry, Run, entry_target, runs};
use super::ordering::{Connectivity, Node, dissect};
use super::{StructureError, dense};
use faer::Index;
use faer::sparse::SymbolicSparseColMatRef;
use std::ops::Range;

/// One dense front: sizes, and where its parts lie in the numeric storage.
#[derive(Debug, Clone, Default)]
pub(super) struct Front {
    /// First own unknown, in elimination order; the own unknowns follow each other.
    pub first: usize,
    /// Number of own unknowns.
    pub own: usize,
    /// Elimination indices of the border, ascending, in `Symbolic::borders`.
    pub border: Range<usize>,
    /// Length of the border, padded to whole vectors: column stride of L21, U12^T and the contribution.
    pub height: usize,
    /// F11 | L21 | U12^T in the factors.
    pub slab: Range<usize>,
    /// Contribution to the parent, in the stack of this depth's parity.
    pub contribution: Range<usize>,
    /// Depth in the tree, odd or even: a front and its children use different stacks.
    pub parity: usize,
    /// Matrix entries assembled here, in `Symbolic::entries`.
    pub entries: Range<usize>,
    /// Children, in `Symbolic::children`.
    pub children: Range<usize>,
    /// Where the border goes in the parent's own block, in `Symbolic::runs`.
    pub to_own: Range<usize>,
    /// Where the border goes in the parent's border, in `Symbolic::runs`.
    pub to_border: Range<usize>,
}

impl Front {
    /// Start of L21 within the slab.
    pub fn lower_start(&self) -> usize {
        self.own * self.own
    }

    /// Start of U12^T within the slab.
    pub fn upper_start(&self) -> usize {
        self.lower_start() + self.height * self.own
    }
}

/// Sizes of a factorisation: a loss of efficiency shows here without timing anything.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FactorSizes {
    /// Number of fronts.
    pub fronts: usize,
    /// Order of the largest front.
    pub largest_front: usize,
    /// Numbers held in the factors (explicit zeros and padding included).
    pub factor_entries: usize,
    /// Numbers held in the two contribution stacks.
    pub workspace_entries: usize,
    /// Floating-point operations of one factorisation.
    pub flops: u64,
}

/// Ordering, fronts, assembly maps and workspace sizes of one mesh.
#[derive(Debug)]
pub struct Symbolic {
    pub(super) fronts: Vec<Front>,
    pub(super) borders: Vec<u32>,
    pub(super) children: Vec<u32>,
    pub(super) entries: Vec<Entry>,
    pub(super) runs: Vec<Run>,
    /// Unknown eliminated at each place.
    pub(super) order: Vec<u32>,
    pub(super) nonzeros: usize,
    pub(super) factor_entries: usize,
    pub(super) stack_entries: [usize; 2],
}

impl Symbolic {
    /// Orders the unknowns and lays out the fronts; `pattern` is the union of the elements' couplings
    /// (square, structurally symmetric or not).
    ///
    /// # Errors
    /// When the structure is inconsistent, or the pattern has an entry outside the elements.
    pub fn analyse(
        structure: &Connectivity,
        pattern: SymbolicSparseColMatRef<'_, impl Index>,
    ) -> Result<Self, StructureError> {
        structure.validate()?;
        if pattern.nrows() != structure.unknowns || pattern.ncols() != structure.unknowns {
            return Err(StructureError::Inconsistent("the pattern has another number of unknowns"));
        }
        let mut nodes = dissect(structure);
        let parent = amalgamate(&mut nodes);
        let mut symbolic = Self::lay_out(nodes, &parent, structure.unknowns);
        symbolic.map_entries(pattern)?;
        Ok(symbolic)
    }

    /// Sizes of the factorisation.
    pub fn statistics(&self) -> FactorSizes {
        let order = |f: &Front| f.own + f.border.len();
        FactorSizes {
            fronts: self.fronts.len(),
            largest_front: self.fronts.iter().map(order).max().unwrap_or(0),
            factor_entries: self.factor_entries,
            workspace_entries: self.stack_entries.iter().sum(),
            flops: self.fronts.iter().map(|f| flops(f.own, f.border.len()) as u64).sum(),
        }
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.order.len()
    }

    /// Numbers the unknowns front by front and places every front's storage.
    fn lay_out(nodes: Vec<Node>, parent: &[Option<usize>], unknowns: usize) -> Self {
        let mut place = vec![0_u32; unknowns]; // unknown -> elimination index
        let mut order = Vec::with_capacity(unknowns);
        for &unknown in nodes.iter().flat_map(|n| &n.own) {
            place[unknown as usize] = order.len() as u32;
            order.push(unknown);
        }
        let mut depth = vec![0_usize; nodes.len()];
        for i in (0..nodes.len()).rev() {
            depth[i] = parent[i].map_or(0, |p| depth[p] + 1);
        }
        let mut symbolic = Self {
            fronts: Vec::with_capacity(nodes.len()),
            borders: Vec::new(),
            children: Vec::new(),
            entries: Vec::new(),
            runs: Vec::new(),
            order,
            nonzeros: 0,
            factor_entries: 0,
            stack_entries: [0; 2],
        };
        let mut top = [0; 2];
        let mut first = 0;
        for (i, node) in nodes.iter().enumerate() {
            let own = node.own.len();
            let height = node.border.len().next_multiple_of(dense::ROWS);
            let parity = depth[i] % 2;
            let mut border: Vec<u32> = node.border.iter().map(|&u| place[u as usize]).collect();
            border.sort_unstable();

            let slab = symbolic.factor_entries..symbolic.factor_entries + own * (own + 2 * height);
            symbolic.factor_entries = slab.end;
            let contribution = top[parity]..top[parity] + height * border.len();
            top[parity] = contribution.end;
            symbolic.stack_entries[parity] = symbolic.stack_entries[parity].max(top[parity]);
            if let Some(&child) = node.children.first() {
                top[1 - parity] = symbolic.fronts[child].contribution.start;
            }
            symbolic.fronts.push(Front {
                first,
                own,
                border: extend(&mut symbolic.borders, border),
                height,
                slab,
                contribution,
                parity,
                children: extend(&mut symbolic.children, node.children.iter().map(|&c| c as u32)),
                ..Front::default()
            });
            first += own;
        }
        for (i, parent) in parent.iter().enumerate() {
            if let Some(parent) = *parent {
                symbolic.map_border(i, parent);
            }
        }
        symbolic
    }

    /// Where the contribution of `child` goes in `parent`.
    fn map_border(&mut self, child: usize, parent: usize) {
        let parent = self.fronts[parent].clone();
        let border = &self.borders[self.fronts[child].border.clone()];
        let end = (parent.first + parent.own) as u32;
        let split = border.partition_point(|&u| u < end);
        let to_own = border[..split].iter().map(|&u| u - parent.first as u32);
        let parent_border = &self.borders[parent.border];
        let to_border = border[split..].iter().map(|&u| parent_border.partition_point(|&v| v < u) as u32);
        let (to_own, to_border) = (runs(0, to_own), runs(split as u32, to_border));
        self.fronts[child].to_own = extend(&mut self.runs, to_own);
        self.fronts[child].to_border = extend(&mut self.runs, to_border);
    }

    /// Which front, and where in it, takes each matrix entry.
    fn map_entries(
        &mut self,
        pattern: SymbolicSparseColMatRef<'_, impl Index>,
    ) -> Result<(), StructureError> {
        let mut place = vec![0; self.order.len()];
        let mut front_of = vec![0_u32; self.order.len()];
        for (i, &unknown) in self.order.iter().enumerate() {
            place[unknown as usize] = i;
        }
        for (i, front) in self.fronts.iter().enumerate() {
            front_of[front.first..front.first + front.own].fill(i as u32);
        }
        let mut entries = Vec::with_capacity(pattern.row_idx().len());
        for column in 0..pattern.ncols() {
            for source in pattern.col_range(column) {
                let row = pattern.row_idx()[source].zx();
                let (i, j) = (place[row], place[column]);
                let owner = front_of[i.min(j)];
                let front = &self.fronts[owner as usize];
                let target = entry_target(front, &self.borders[front.border.clone()], i, j)
                    .ok_or(StructureError::EntryOutsideElements { row, column })?;
                entries.push((owner, Entry { source: source as u32, target }));
            }
        }
        entries.sort_unstable_by_key(|(owner, entry)| (*owner, entry.target));
        let mut start = 0;
        for (i, front) in self.fronts.iter_mut().enumerate() {
            let end = start + entries[start..].partition_point(|(owner, _)| *owner as usize <= i);
            front.entries = start..end;
            start = end;
        }
        self.nonzeros = entries.len();
        self.entries = entries.into_iter().map(|(_, entry)| entry).collect();
        Ok(())
    }
}

/// Appends the items and returns where they are.
fn extend<T>(list: &mut Vec<T>, items: impl IntoIterator<Item = T>) -> Range<usize> {
    let start = list.len();
    list.extend(items);
    start..list.len()
}

/// Operations to eliminate `own` unknowns of a front with `border` others.
fn flops(own: usize, border: usize) -> f64 {
    let (own, border) = (own as f64, border as f64);
    own * (own * own / 1.5 + 2.0 * border * (own + border))
}

/// Time of a front, in units of one operation inside the dense kernels (measured: see the bench).
fn cost(own: usize, border: usize) -> f64 {
    const PER_FRONT: f64 = 6000.0;
    const PER_FACTOR_ENTRY: f64 = 6.0;
    const PER_CONTRIBUTION_ENTRY: f64 = 16.0;
    let factor = (own * (own + 2 * border)) as f64;
    let contribution = (border * border) as f64;
    PER_FRONT + flops(own, border) + PER_FACTOR_ENTRY * factor + PER_CONTRIBUTION_ENTRY * contribution
}

/// Merges children into parents where one larger front is cheaper than two, explicit zeros included;
/// leaves the nodes in postorder and returns their parents.
fn amalgamate(nodes: &mut Vec<Node>) -> Vec<Option<usize>> {
    for i in 0..nodes.len() {
        let mut node = std::mem::take(&mut nodes[i]);
        let mut candidates = std::mem::take(&mut node.children);
        let mut merged = Vec::new();
        while let Some(c) = candidates.pop() {
            let child = &mut nodes[c];
            let (own, border) = (merged.len() + node.own.len(), node.border.len());
            let apart = cost(child.own.len(), child.border.len()) + cost(own, border);
            if cost(child.own.len() + own, border) <= apart {
                merged.splice(0..0, child.own.drain(..));
                candidates.append(&mut child.children);
            } else {
                node.children.push(c);
            }
        }
        merged.append(&mut node.own);
        node.own = merged;
        nodes[i] = node;
    }
    // Whoever is nobody's child and still owns something is a root.
    let mut is_child = vec![false; nodes.len()];
    nodes.iter().flat_map(|n| &n.children).for_each(|&c| is_child[c] = true);
    let roots: Vec<usize> = (0..nodes.len()).filter(|&i| !is_child[i] && !nodes[i].own.is_empty()).collect();

    let mut ordered = Vec::with_capacity(nodes.len());
    for root in roots {
        postorder(nodes, root, &mut ordered);
    }
    let mut parent = vec![None; ordered.len()];
    for (i, node) in ordered.iter().enumerate() {
        node.children.iter().for_each(|&c| parent[c] = Some(i));
    }
    *nodes = ordered;
    parent
}

/// Moves the subtree of `root` to the end of `ordered` and returns its new position.
fn postorder(nodes: &mut [Node], root: usize, ordered: &mut Vec<Node>) -> usize {
    let mut node = std::mem::take(&mut nodes[root]);
    for child in &mut node.children {
        *child = postorder(nodes, *child, ordered);
    }
    ordered.push(node);
    ordered.len() - 1
}
