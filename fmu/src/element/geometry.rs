//! Reference geometry at a point of an element, computed once per mesh.

use super::shape::{GAUSS_POINTS, POINTS, Shape, VOLUMETRIC_POINTS};
use crate::mesh::{CORNERS, Element, ElementFace, Mesh, NODES};
use crate::number::{PACKET, Packet, closure, each_of};
use std::f64::consts::TAU;

/// What the kernel needs to know of the reference configuration at one point.
#[derive(Debug, Clone, Copy)]
pub struct PointGeometry<T = f64> {
    /// Displacement functions.
    pub n: [T; NODES],
    /// Their gradients with respect to (R, Z) (1/m).
    pub gradient: [[T; 2]; NODES],
    /// Pressure functions.
    pub p: [T; CORNERS],
    /// Their gradients (1/m).
    pub pressure_gradient: [[T; 2]; CORNERS],
    /// R (m).
    pub radius: T,
    /// `2 pi R dA` (m^3), or `2 pi R dL` (m^2) on a face.
    pub measure: T,
}

impl<G> PointGeometry<G> {
    /// The same in numbers of another kind.
    #[inline(always)]
    pub fn load<T: Copy>(&self, load: impl Fn(&G) -> T + Copy) -> PointGeometry<T> {
        let pair = closure!(|pair: &[G; 2]| each_of(pair, load));
        PointGeometry {
            n: each_of(&self.n, load),
            gradient: each_of(&self.gradient, pair),
            p: each_of(&self.p, load),
            pressure_gradient: each_of(&self.pressure_gradient, pair),
            radius: load(&self.radius),
            measure: load(&self.measure),
        }
    }
}

impl PointGeometry<Packet> {
    fn packed(of: [&PointGeometry; PACKET]) -> Self {
        let each = |value: &dyn Fn(&PointGeometry) -> f64| Packet(of.map(value));
        Self {
            n: std::array::from_fn(|a| each(&|g| g.n[a])),
            gradient: std::array::from_fn(|a| std::array::from_fn(|d| each(&|g| g.gradient[a][d]))),
            p: std::array::from_fn(|m| each(&|g| g.p[m])),
            pressure_gradient: std::array::from_fn(|m| {
                std::array::from_fn(|d| each(&|g| g.pressure_gradient[m][d]))
            }),
            radius: each(&|g| g.radius),
            measure: each(&|g| g.measure),
        }
    }
}

impl PointGeometry {
    /// Geometry at a point of the reference square, and the Jacobian matrix of the map `d(R, Z) / d(xi, eta)`.
    fn at(element: &Element, shape: &Shape) -> (Self, [[f64; 2]; 2]) {
        // Straight sides: the corners alone map the reference square.
        let (mut x, mut jacobian) = ([0.0; 2], [[0.0; 2]; 2]);
        for (m, corner) in element.corners.iter().enumerate() {
            for d in 0..2 {
                x[d] += shape.p[m] * corner[d];
                for e in 0..2 {
                    jacobian[d][e] += shape.dp[m][e] * corner[d];
                }
            }
        }
        let determinant = jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0];
        let pull = |g: [f64; 2]| {
            [
                (g[0] * jacobian[1][1] - g[1] * jacobian[1][0]) / determinant,
                (g[1] * jacobian[0][0] - g[0] * jacobian[0][1]) / determinant,
            ]
        };
        let geometry = Self {
            n: shape.n,
            gradient: shape.dn.map(pull),
            p: shape.p,
            pressure_gradient: shape.dp.map(pull),
            radius: x[0],
            measure: TAU * x[0] * shape.weight * determinant,
        };
        (geometry, jacobian)
    }
}

/// A quadrature point on the punch's face.
#[derive(Debug, Clone, Copy)]
pub struct FacePoint {
    /// Element.
    pub element: usize,
    /// Place in the reference square.
    pub xi: [f64; 2],
    /// Geometry with the face's measure.
    pub geometry: PointGeometry,
    /// Outward normal of the undeformed face (R, Z).
    pub normal: [f64; 2],
    /// Z (m).
    pub height: f64,
}

impl FacePoint {
    /// Whether it lies under the punch, not on a side that may fold over.
    pub fn is_under_punch(&self) -> bool {
        self.normal[1] > 0.5
    }
}

/// Geometry of the integration points of one element.
#[derive(Debug, Clone, Copy)]
pub struct ElementGeometry<T = f64> {
    /// The 3 x 3 Gauss points.
    pub points: [PointGeometry<T>; POINTS],
    /// The 2 x 2 Gauss points of the volumetric law.
    pub volumetric: [PointGeometry<T>; CORNERS],
}

