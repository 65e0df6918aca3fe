//! From cells to the global sparse system: hanging nodes and rotated unknowns are condensed cell by cell.
//!
//! With `x_cell = T x`, a cell adds `T^T R` to the residual and `T^T K T` to the tangent.

use super::IDENTITY;
use super::geometry::Geometry;
use super::kernel::{self, CellSystem, PointState};
use super::mesh::Mesh;
use super::point::SolidMaterial;
use super::shape::{CORNER_NODES, NODES, POINTS, UNKNOWNS};
use crate::element::{History, Stage};
use crate::solver::pattern::CscPattern;

/// History of the undeformed state of a mesh of hexahedra.
pub fn undeformed(cells: usize, branches: usize) -> History {
    History::undeformed(cells * POINTS, branches, &IDENTITY)
}

/// History of one cell.
#[inline]
pub fn cell_history(history: &History, cell: usize, branches: usize) -> PointState<'_> {
    let first = cell * POINTS;
    PointState {
        jacobian: &history.jacobian[first..first + POINTS],
        cv_inverse: &history.tensors()[first * branches..(first + POINTS) * branches],
    }
}

/// One cell's unknowns and the map `T` to its own displacements and pressures.
#[derive(Debug, Clone)]
struct CellMap {
    /// Global unknowns.
    unknowns: Vec<u32>,
    /// Rows of T: place in `unknowns` and weight. Empty when T is the identity.
    terms: Vec<Vec<(u32, f64)>>,
    /// First position in [`AssemblyMap::positions`].
    first: usize,
}

/// Where every entry of every cell goes, computed once per mesh.
#[derive(Debug, Clone)]
pub struct AssemblyMap {
    cells: Vec<CellMap>,
    /// Positions in the CSC values, by columns of each cell.
    positions: Vec<u32>,
    /// Pattern of the matrix, structurally symmetric.
    pub pattern: CscPattern,
}

impl AssemblyMap {
    /// Builds pattern and positions.
    pub fn new(mesh: &Mesh) -> Self {
        let mut cells: Vec<CellMap> = mesh.cells.iter().map(|nodes| cell_map(mesh, nodes)).collect();
        let pattern = pattern(mesh.unknowns(), &cells);
        let total = cells.iter().map(|c| c.unknowns.len().pow(2)).sum();
        let mut positions = Vec::with_capacity(total);
        for cell in &mut cells {
            cell.first = positions.len();
            for &column in &cell.unknowns {
                positions.extend(cell.unknowns.iter().map(|&row| pattern.position(row, column)));
            }
        }
        Self { cells, positions, pattern }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.cells.len()
    }

    /// Global unknowns of a cell.
    pub fn unknowns(&self, cell: usize) -> &[u32] {
        &self.cells[cell].unknowns
    }

    /// Displacements and pressures of one cell, hanging nodes included.
    #[inline]
    pub fn gather(&self, cell: usize, x: &[f64]) -> [f64; UNKNOWNS] {
        let CellMap { unknowns, terms, .. } = &self.cells[cell];
        if terms.is_empty() {
            return std::array::from_fn(|i| x[unknowns[i] as usize]);
        }
        std::array::from_fn(|i| terms[i].iter().map(|&(m, w)| w * x[unknowns[m as usize] as usize]).sum())
    }

    fn scatter(
        &self,
        cell: usize,
        system: &CellSystem,
        condensed: &mut Condensed,
        residual: &mut [f64],
        values: Option<&mut [f64]>,
    ) {
        let CellMap { unknowns, terms, first } = &self.cells[cell];
        let n = unknowns.len();
        let (own_residual, own_tangent): (&[f64], &[f64]) = if terms.is_empty() {
            (&system.residual, system.tangent.as_flattened())
        } else {
            condensed.condense(system, terms, n);
            (&condensed.residual, &condensed.tangent)
        };
        for (&u, r) in unknowns.iter().zip(own_residual) {
            residual[u as usize] += r;
        }
        let Some(values) = values else { return };
        for (&target, &value) in self.positions[*first..first + n * n].iter().zip(own_tangent) {
            values[target as usize] += value;
        }
    }
}

/// `T^T R` and `T^T K T` of one cell.
#[derive(Debug, Default)]
struct Condensed {
    residual: Vec<f64>,
    /// By columns.
    tangent: Vec<f64>,
    column: Vec<f64>,
}

