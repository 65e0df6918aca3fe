//! Axisymmetric Taylor–Hood mesh: square rings around the punch's edge inside a rectangular grid.
//!
//! The edge of a bonded punch is singular and, at finite strain, the material turns around it by more
//! than a right angle. Rings of elements that shrink geometrically towards the edge resolve both with
//! few unknowns: every element of a ring takes only a slice of the angle.

mod blocks;
mod grading;
pub mod parameters;
pub(crate) mod presets;

use crate::mesh::parameters::{GeometryParameters, MeshParameters};
use blocks::Quad;
use std::collections::HashMap;

/// Nodes per element: Q2 displacement.
pub const NODES: usize = 9;
/// Corner nodes per element: Q1 pressure.
pub const CORNERS: usize = 4;
/// Unknowns per element, displacements first.
pub const UNKNOWNS: usize = 2 * NODES + CORNERS;

/// Most elements of a mesh: some half a million unknowns, whose factors take a gigabyte.
const MOST_ELEMENTS: usize = 50_000;

/// Local numbers of the corner nodes.
pub const CORNER_NODES: [usize; CORNERS] = [0, 2, 6, 8];

/// One straight-sided quadrilateral of the (R, Z) half-plane.
///
/// Local nodes run row by row from the lower left of the reference square: `3 j + i`. At the punch's
/// edge a side is collapsed to a point: three local nodes are then one.
#[derive(Debug, Clone, Copy)]
pub struct Element {
    /// Global nodes.
    pub nodes: [u32; NODES],
    /// Corners (R, Z) (m), lower left, lower right, upper left, upper right.
    pub corners: [[f64; 2]; CORNERS],
}

/// A side of an element on the punch's face: the local coordinates of its two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementFace {
    /// The element.
    pub element: usize,
    /// Reference coordinates of the end nearer to the axis.
    pub start: [f64; 2],
    /// Reference coordinates of the other end.
    pub end: [f64; 2],
}

/// Mesh and numbering of the unknowns.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Elements.
    pub elements: Vec<Element>,
    /// Node coordinates (R, Z) (m).
    pub nodes: Vec<[f64; 2]>,
    /// Unknown `u_r` of every node (`u_z` follows).
    displacement: Vec<u32>,
    /// Pressure unknown of every corner node.
    pressure: Vec<Option<u32>>,
    unknowns: usize,
    extent: [f64; 2],
    punch_radius: f64,
}

impl Mesh {
    /// The mesh of a geometry under a flat punch.
    pub fn new(geometry: &GeometryParameters, mesh: &MeshParameters) -> Self {
        Self::under(None, geometry, mesh)
    }

    /// The mesh of a geometry under an indenter; the edge of its contact can run from `contact_edge` (m) on, or is that of
    /// the punch.
    pub fn under(contact_edge: Option<f64>, geometry: &GeometryParameters, mesh: &MeshParameters) -> Self {
        let quads: Vec<Quad> = quads(contact_edge, geometry, mesh).collect();
        let platen = geometry.is_platen() && contact_edge.is_none();
        Self::from_quads(&quads, if platen { f64::INFINITY } else { geometry.punch_radius })
    }

    /// Whether it would have more elements than this program makes; told without making them.
    pub fn is_too_large(
        contact_edge: Option<f64>,
        geometry: &GeometryParameters,
        mesh: &MeshParameters,
    ) -> bool {
        quads(contact_edge, geometry, mesh).nth(MOST_ELEMENTS).is_some()
    }

    /// The rectangular mesh of given grid lines (ascending from 0); `punch_radius` is one of the radii.
    pub fn tensor(radii: &[f64], heights: &[f64], punch_radius: f64) -> Self {
        let quads: Vec<Quad> = blocks::tensor(radii.to_vec(), heights.to_vec()).collect();
        Self::from_quads(&quads, punch_radius)
    }

