//! Structured axisymmetric Taylor–Hood mesh, graded towards the punch's edge and the surface.

mod grading;
mod presets;

use crate::parameters::{GeometryParameters, MeshParameters};
use presets::resolve;

/// Nodes per element: Q2 displacement.
pub const NODES: usize = 9;
/// Corner nodes per element: Q1 pressure.
pub const CORNERS: usize = 4;
/// Unknowns per element, displacements first.
pub const UNKNOWNS: usize = 2 * NODES + CORNERS;

/// One quadrilateral of the (R, Z) half-plane, an axis-parallel rectangle.
///
/// Local nodes run row by row from the lower left: `3 j + i`, `i` along R, `j` along Z.
#[derive(Debug, Clone, Copy)]
pub struct Element {
    /// Global nodes.
    pub nodes: [u32; NODES],
    /// Lower left corner (R, Z) [m].
    pub origin: [f64; 2],
    /// Size along R and Z [m].
    pub size: [f64; 2],
}

/// Mesh and numbering of the unknowns.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Elements, row by row from the bottom.
    pub elements: Vec<Element>,
    /// Node coordinates (R, Z) [m].
    pub nodes: Vec<[f64; 2]>,
    /// First displacement unknown of every node (`u_r`; `u_z` follows).
    displacement: Vec<u32>,
    /// Pressure unknown of every corner node.
    pressure: Vec<Option<u32>>,
    unknowns: usize,
    extent: [f64; 2],
    punch_radius: f64,
}

impl Mesh {
    /// The mesh of a geometry.
    pub fn new(geometry: &GeometryParameters, mesh: &MeshParameters) -> Self {
        let grading = resolve(mesh, geometry.punch_radius);
        let (a, b, h) = (geometry.punch_radius, geometry.sample_radius, geometry.sample_height);
        let mut radii: Vec<f64> =
            grading::layers(a, &grading).into_iter().map(|r| a - r).rev().chain([a]).collect();
        radii.extend(grading::layers(b - a, &grading).into_iter().map(|r| a + r));
        radii[0] = 0.0;
        let mut heights: Vec<f64> = grading::layers(h, &grading).into_iter().map(|z| h - z).rev().collect();
        heights[0] = 0.0;
        heights.push(h);
        Self::tensor(&radii, &heights, a)
    }

    /// The mesh of given grid lines (ascending, `radii[0] = 0`); `punch_radius` is one of the radii.
    pub fn tensor(radii: &[f64], heights: &[f64], punch_radius: f64) -> Self {
        let (nr, nz) = (radii.len() - 1, heights.len() - 1);
        let (columns, rows) = (2 * nr + 1, 2 * nz + 1);
        let (r, z) = (with_midpoints(radii), with_midpoints(heights));
        let (mut nodes, mut displacement, mut pressure) = (Vec::new(), Vec::new(), Vec::new());
        let mut unknowns = 0_u32;
        for j in 0..rows {
            for i in 0..columns {
                nodes.push([r[i], z[j]]);
                displacement.push(unknowns);
                unknowns += 2;
                let corner = i % 2 == 0 && j % 2 == 0;
                pressure.push(corner.then_some(unknowns));
                unknowns += u32::from(corner);
            }
        }
        let mut elements = Vec::with_capacity(nr * nz);
        for j in 0..nz {
            for i in 0..nr {
                let node = |k: usize| ((2 * j + k / 3) * columns + 2 * i + k % 3) as u32;
                elements.push(Element {
                    nodes: std::array::from_fn(node),
                    origin: [radii[i], heights[j]],
                    size: [radii[i + 1] - radii[i], heights[j + 1] - heights[j]],
                });
            }
        }
        Self {
            elements,
            nodes,
            displacement,
            pressure,
            unknowns: unknowns as usize,
            extent: [radii[nr], heights[nz]],
            punch_radius,
        }
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
        for (k, local) in [0, 2, 6, 8].into_iter().enumerate() {
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
        self.select(|x| x[0] == 0.0)
    }

    /// Nodes on the bottom.
    pub fn bottom(&self) -> impl Iterator<Item = u32> + '_ {
        self.select(|x| x[1] == 0.0)
    }

    /// Nodes on the lateral surface.
    pub fn side(&self) -> impl Iterator<Item = u32> + '_ {
        self.select(|x| x[0] == self.extent[0])
    }

    /// Nodes under the punch, its edge included.
    pub fn punch(&self) -> impl Iterator<Item = u32> + '_ {
        self.select(|x| x[1] == self.extent[1] && x[0] <= self.punch_radius)
    }

    /// Nodes on the free part of the top, the punch's edge included.
    pub fn free_top(&self) -> impl Iterator<Item = u32> + '_ {
        self.select(|x| x[1] == self.extent[1] && x[0] >= self.punch_radius)
    }

    /// Elements under the punch.
    pub fn punch_elements(&self) -> impl Iterator<Item = usize> + '_ {
        let (top, edge) = (self.extent[1], self.punch_radius);
        self.elements.iter().enumerate().filter_map(move |(i, e)| {
            let at_top = (e.origin[1] + e.size[1] - top).abs() < 1e-9 * top;
            (at_top && e.origin[0] + 0.5 * e.size[0] < edge).then_some(i)
        })
    }

    fn select<'a>(&'a self, keep: impl Fn(&[f64; 2]) -> bool + 'a) -> impl Iterator<Item = u32> + 'a {
        self.nodes.iter().enumerate().filter(move |(_, x)| keep(x)).map(|(i, _)| i as u32)
    }
}

fn with_midpoints(lines: &[f64]) -> Vec<f64> {
    let mut points = vec![lines[0]];
    for pair in lines.windows(2) {
        points.extend([0.5 * (pair[0] + pair[1]), pair[1]]);
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covers_the_sample_and_has_the_edge_as_a_grid_line() {
        let geometry = GeometryParameters::default();
        let mesh = Mesh::new(&geometry, &MeshParameters::default());
        let area: f64 = mesh.elements.iter().map(|e| e.size[0] * e.size[1]).sum();
        approx::assert_relative_eq!(area, 1e-4, max_relative = 1e-12);
        let punch: Vec<u32> = mesh.punch().collect();
        let edge = mesh.nodes[*punch.last().unwrap() as usize];
        assert_eq!(edge, [geometry.punch_radius, geometry.sample_height]);
        assert_eq!(mesh.free_top().next(), punch.last().copied());
    }

    #[test]
    fn every_unknown_belongs_to_an_element() {
        let mesh = Mesh::new(&GeometryParameters::default(), &MeshParameters::default());
        let mut seen = vec![false; mesh.unknowns()];
        for e in &mesh.elements {
            mesh.element_unknowns(e).iter().for_each(|&u| seen[u as usize] = true);
        }
        assert!(seen.into_iter().all(|s| s));
    }
}