impl ElementGeometry<Packet> {
    /// Consecutive elements, at most [`PACKET`]; copies of the last without any volume fill the packet up.
    fn packed(elements: &[ElementGeometry]) -> Self {
        let lanes: [ElementGeometry; PACKET] = std::array::from_fn(|lane| {
            let mut copy = elements[lane.min(elements.len() - 1)];
            if lane >= elements.len() {
                copy.points.iter_mut().chain(&mut copy.volumetric).for_each(|point| point.measure = 0.0);
            }
            copy
        });
        Self {
            points: std::array::from_fn(|k| PointGeometry::packed(lanes.each_ref().map(|e| &e.points[k]))),
            volumetric: std::array::from_fn(|k| {
                PointGeometry::packed(lanes.each_ref().map(|e| &e.volumetric[k]))
            }),
        }
    }
}

/// Geometry of all quadrature points of a mesh.
#[derive(Debug, Clone)]
pub struct Geometry {
    /// Integration points of every element.
    pub elements: Vec<ElementGeometry>,
    /// The same of [`PACKET`] elements at a time.
    pub packets: Vec<ElementGeometry<Packet>>,
    /// Quadrature points of the surface that the punch can touch: of its face, then of a side that may fold over.
    pub face: Vec<FacePoint>,
}

impl Geometry {
    /// Evaluates the geometry of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let at = |e: &Element, s: &Shape| PointGeometry::at(e, s).0;
        let elements = mesh.elements.iter().map(|e| ElementGeometry {
            points: std::array::from_fn(|k| at(e, &GAUSS_POINTS[k])),
            volumetric: std::array::from_fn(|k| at(e, &VOLUMETRIC_POINTS[k])),
        });
        let elements: Vec<_> = elements.collect();
        let packets = elements.chunks(PACKET).map(ElementGeometry::packed).collect();
        let under = mesh.punch_faces().into_iter().map(|f| (f, [0.0, 1.0]));
        let beside = mesh.folding_faces().into_iter().map(|f| (f, [1.0, 0.0]));
        let face = under.chain(beside).flat_map(|(f, normal)| face_points(mesh, &f, normal)).collect();
        Self { elements, packets, face }
    }
}

fn face_points(mesh: &Mesh, face: &ElementFace, normal: [f64; 2]) -> [FacePoint; 3] {
    super::shape::RULE.map(|(s, weight)| {
        let xi = std::array::from_fn(|d| 0.5 * ((1.0 - s) * face.start[d] + (1.0 + s) * face.end[d]));
        let (mut geometry, jacobian) = PointGeometry::at(&mesh.elements[face.element], &Shape::at(xi, 1.0));
        let along: [f64; 2] = std::array::from_fn(|d| 0.5 * (face.end[d] - face.start[d]));
        let tangent: [f64; 2] =
            std::array::from_fn(|d| jacobian[d][0] * along[0] + jacobian[d][1] * along[1]);
        geometry.measure = TAU * geometry.radius * weight * tangent[0].hypot(tangent[1]);
        let corners = mesh.elements[face.element].corners;
        let height = geometry.p.iter().zip(corners).map(|(p, corner)| p * corner[1]).sum();
        FacePoint { element: face.element, xi, geometry, normal, height }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::parameters::{GeometryParameters, MeshParameters};
    use std::f64::consts::PI;

    #[test]
    fn volume_and_punch_area_are_exact() {
        let g = GeometryParameters::default();
        let geometry = Geometry::new(&Mesh::new(&g, &MeshParameters::default()));
        let volume: f64 = geometry.elements.iter().flat_map(|e| e.points).map(|p| p.measure).sum();
        approx::assert_relative_eq!(
            volume,
            PI * g.sample_radius.powi(2) * g.sample_height,
            max_relative = 1e-12
        );
        let area: f64 = geometry.face.iter().map(|p| p.geometry.measure).sum();
        approx::assert_relative_eq!(area, PI * g.punch_radius.powi(2), max_relative = 1e-9);
    }

    #[test]
    fn gradients_reproduce_linear_fields() {
        let mesh = Mesh::new(&GeometryParameters::default(), &MeshParameters::default());
        let geometry = Geometry::new(&mesh);
        for (element, points) in mesh.elements.iter().zip(&geometry.elements) {
            for point in points.points.iter().chain(&points.volumetric) {
                let mut slope = [0.0; 2];
                for (node, g) in element.nodes.iter().zip(&point.gradient) {
                    let x = mesh.nodes[*node as usize];
                    (0..2).for_each(|d| slope[d] += (3.0 * x[0] - 2.0 * x[1]) * g[d]);
                }
                approx::assert_relative_eq!(slope[0], 3.0, epsilon = 1e-8);
                approx::assert_relative_eq!(slope[1], -2.0, epsilon = 1e-8);
            }
        }
    }
}