    fn from_quads(quads: &[Quad], punch_radius: f64) -> Self {
        let corners = || quads.iter().flatten();
        let extent: [f64; 2] = std::array::from_fn(|d| corners().fold(0.0_f64, |m, c| m.max(c[d])));
        let mut nodes: Vec<[f64; 2]> = Vec::new();
        let mut known: HashMap<[i64; 2], u32> = HashMap::new();
        let mut node_at = |x: [f64; 2]| {
            // Coordinates of one node differ by rounding only between elements.
            let key = std::array::from_fn(|d| (x[d] / extent[d] * 1e10).round() as i64);
            *known.entry(key).or_insert_with(|| {
                nodes.push(x);
                (nodes.len() - 1) as u32
            })
        };
        let mut elements = Vec::with_capacity(quads.len());
        for corners in quads {
            let at = |k: usize| {
                let (i, j) = (0.5 * (k % 3) as f64, 0.5 * (k / 3) as f64);
                let weights = [(1.0 - i) * (1.0 - j), i * (1.0 - j), (1.0 - i) * j, i * j];
                std::array::from_fn(|d| (0..CORNERS).map(|c| weights[c] * corners[c][d]).sum())
            };
            elements.push(Element { nodes: std::array::from_fn(|k| node_at(at(k))), corners: *corners });
        }
        let mut is_corner = vec![false; nodes.len()];
        for element in &elements {
            CORNER_NODES.iter().for_each(|&k| is_corner[element.nodes[k] as usize] = true);
        }
        let mut unknowns = 0_u32;
        let (mut displacement, mut pressure) = (Vec::new(), Vec::new());
        for corner in is_corner {
            displacement.push(unknowns);
            unknowns += 2;
            pressure.push(corner.then_some(unknowns));
            unknowns += u32::from(corner);
        }
        Self { elements, nodes, displacement, pressure, unknowns: unknowns as usize, extent, punch_radius }
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Unknown `u_r` of a node; `u_z` is the next one.
    pub fn displacement(&self, node: u32) -> usize {
        self.displacement[node as usize] as usize
    }

    /// Pressure unknown of a node, if it is a corner.
    pub fn pressure(&self, node: u32) -> Option<usize> {
        self.pressure[node as usize].map(|p| p as usize)
    }

    /// Unknowns of an element: `u_r, u_z` node by node, then the four pressures.
    pub fn element_unknowns(&self, element: &Element) -> [u32; UNKNOWNS] {
        let mut unknowns = [0; UNKNOWNS];
        for (k, &node) in element.nodes.iter().enumerate() {
            let first = self.displacement[node as usize];
            (unknowns[2 * k], unknowns[2 * k + 1]) = (first, first + 1);
        }
        for (k, local) in CORNER_NODES.into_iter().enumerate() {
            let node = element.nodes[local] as usize;
            unknowns[2 * NODES + k] = self.pressure[node].unwrap_or(u32::MAX);
        }
        unknowns
    }

    /// Whether an unknown is a pressure.
    pub fn pressure_mask(&self) -> Vec<bool> {
        let mut mask = vec![false; self.unknowns];
        self.pressure.iter().flatten().for_each(|&p| mask[p as usize] = true);
        mask
    }

    /// Nodes on the axis.
    pub fn axis(&self) -> impl Iterator<Item = u32> + '_ {
        self.select(|x| x[0] <= self.margin())
    }

    /// Nodes on the bottom.
    pub fn bottom(&self) -> impl Iterator<Item = u32> + '_ {
        self.select(|x| x[1] <= self.margin())
    }

    /// Nodes on the lateral surface.
    pub fn side(&self) -> impl Iterator<Item = u32> + '_ {
        self.select(|x| x[0] >= self.extent[0] - self.margin())
    }

    /// Nodes under the punch, its edge included.
    pub fn punch(&self) -> impl Iterator<Item = u32> + '_ {
        self.select(|x| self.on_top(x) && x[0] <= self.punch_radius + self.margin())
    }

    /// Nodes on the free part of the top, the punch's edge included.
    pub fn free_top(&self) -> impl Iterator<Item = u32> + '_ {
        self.select(|x| self.on_top(x) && x[0] >= self.punch_radius - self.margin())
    }

    /// Nodes of a free side that may fold over and lie down on a plate, from the rim under the platen (which is not
    /// one of them) to the rim on the support; none unless a platen covers the sample.
    pub fn folding_side(&self) -> Vec<u32> {
        if self.punch_radius.is_finite() {
            return Vec::new();
        }
        let height = |n: &u32| self.nodes[*n as usize][1];
        let mut nodes: Vec<u32> = self.side().filter(|&n| !self.on_top(&self.nodes[n as usize])).collect();
        nodes.sort_by(|a, b| height(b).total_cmp(&height(a)));
        nodes
    }

    /// Whether a place on the side is nearer to the platen than to the support.
    pub fn is_upper(&self, height: f64) -> bool {
        height >= 0.5 * self.extent[1]
    }

    /// Height of the sample (m).
    pub fn height(&self) -> f64 {
        self.extent[1]
    }

    /// Sides of elements on the upper half of a side that may fold over.
    pub fn folding_faces(&self) -> Vec<ElementFace> {
        if self.punch_radius.is_finite() {
            return Vec::new();
        }
        let on_side = |x: &[f64; 2]| x[0] >= self.extent[0] - self.margin();
        self.sides(|upper, lower| {
            on_side(upper) && on_side(lower) && self.is_upper(lower[1]) && upper[1] - lower[1] > self.margin()
        })
    }

    /// Element sides under the punch.
    pub fn punch_faces(&self) -> Vec<ElementFace> {
        self.sides(|x, y| {
            let covered = y[0] <= self.punch_radius + self.margin();
            self.on_top(x) && self.on_top(y) && covered && y[0] - x[0] > self.margin()
        })
    }

    /// Element sides between two corners, in the order in which `keep` takes them.
    fn sides(&self, keep: impl Fn(&[f64; 2], &[f64; 2]) -> bool) -> Vec<ElementFace> {
        const CORNER_COORDINATES: [[f64; 2]; CORNERS] = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
        let mut faces = Vec::new();
        for (element, e) in self.elements.iter().enumerate() {
            for (a, b) in [(0, 1), (1, 3), (3, 2), (2, 0)] {
                for (a, b) in [(a, b), (b, a)] {
                    if keep(&e.corners[a], &e.corners[b]) {
                        faces.push(ElementFace {
                            element,
                            start: CORNER_COORDINATES[a],
                            end: CORNER_COORDINATES[b],
                        });
                    }
                }
            }
        }
        faces
    }

    fn margin(&self) -> f64 {
        1e-9 * self.extent[1].min(self.extent[0])
    }

    fn on_top(&self, x: &[f64; 2]) -> bool {
        x[1] >= self.extent[1] - self.margin()
    }

    fn select<'a>(&'a self, keep: impl Fn(&[f64; 2]) -> bool + 'a) -> impl Iterator<Item = u32> + 'a {
        self.nodes.iter().enumerate().filter(move |(_, x)| keep(x)).map(|(i, _)| i as u32)
    }
}

