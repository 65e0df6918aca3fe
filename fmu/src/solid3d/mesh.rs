//! Nodes, hanging-node constraints and numbering of the unknowns.
//!
//! A node of a fine cell that lies inside a face or edge of a coarser neighbour, without being one of
//! its nodes, hangs: its value is the neighbour's interpolation there. Hanging nodes carry no unknowns.
//! Their positions are interpolated in the same way, so that the isoparametric cells fit together.

use super::forest::{self, Cell, Key, Refinement, key, surface};
use super::layout::{Chart, EDGE, LAYERS, RINGS, direction, ring_coordinate};
use super::shape::{CORNER_NODES, CORNERS, NODES};
use crate::element::shape::{linear, quadratic};
use crate::mesh::parameters::GeometryParameters;
use std::collections::HashMap;

/// Weights of the nodes that a value is interpolated from.
pub type Terms = Vec<(u32, f64)>;

/// Mesh of the quarter cylinder.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Nodes of every cell, `i + 3 j + 9 k`.
    pub cells: Vec<[u32; NODES]>,
    /// Node positions (m).
    pub nodes: Vec<[f64; 3]>,
    /// Logical node positions.
    logical: Vec<[f64; 3]>,
    /// Per node, the free nodes its displacement is interpolated from (itself, unless it hangs).
    pub displacement_terms: Vec<Terms>,
    /// Per corner node, those its pressure is interpolated from; empty where there is no pressure.
    pub pressure_terms: Vec<Terms>,
    /// First displacement unknown of every free node.
    displacement: Vec<Option<u32>>,
    /// Pressure unknown of every free corner node.
    pressure: Vec<Option<u32>>,
    unknowns: usize,
}

impl Mesh {
    /// The mesh of a geometry.
    pub fn new(geometry: &GeometryParameters, refinement: Refinement<'_>) -> Self {
        let cells = forest::cells(refinement);
        let mut known: HashMap<Key, u32> = HashMap::new();
        let mut logical = Vec::new();
        let mut node_at = |x: [f64; 3]| {
            *known.entry(key(x)).or_insert_with(|| {
                logical.push(x);
                (logical.len() - 1) as u32
            })
        };
        let half = |k: usize| [k % 3, k / 3 % 3, k / 9].map(|i| 0.5 * i as f64);
        let nodes_of: Vec<[u32; NODES]> =
            cells.iter().map(|c| std::array::from_fn(|k| node_at(c.logical(half(k))))).collect();
        let mut is_corner = vec![false; logical.len()];
        for nodes in &nodes_of {
            CORNER_NODES.iter().for_each(|&k| is_corner[nodes[k] as usize] = true);
        }
        let displacement_terms = resolve(hanging_displacements(&cells, &nodes_of, &known, logical.len()));
        let mut pressure_terms = resolve(hanging_pressures(&nodes_of, &is_corner));
        for (terms, corner) in pressure_terms.iter_mut().zip(&is_corner) {
            if !corner {
                terms.clear();
            }
        }
        let chart = Chart::new(geometry);
        let placed: Vec<[f64; 3]> = logical.iter().map(|&x| chart.place(x)).collect();
        let nodes = displacement_terms
            .iter()
            .map(|terms| std::array::from_fn(|d| terms.iter().map(|&(n, w)| w * placed[n as usize][d]).sum()))
            .collect();

        let mut unknowns = 0_u32;
        let (mut displacement, mut pressure) = (Vec::new(), Vec::new());
        let own = |terms: &Terms, node: usize| matches!(terms[..], [(n, _)] if n as usize == node);
        for node in 0..logical.len() {
            let free = own(&displacement_terms[node], node);
            displacement.push(free.then_some(unknowns));
            unknowns += if free { 3 } else { 0 };
            let free = own(&pressure_terms[node], node);
            pressure.push(free.then_some(unknowns));
            unknowns += u32::from(free);
        }
        Self {
            cells: nodes_of,
            nodes,
            logical,
            displacement_terms,
            pressure_terms,
            displacement,
            pressure,
            unknowns: unknowns as usize,
        }
    }

    /// Number of unknowns that are solved for or prescribed; hanging nodes have none.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Number of unknowns as deal.II counts them, those of hanging nodes included.
    pub fn unknowns_with_hanging(&self) -> usize {
        3 * self.nodes.len() + self.pressure_terms.iter().filter(|t| !t.is_empty()).count()
    }

    /// First displacement unknown of a free node.
    pub fn displacement(&self, node: u32) -> Option<usize> {
        self.displacement[node as usize].map(|u| u as usize)
    }

    /// Pressure unknown of a free corner node.
    pub fn pressure(&self, node: u32) -> Option<usize> {
        self.pressure[node as usize].map(|p| p as usize)
    }

    /// Whether an unknown is a pressure.
    pub fn pressure_mask(&self) -> Vec<bool> {
        let mut mask = vec![false; self.unknowns];
        self.pressure.iter().flatten().for_each(|&p| mask[p as usize] = true);
        mask
    }

    /// Unit normal (cosine, sine) of the lateral surface at its nodes: there the first two unknowns of
    /// a node are its radial and its tangential displacement instead of x and y.
    pub fn side_normal(&self, node: u32) -> Option<(f64, f64)> {
        self.is_side(node).then(|| direction(self.logical[node as usize]))
    }

