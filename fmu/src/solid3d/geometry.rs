//! Isoparametric reference geometry at the integration points, computed once per mesh.

use super::Tensor;
use super::mesh::Mesh;
use super::point::{determinant, inverse};
use super::shape::{CORNERS, GAUSS_POINTS, NODES, POINTS, Shape, VOLUMETRIC_POINTS};
use crate::element::shape::RULE;

/// What the kernel needs to know of the reference configuration at one point.
#[derive(Debug, Clone, Copy)]
pub struct PointGeometry {
    /// `d xi / d X` (1/m).
    pub inverse: Tensor,
    /// Reference volume (m^3), or area (m^2) on a face.
    pub measure: f64,
}

impl PointGeometry {
    /// Geometry at a point of the cell with these node positions, and `d X / d xi`.
    fn at(nodes: &[[f64; 3]; NODES], shape: &Shape) -> (Self, Tensor) {
        let mut jacobian = [[0.0; 3]; 3];
        for (x, dn) in nodes.iter().zip(&shape.dn) {
            for i in 0..3 {
                for e in 0..3 {
                    jacobian[i][e] += x[i] * dn[e];
                }
            }
        }
        let det = determinant(&jacobian);
        (Self { inverse: inverse(&jacobian, det), measure: shape.weight * det }, jacobian)
    }
}

/// Geometry of the integration points of one cell.
#[derive(Debug, Clone, Copy)]
pub struct CellGeometry {
    /// The 3 x 3 x 3 Gauss points.
    pub points: [PointGeometry; POINTS],
    /// The 2 x 2 x 2 Gauss points of the volumetric law.
    pub volumetric: [PointGeometry; CORNERS],
}

/// A quadrature point on the punch's face.
#[derive(Debug, Clone, Copy)]
pub struct FacePoint {
    /// Cell.
    pub cell: usize,
    /// Shape functions there.
    pub shape: Shape,
    /// Geometry with the face's measure (m^2).
    pub geometry: PointGeometry,
}

/// Geometry of all quadrature points of a mesh.
#[derive(Debug, Clone)]
pub struct Geometry {
    /// Integration points of every cell.
    pub cells: Vec<CellGeometry>,
    /// Quadrature points of the punch's face.
    pub face: Vec<FacePoint>,
}

impl Geometry {
    /// Evaluates the geometry of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let positions = |cell: usize| mesh.cells[cell].map(|n| mesh.nodes[n as usize]);
        let cells = (0..mesh.cells.len()).map(|cell| {
            let nodes = positions(cell);
            CellGeometry {
                points: std::array::from_fn(|k| PointGeometry::at(&nodes, &GAUSS_POINTS[k]).0),
                volumetric: std::array::from_fn(|k| PointGeometry::at(&nodes, &VOLUMETRIC_POINTS[k]).0),
            }
        });
        let cells = cells.collect();
        let face = mesh.punch_cells().flat_map(|cell| face_points(cell, &positions(cell))).collect();
        Self { cells, face }
    }
}

/// The 3 x 3 Gauss points of a cell's upper face.
fn face_points(cell: usize, nodes: &[[f64; 3]; NODES]) -> [FacePoint; 9] {
    std::array::from_fn(|k| {
        let ((x, wx), (y, wy)) = (RULE[k % 3], RULE[k / 3]);
        let shape = Shape::at([x, y, 1.0], wx * wy);
        let (mut geometry, jacobian) = PointGeometry::at(nodes, &shape);
        // The face is horizontal.
        let area = jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0];
        geometry.measure = wx * wy * area;
        FacePoint { cell, shape, geometry }
    })
}

#[cfg(test)]
mod tests {
    use super::super::forest::COARSE;
    use super::*;
    use crate::mesh::parameters::GeometryParameters;
    use std::f64::consts::PI;

    /// Goal: isoparametric cells follow the circles. Reference: quarter cylinder, quarter disc.
    /// Tolerance: 1e-4 of the punch's area, 1e-3 of the volume on the coarse mesh.
    #[test]
    fn volume_and_punch_area_are_nearly_exact() {
        let tight = GeometryParameters { sample_radius: 2.4e-3, sample_height: 0.7e-3, ..Default::default() };
        for g in [GeometryParameters::default(), tight] {
            let geometry = Geometry::new(&Mesh::new(&g, COARSE));
            let volume = 0.25 * PI * g.sample_radius.powi(2) * g.sample_height;
            let sum = |measures: &mut dyn Iterator<Item = f64>| measures.sum::<f64>();
            let by_gauss = sum(&mut geometry.cells.iter().flat_map(|c| c.points).map(|p| p.measure));
            let by_volumetric = sum(&mut geometry.cells.iter().flat_map(|c| c.volumetric).map(|p| p.measure));
            approx::assert_relative_eq!(by_gauss, volume, max_relative = 1e-3);
            approx::assert_relative_eq!(by_volumetric, volume, max_relative = 1e-3);
            let area = sum(&mut geometry.face.iter().map(|p| p.geometry.measure));
            approx::assert_relative_eq!(area, 0.25 * PI * g.punch_radius.powi(2), max_relative = 1e-4);
            assert!(geometry.cells.iter().flat_map(|c| c.points).all(|p| p.measure > 0.0));
        }
    }
}
