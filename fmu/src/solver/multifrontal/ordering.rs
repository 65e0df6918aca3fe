//! Fill-reducing ordering: recursive bisection of the elements.

use super::StructureError;

/// Connectivity of a finite-element system: the element connectivity is the truth.
#[derive(Debug, Clone, Default)]
pub struct Connectivity {
    /// Number of unknowns.
    pub unknowns: usize,
    /// Unknowns of each element (indices below `unknowns`).
    pub elements: Vec<Vec<u32>>,
    /// Centre of each element, in any length unit.
    pub centroids: Vec<[f64; 3]>,
    /// Per unknown: within a separator lower ranks are eliminated first (0 displacement, 1 pressure, whose
    /// own diagonal may be zero).
    pub rank: Vec<u8>,
}

impl Connectivity {
    pub(super) fn validate(&self) -> Result<(), StructureError> {
        let inconsistent = |what| Err(StructureError::Inconsistent(what));
        if self.elements.len() != self.centroids.len() {
            return inconsistent("one centroid per element is needed");
        }
        if self.rank.len() != self.unknowns {
            return inconsistent("one rank per unknown is needed");
        }
        if self.unknowns > u32::MAX as usize / 2 {
            return inconsistent("too many unknowns for 32-bit indices");
        }
        if self.elements.iter().flatten().any(|&u| u as usize >= self.unknowns) {
            return inconsistent("an element names an unknown that does not exist");
        }
        if self.centroids.iter().flatten().any(|x| !x.is_finite()) {
            return inconsistent("a centroid is not finite");
        }
        Ok(())
    }
}

/// One part of the mesh: the unknowns that become interior when its two halves are joined.
#[derive(Debug, Clone, Default)]
pub(super) struct Node {
    /// Unknowns eliminated here, in order.
    pub own: Vec<u32>,
    /// Unknowns that this part shares with the rest of the mesh.
    pub border: Vec<u32>,
    /// Positions of the children, which are lower.
    pub children: Vec<usize>,
}

/// The dissection tree, children before parents; unknowns of no element are roots of their own.
pub(super) fn dissect(structure: &Connectivity) -> Vec<Node> {
    let mut dissection = Dissection {
        structure,
        nodes: Vec::new(),
        taken: vec![false; structure.unknowns],
        seen: vec![0; structure.unknowns],
        stamp: 0,
        span: vec![(0, 0); structure.unknowns],
    };
    let mut elements: Vec<u32> = (0..structure.elements.len() as u32).collect();
    if !elements.is_empty() {
        dissection.bisect(&mut elements);
    }
    let lonely = (0..structure.unknowns as u32).filter(|&u| !dissection.taken[u as usize]);
    let lonely: Vec<Node> = lonely.map(|u| Node { own: vec![u], ..Node::default() }).collect();
    dissection.nodes.extend(lonely);
    dissection.nodes
}

struct Dissection<'a> {
    structure: &'a Connectivity,
    nodes: Vec<Node>,
    /// Unknowns that a separator, or a finished leaf, already eliminates.
    taken: Vec<bool>,
    /// Stamp of the last set an unknown was put into.
    seen: Vec<u32>,
    stamp: u32,
    /// First and last element that holds an unknown, along the axis being tried.
    span: Vec<(u32, u32)>,
}