impl Condensed {
    fn condense(&mut self, system: &CellSystem, terms: &[Vec<(u32, f64)>], n: usize) {
        self.residual.clear();
        self.residual.resize(n, 0.0);
        self.tangent.clear();
        self.tangent.resize(n * n, 0.0);
        for (i, row) in terms.iter().enumerate() {
            // T^T times column i of K ...
            self.column.clear();
            self.column.resize(n, 0.0);
            for (value, terms) in system.tangent[i].iter().zip(terms) {
                for &(m, w) in terms {
                    self.column[m as usize] += w * value;
                }
            }
            // ... goes to the columns that x_i depends on.
            for &(m, w) in row {
                self.residual[m as usize] += w * system.residual[i];
                let target = &mut self.tangent[m as usize * n..][..n];
                for (t, c) in target.iter_mut().zip(&self.column) {
                    *t += w * c;
                }
            }
        }
    }
}

/// Expresses a cell's displacements and pressures by global unknowns.
fn cell_map(mesh: &Mesh, nodes: &[u32; NODES]) -> CellMap {
    let mut global: Vec<Vec<(u32, f64)>> = vec![Vec::new(); UNKNOWNS];
    for (a, &node) in nodes.iter().enumerate() {
        for &(master, weight) in &mesh.displacement_terms[node as usize] {
            // Terms name free nodes only.
            let Some(first) = mesh.displacement(master) else { continue };
            let first = first as u32;
            match mesh.side_normal(master) {
                None => (0..3).for_each(|i| global[3 * a + i].push((first + i as u32, weight))),
                Some((cos, sin)) => {
                    global[3 * a].extend([(first, weight * cos), (first + 1, -weight * sin)]);
                    global[3 * a + 1].extend([(first, weight * sin), (first + 1, weight * cos)]);
                    global[3 * a + 2].push((first + 2, weight));
                }
            }
        }
    }
    for (m, local) in CORNER_NODES.into_iter().enumerate() {
        for &(master, weight) in &mesh.pressure_terms[nodes[local] as usize] {
            let Some(unknown) = mesh.pressure(master) else { continue };
            global[3 * NODES + m].push((unknown as u32, weight));
        }
    }
    let plain = global.iter().all(|t| matches!(t[..], [(_, w)] if w == 1.0));
    if plain {
        return CellMap { unknowns: global.iter().map(|t| t[0].0).collect(), terms: Vec::new(), first: 0 };
    }
    let mut unknowns: Vec<u32> = global.iter().flatten().map(|t| t.0).collect();
    unknowns.sort_unstable();
    unknowns.dedup();
    for (place, _) in global.iter_mut().flatten() {
        *place = unknowns.partition_point(|u| u < place) as u32;
    }
    CellMap { unknowns, terms: global, first: 0 }
}

/// The union of the cells' dense blocks.
fn pattern(unknowns: usize, cells: &[CellMap]) -> CscPattern {
    let mut cells_of: Vec<Vec<u32>> = vec![Vec::new(); unknowns];
    for (c, cell) in cells.iter().enumerate() {
        cell.unknowns.iter().for_each(|&u| cells_of[u as usize].push(c as u32));
    }
    let mut stamp = vec![u32::MAX; unknowns];
    let mut column_pointers = vec![0];
    let mut rows: Vec<u32> = Vec::new();
    for (column, of) in cells_of.iter().enumerate() {
        let first = rows.len();
        for &cell in of {
            for &row in &cells[cell as usize].unknowns {
                if stamp[row as usize] != column as u32 {
                    stamp[row as usize] = column as u32;
                    rows.push(row);
                }
            }
        }
        rows[first..].sort_unstable();
        column_pointers.push(rows.len() as u32);
    }
    rows.shrink_to_fit();
    CscPattern { column_pointers, rows }
}

/// A material on a mesh of hexahedra.
#[derive(Debug, Clone, Copy)]
pub struct SolidBody<'a> {
    /// Integration points.
    pub geometry: &'a Geometry,
    /// Unknowns and pattern.
    pub map: &'a AssemblyMap,
    /// Constitutive laws.
    pub material: &'a SolidMaterial,
}

impl SolidBody<'_> {
    /// Residual of the whole mesh, and its tangent where it is asked for, in SI units and without boundary conditions.
    ///
    /// # Errors
    /// The first cell that is turned inside out, compacted or too strained.
    pub fn assemble(
        &self,
        stage: Stage<'_>,
        residual: &mut [f64],
        mut values: Option<&mut [f64]>,
    ) -> Result<(), usize> {
        residual.fill(0.0);
        if let Some(values) = values.as_deref_mut() {
            values.fill(0.0);
        }
        let mut system = Box::<CellSystem>::default();
        let mut condensed = Condensed::default();
        let branches = self.material.branches();
        for (cell, points) in self.geometry.cells.iter().enumerate() {
            let x_c = self.map.gather(cell, stage.x);
            let history = cell_history(stage.old, cell, branches);
            kernel::evaluate(points, self.material, &x_c, history, stage.dt, &mut system).ok_or(cell)?;
            self.map.scatter(cell, &system, &mut condensed, residual, values.as_deref_mut());
        }
        Ok(())
    }
}
