//! Six-node triangles, quadratic displacement and linear pressure (Taylor-Hood), and their integration points.

use crate::mesh::{Mesh, Side, Triangle};

/// An integration point, in the reference configuration.
#[derive(Debug, Clone)]
pub struct GaussPoint {
    /// Quadratic shape functions.
    pub shape: [f64; 6],
    /// Their gradients (1/m).
    pub gradient: [[f64; 2]; 6],
    /// Linear shape functions.
    pub linear: [f64; 3],
    /// Their gradients (1/m).
    pub linear_gradient: [[f64; 2]; 3],
    /// Distance from the axis (m).
    pub radius: f64,
    /// Volume (m^3).
    pub weight: f64,
}

/// Strang and Fix's six points of degree 4: barycentric coordinates and weights.
const TRIANGLE: [([f64; 3], f64); 6] = {
    const A: f64 = 0.445_948_490_915_965;
    const B: f64 = 0.091_576_213_509_771;
    const P: f64 = 0.223_381_589_678_011;
    const Q: f64 = 0.109_951_743_655_322;
    [
        ([1.0 - 2.0 * A, A, A], P),
        ([A, 1.0 - 2.0 * A, A], P),
        ([A, A, 1.0 - 2.0 * A], P),
        ([1.0 - 2.0 * B, B, B], Q),
        ([B, 1.0 - 2.0 * B, B], Q),
        ([B, B, 1.0 - 2.0 * B], Q),
    ]
};

/// Points per triangle.
pub const POINTS: usize = TRIANGLE.len();

/// Integration points of a triangle.
pub fn points(mesh: &Mesh, triangle: &Triangle) -> [GaussPoint; POINTS] {
    let [a, b, c] = [0, 1, 2].map(|i| mesh.nodes[triangle[i]]);
    let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let across = |p: [f64; 2], q: [f64; 2]| [(p[1] - q[1]) / twice, (q[0] - p[0]) / twice];
    let slopes = [across(b, c), across(c, a), across(a, b)];
    TRIANGLE.map(|(l, weight)| {
        let corner = |i: usize| l[i] * (2.0 * l[i] - 1.0);
        let middle = |i: usize, j: usize| 4.0 * l[i] * l[j];
        let corner_slope = |i: usize| slopes[i].map(|s| (4.0 * l[i] - 1.0) * s);
        let middle_slope =
            |i: usize, j: usize| [0, 1].map(|k| 4.0 * (l[i] * slopes[j][k] + l[j] * slopes[i][k]));
        let radius = l[0] * a[0] + l[1] * b[0] + l[2] * c[0];
        GaussPoint {
            shape: [corner(0), corner(1), corner(2), middle(0, 1), middle(1, 2), middle(2, 0)],
            gradient: [
                corner_slope(0),
                corner_slope(1),
                corner_slope(2),
                middle_slope(0, 1),
                middle_slope(1, 2),
                middle_slope(2, 0),
            ],
            linear: l,
            linear_gradient: slopes,
            radius,
            weight: std::f64::consts::TAU * radius * 0.5 * twice * weight,
        }
    })
}

/// An integration point of a side.
#[derive(Debug, Clone, Copy)]
pub struct SidePoint {
    /// Quadratic shape functions of the ends, then of the midpoint.
    pub shape: [f64; 3],
    /// Linear shape functions of the ends.
    pub linear: [f64; 2],
    /// Area (m^2).
    pub weight: f64,
}

/// Three Gauss points of a side.
pub fn side_points(mesh: &Mesh, side: &Side) -> [SidePoint; 3] {
    let (a, b) = (mesh.nodes[side[0]], mesh.nodes[side[1]]);
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let off = 0.6f64.sqrt();
    [(-off, 5.0 / 18.0), (0.0, 4.0 / 9.0), (off, 5.0 / 18.0)].map(|(x, weight)| {
        let linear = [0.5 * (1.0 - x), 0.5 * (1.0 + x)];
        let radius = linear[0] * a[0] + linear[1] * b[0];
        SidePoint {
            shape: [-x * linear[0], x * linear[1], 1.0 - x * x],
            linear,
            weight: std::f64::consts::TAU * radius * length * weight,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Fineness;
    use crate::specimen::Specimen;

    #[test]
    fn points_integrate_the_volume_and_gradients_sum_to_zero() {
        let g = Specimen::table1().geometry;
        let mesh = Mesh::new(&g, &Fineness::default());
        let all: Vec<GaussPoint> = mesh.triangles.iter().flat_map(|t| points(&mesh, t)).collect();
        let volume = std::f64::consts::PI * g.sample_radius.powi(2) * g.sample_height;
        assert!((all.iter().map(|p| p.weight).sum::<f64>() / volume - 1.0).abs() < 1e-12);
        for p in &all {
            assert!((p.shape.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let sum = |k: usize| p.gradient.iter().map(|g| g[k]).sum::<f64>() * g.punch_radius;
            assert!(sum(0).abs() < 1e-8 && sum(1).abs() < 1e-8);
        }
        let face: f64 = mesh.face.iter().flat_map(|s| side_points(&mesh, s)).map(|p| p.weight).sum();
        assert!((face / (std::f64::consts::PI * g.punch_radius.powi(2)) - 1.0).abs() < 1e-12);
    }
}