impl Dissection<'_> {
    /// Adds the tree of `elements` and returns the position of its root.
    fn bisect(&mut self, elements: &mut [u32]) -> usize {
        if let [element] = *elements {
            let (border, mut own): (Vec<u32>, Vec<u32>) =
                self.distinct(&[element]).into_iter().partition(|&u| self.taken[u as usize]);
            self.sort_and_take(&mut own);
            return self.push(Node { own, border, children: Vec::new() });
        }
        let cut = self.best_cut(elements);
        let (left, right) = elements.split_at_mut(cut);
        self.distinct(left);
        let in_left = self.stamp;
        let mut separator = Vec::new();
        for &element in right.iter() {
            for &u in &self.structure.elements[element as usize] {
                if self.seen[u as usize] == in_left && !self.taken[u as usize] {
                    self.seen[u as usize] = 0; // once only
                    separator.push(u);
                }
            }
        }
        self.sort_and_take(&mut separator);

        let children = vec![self.bisect(left), self.bisect(right)];
        self.stamp += 1;
        separator.iter().for_each(|&u| self.seen[u as usize] = self.stamp);
        let mut border = Vec::new();
        for &child in &children {
            for &u in &self.nodes[child].border {
                if self.seen[u as usize] != self.stamp {
                    self.seen[u as usize] = self.stamp;
                    border.push(u);
                }
            }
        }
        self.push(Node { own: separator, border, children })
    }

    fn push(&mut self, node: Node) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    fn sort_and_take(&mut self, own: &mut [u32]) {
        own.sort_unstable_by_key(|&u| (self.structure.rank[u as usize], u));
        own.iter().for_each(|&u| self.taken[u as usize] = true);
    }

    /// The distinct unknowns of `elements`, which carry the present stamp afterwards.
    fn distinct(&mut self, elements: &[u32]) -> Vec<u32> {
        self.stamp += 1;
        let mut unknowns = Vec::new();
        for &element in elements {
            for &u in &self.structure.elements[element as usize] {
                if self.seen[u as usize] != self.stamp {
                    self.seen[u as usize] = self.stamp;
                    unknowns.push(u);
                }
            }
        }
        unknowns
    }

    /// Sorts `elements` along the axis, and returns the cut near the median, with the smallest separator.
    fn best_cut(&mut self, elements: &mut [u32]) -> usize {
        let centroids = &self.structure.centroids;
        let sort = |elements: &mut [u32], axis: usize| {
            let key = |e: u32| {
                let c = centroids[e as usize];
                [c[axis], c[(axis + 1) % 3], c[(axis + 2) % 3]]
            };
            elements.sort_unstable_by(|&a, &b| {
                let by = key(a).into_iter().zip(key(b)).map(|(x, y)| x.total_cmp(&y));
                by.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then).then(a.cmp(&b))
            });
        };
        let mut best = (f64::INFINITY, 0, 0);
        for axis in 0..3 {
            sort(elements, axis);
            let (cost, cut) = self.cheapest_cut(elements);
            // Strictly cheaper: of equal axes the first wins, so that the ordering is reproducible.
            if cost < best.0 {
                best = (cost, axis, cut);
            }
        }
        sort(elements, best.1);
        best.2
    }

    /// Cost and place of the best cut of a sorted list: separator size, made dearer off the
    /// middle.
    fn cheapest_cut(&mut self, elements: &[u32]) -> (f64, usize) {
        let n = elements.len();
        let unknowns = self.distinct(elements);
        for &u in &unknowns {
            self.span[u as usize] = (u32::MAX, 0);
        }
        for (place, &element) in elements.iter().enumerate() {
            for &u in &self.structure.elements[element as usize] {
                let span = &mut self.span[u as usize];
                *span = (span.0.min(place as u32), place as u32);
            }
        }
        // An unknown is cut by every cut in first < cut <= last.
        let mut change = vec![0_i32; n + 1];
        for &u in unknowns.iter().filter(|&&u| !self.taken[u as usize]) {
            let (first, last) = self.span[u as usize];
            change[first as usize + 1] += 1;
            change[last as usize + 1] -= 1;
        }
        let mut best = (f64::INFINITY, n / 2);
        let mut separator = 0;
        // Within a fifth of the middle: the smallest separators of all only chip off corners.
        let near_middle = (2 * n / 5).max(1)..=(3 * n).div_ceil(5).min(n - 1);
        for (cut, &change) in change.iter().enumerate() {
            separator += change;
            let off_middle = (2 * cut) as f64 / n as f64 - 1.0;
            let cost = f64::from(separator + 1) * (1.0 + 4.0 * off_middle * off_middle);
            if near_middle.contains(&cut) && cost < best.0 {
                best = (cost, cut);
            }
        }
        best
    }
}
