//! Cells by repeated bisection of the blocks, towards the punch's edge.

use super::layout::{Block, EDGE, LAYERS, blocks, ring_coordinate};
use std::collections::HashMap;

/// A cell: one of the `8^level` equal parts of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cell {
    /// The block.
    pub block: Block,
    /// How often it was bisected.
    pub level: u8,
    /// Lower corner, in units of the cell's size.
    pub origin: [u32; 3],
}

/// A logical position as exact integers.
pub type Key = [i64; 3];

/// The key of a dyadic logical position.
pub fn key(x: [f64; 3]) -> Key {
    // Positions are multiples of 2^-16 at most.
    x.map(|x| (x * f64::from(1 << 24)) as i64)
}

impl Cell {
    /// Logical coordinates of the place `xi` in [0, 1]^3 of the cell.
    pub fn logical(&self, xi: [f64; 3]) -> [f64; 3] {
        let size = 1.0 / f64::from(1_u32 << self.level);
        self.block.logical(std::array::from_fn(|d| (f64::from(self.origin[d]) + xi[d]) * size))
    }

    fn children(&self) -> [Self; 8] {
        std::array::from_fn(|c| Self {
            block: self.block,
            level: self.level + 1,
            origin: std::array::from_fn(|d| 2 * self.origin[d] + (c >> d & 1) as u32),
        })
    }

    /// Logical distance of the cell's centre from the punch's edge.
    fn distance(&self) -> f64 {
        let x = self.logical([0.5; 3]);
        (ring_coordinate(x) - EDGE).hypot(LAYERS as f64 - x[2])
    }
}

/// How far from the punch's edge cells are refined: a cell of level `l` whose centre is nearer than
/// `reach[l]` (in coarse cells) is bisected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refinement<'a> {
    /// Radii of the refined zones, from the coarsest level on.
    pub reach: &'a [f64],
}

/// The paper's size: 3184 cells, edge cells of 1/16 of the punch radius.
///
/// Half that size would turn cells at the edge inside out before the punch is 1 mm deep.
pub const PAPER: Refinement<'static> = Refinement { reach: &[9.0, 2.2, 1.14] };
/// A quick mesh of the same layout, edge cells of 1/8 of the punch radius: for tests.
pub const COARSE: Refinement<'static> = Refinement { reach: &[1.2, 0.6] };

/// The refined and balanced cells: neighbours, across edges and corners too, differ by one level at most.
pub fn cells(refinement: Refinement<'_>) -> Vec<Cell> {
    let mut cells: Vec<Cell> =
        blocks().into_iter().map(|block| Cell { block, level: 0, origin: [0; 3] }).collect();
    for (level, &reach) in refinement.reach.iter().enumerate() {
        cells = refine(cells, |c| usize::from(c.level) == level && c.distance() < reach);
        balance(&mut cells);
    }
    cells
}

fn refine(cells: Vec<Cell>, which: impl Fn(&Cell) -> bool) -> Vec<Cell> {
    let mut refined = Vec::with_capacity(cells.len());
    for cell in cells {
        if which(&cell) { refined.extend(cell.children()) } else { refined.push(cell) }
    }
    refined
}

/// Bisects until no cell touches one that is two levels finer.
fn balance(cells: &mut Vec<Cell>) {
    loop {
        let mut finest: HashMap<Key, u8> = HashMap::new();
        for cell in cells.iter() {
            for c in 0..8 {
                let at = std::array::from_fn(|d| f64::from(c >> d & 1));
                let level = finest.entry(key(cell.logical(at))).or_default();
                *level = (*level).max(cell.level);
            }
        }
        // A neighbour two levels finer has a corner on the quarter points of the surface.
        let unbalanced = |cell: &Cell| {
            surface(4).any(|p| {
                let at = p.map(|i| 0.25 * i as f64);
                finest.get(&key(cell.logical(at))).is_some_and(|&l| l > cell.level + 1)
            })
        };
        let before = cells.len();
        *cells = refine(std::mem::take(cells), unbalanced);
        if cells.len() == before {
            return;
        }
    }
}

/// Points of the grid with `n` intervals per direction that lie on the cube's surface.
pub fn surface(n: usize) -> impl Iterator<Item = [usize; 3]> {
    let m = n + 1;
    (0..m * m * m)
        .map(move |k| [k % m, k / m % m, k / (m * m)])
        .filter(move |p| p.iter().any(|&i| i == 0 || i == n))
}