/// The elements' corners.
fn quads(
    contact_edge: Option<f64>,
    geometry: &GeometryParameters,
    mesh: &MeshParameters,
) -> Box<dyn Iterator<Item = Quad>> {
    let radius = geometry.punch_radius;
    if let Some(from) = contact_edge {
        let zone = presets::growing_contact(mesh, radius, radius - from);
        Box::new(blocks::growing_contact(geometry, from, &zone))
    } else if geometry.is_platen() {
        let zone = presets::platen(mesh, geometry.sample_radius);
        Box::new(blocks::platen(geometry, &zone))
    } else {
        Box::new(blocks::indentation(geometry, &presets::resolve(mesh, radius)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::parameters::MeshPreset;

    /// The finest mesh that the ranges of the parameters allow would have some twenty million elements.
    #[test]
    fn an_absurd_mesh_is_refused_before_it_is_made() {
        let geometry = GeometryParameters::default();
        let edge_size = 1e-5 * geometry.reach();
        let absurd = MeshParameters { edge_size, growth: 1.05, ..Default::default() };
        assert!(Mesh::is_too_large(Some(0.0), &geometry, &absurd));
        for preset in [MeshPreset::Coarse, MeshPreset::Standard, MeshPreset::Fine] {
            let mesh = MeshParameters { preset, ..Default::default() };
            assert!(!Mesh::is_too_large(Some(0.0), &geometry, &mesh));
            assert!(!Mesh::is_too_large(None, &geometry, &mesh));
        }
    }

    fn meshes() -> Vec<(GeometryParameters, Mesh)> {
        let wide = GeometryParameters { sample_radius: 20e-3, sample_height: 20e-3, ..Default::default() };
        let tight = GeometryParameters { sample_radius: 2.4e-3, sample_height: 0.7e-3, ..Default::default() };
        let mut all = Vec::new();
        for geometry in [GeometryParameters::default(), wide, tight] {
            for preset in [MeshPreset::Coarse, MeshPreset::Standard, MeshPreset::Fine] {
                let mesh = Mesh::new(&geometry, &MeshParameters { preset, ..Default::default() });
                all.push((geometry.clone(), mesh));
            }
        }
        all
    }

    #[test]
    fn covers_the_sample_exactly_once() {
        for (geometry, mesh) in meshes() {
            let area: f64 = mesh.elements.iter().map(|e| blocks::area(&e.corners)).sum();
            approx::assert_relative_eq!(
                area,
                geometry.sample_radius * geometry.sample_height,
                max_relative = 1e-12
            );
            assert!(mesh.elements.iter().all(|e| blocks::area(&e.corners) > 0.0));
        }
    }

    #[test]
    fn punch_faces_cover_the_punch() {
        for (geometry, mesh) in meshes() {
            let length: f64 = mesh
                .punch_faces()
                .iter()
                .map(|f| {
                    let corner = |x: [f64; 2]| {
                        let k = usize::from(x[0] > 0.0) + 2 * usize::from(x[1] > 0.0);
                        mesh.elements[f.element].corners[k][0]
                    };
                    corner(f.end) - corner(f.start)
                })
                .sum();
            approx::assert_relative_eq!(length, geometry.punch_radius, max_relative = 1e-9);
        }
    }

    /// Conforming: an inner side is shared by two elements, its middle node included.
    #[test]
    fn sides_match() {
        for (_, mesh) in meshes() {
            let mut sides: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
            for e in &mesh.elements {
                for (a, m, b) in [(0, 1, 2), (2, 5, 8), (8, 7, 6), (6, 3, 0)] {
                    let (a, m, b) = (e.nodes[a], e.nodes[m], e.nodes[b]);
                    if a != b {
                        sides.entry([a.min(b), a.max(b)]).or_default().push(m);
                    }
                }
            }
            for (ends, middles) in sides {
                assert!(middles.len() <= 2 && middles.iter().all(|&m| m == middles[0]));
                let [x, y] = ends.map(|n| mesh.nodes[n as usize]);
                let boundary =
                    (0..2).any(|d| x[d] == y[d] && (x[d] < 1e-12 || x[d] > mesh.extent[d] - 1e-12));
                assert_eq!(middles.len(), if boundary { 1 } else { 2 }, "{x:?} {y:?}");
            }
        }
    }
}