    /// Centre of a cell in ring coordinate, polar angle and layer, in which separators are planes.
    pub fn polar_centre(&self, cell: usize) -> [f64; 3] {
        let x = self.logical[self.cells[cell][13] as usize];
        let (cos, sin) = direction(x);
        [ring_coordinate(x), sin.atan2(cos), x[2]]
    }

    fn ring(&self, node: u32) -> f64 {
        ring_coordinate(self.logical[node as usize])
    }

    /// Whether a node lies on the symmetry plane x = 0 (`direction` 0) or y = 0 (1).
    pub fn on_plane(&self, node: u32, direction: usize) -> bool {
        self.logical[node as usize][direction] == 0.0
    }

    /// Whether a node lies on the bottom.
    pub fn is_bottom(&self, node: u32) -> bool {
        self.logical[node as usize][2] == 0.0
    }

    /// Whether a node lies on the lateral surface.
    pub fn is_side(&self, node: u32) -> bool {
        self.ring(node) == (RINGS + 1) as f64
    }

    /// Whether a node lies under the punch, its edge included.
    pub fn is_punch(&self, node: u32) -> bool {
        self.is_top(node) && self.ring(node) <= EDGE
    }

    /// Whether a node lies on the free part of the top, the punch's edge included.
    pub fn is_free_top(&self, node: u32) -> bool {
        self.is_top(node) && self.ring(node) >= EDGE
    }

    fn is_top(&self, node: u32) -> bool {
        self.logical[node as usize][2] == LAYERS as f64
    }

    /// Cells whose upper face lies under the punch.
    pub fn punch_cells(&self) -> impl Iterator<Item = usize> + '_ {
        let covered = |nodes: &[u32; NODES]| nodes[18..].iter().all(|&n| self.is_punch(n));
        self.cells.iter().enumerate().filter(move |(_, nodes)| covered(nodes)).map(|(cell, _)| cell)
    }

    /// Side of the smallest cell at the punch's edge, radial (m).
    pub fn edge_size(&self) -> f64 {
        let touches = |&n: &u32| self.is_punch(n) && self.is_free_top(n);
        let radius = |n: u32| self.nodes[n as usize][0].hypot(self.nodes[n as usize][1]);
        let sizes =
            self.cells.iter().filter(|c| c.iter().any(touches)).map(|c| radius(c[26]) - radius(c[24]));
        sizes.fold(f64::INFINITY, |m, s| m.min(s.abs()))
    }
}

/// Direct constraints of nodes at quarter points of a coarser cell's faces; empty for free nodes.
fn hanging_displacements(
    cells: &[Cell],
    nodes_of: &[[u32; NODES]],
    known: &HashMap<Key, u32>,
    nodes: usize,
) -> Vec<Terms> {
    let mut hanging = vec![Terms::new(); nodes];
    for (cell, own) in cells.iter().zip(nodes_of) {
        for p in surface(4).filter(|p| p.iter().any(|i| i % 2 == 1)) {
            let Some(&node) = known.get(&key(cell.logical(p.map(|i| 0.25 * i as f64)))) else { continue };
            let q = p.map(|i| quadratic(0.5 * i as f64 - 1.0).0);
            let weight = |k: usize| q[0][k % 3] * q[1][k / 3 % 3] * q[2][k / 9];
            hanging[node as usize] =
                (0..NODES).map(|k| (own[k], weight(k))).filter(|(_, w)| *w != 0.0).collect();
        }
    }
    hanging
}

/// Direct constraints of corner nodes at half points of a coarser cell's faces.
fn hanging_pressures(nodes_of: &[[u32; NODES]], is_corner: &[bool]) -> Vec<Terms> {
    let mut hanging = vec![Terms::new(); is_corner.len()];
    for own in nodes_of {
        for p in surface(2).filter(|p| p.contains(&1)) {
            let node = own[p[0] + 3 * p[1] + 9 * p[2]] as usize;
            if is_corner[node] {
                let l = p.map(|i| linear(i as f64 - 1.0));
                let weight = |m: usize| l[0][m % 2] * l[1][m / 2 % 2] * l[2][m / 4];
                hanging[node] = (0..CORNERS)
                    .map(|m| (own[CORNER_NODES[m]], weight(m)))
                    .filter(|(_, w)| *w != 0.0)
                    .collect();
            }
        }
    }
    hanging
}

/// Follows constraints to free nodes.
fn resolve(direct: Vec<Terms>) -> Vec<Terms> {
    let mut resolved = vec![Terms::new(); direct.len()];
    for node in 0..direct.len() {
        resolve_node(node, &direct, &mut resolved);
    }
    resolved
}

fn resolve_node(node: usize, direct: &[Terms], resolved: &mut [Terms]) {
    if !resolved[node].is_empty() {
        return;
    }
    if direct[node].is_empty() {
        resolved[node] = vec![(node as u32, 1.0)];
        return;
    }
    let mut terms = Terms::new();
    // A cell's nodes hang at most on cells one level coarser: the recursion ends with the levels.
    for &(master, weight) in &direct[node] {
        resolve_node(master as usize, direct, resolved);
        terms.extend(resolved[master as usize].iter().map(|&(n, w)| (n, weight * w)));
    }
    terms.sort_unstable_by_key(|t| t.0);
    terms.dedup_by(|b, a| {
        a.0 == b.0 && {
            a.1 += b.1;
            true
        }
    });
    terms.retain(|t| t.1.abs() > 1e-14);
    resolved[node] = terms;
}

#[cfg(test)]
#[path = "mesh_tests.rs"]
mod tests;
