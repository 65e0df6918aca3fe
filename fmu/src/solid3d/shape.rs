//! Shape functions on the reference cube [-1, 1]^3 and its Gauss rules.

use crate::element::shape::{Functions, GAUSS, RULE, linear, quadratic};
use std::sync::LazyLock;

/// Nodes per cell: Q2 displacement; local number `i + 3 j + 9 k`.
pub const NODES: usize = 27;
/// Corners per cell: Q1 pressure; local number `i + 2 j + 4 k`.
pub const CORNERS: usize = 8;
/// Unknowns per cell: three displacements node by node, then the pressures.
pub const UNKNOWNS: usize = 3 * NODES + CORNERS;
/// Integration points per cell.
pub const POINTS: usize = 27;

/// Local node of every corner.
pub const CORNER_NODES: [usize; CORNERS] = [0, 2, 6, 8, 18, 20, 24, 26];

/// Values at one point of the reference cube.
pub type Shape = Functions<3, NODES, CORNERS>;

impl Shape {
    /// Shape functions at `xi`.
    pub fn at(xi: [f64; 3], weight: f64) -> Self {
        let q: [_; 3] = xi.map(quadratic);
        let l: [_; 3] = xi.map(linear);
        let slope = [-0.5, 0.5];
        let node = |a: usize| [a % 3, a / 3 % 3, a / 9];
        let corner = |m: usize| [m % 2, m / 2 % 2, m / 4];
        Self {
            n: std::array::from_fn(|a| (0..3).map(|d| q[d].0[node(a)[d]]).product()),
            dn: std::array::from_fn(|a| {
                std::array::from_fn(|e| {
                    (0..3).map(|d| if d == e { q[d].1[node(a)[d]] } else { q[d].0[node(a)[d]] }).product()
                })
            }),
            p: std::array::from_fn(|m| (0..3).map(|d| l[d][corner(m)[d]]).product()),
            dp: std::array::from_fn(|m| {
                std::array::from_fn(|e| {
                    (0..3).map(|d| if d == e { slope[corner(m)[d]] } else { l[d][corner(m)[d]] }).product()
                })
            }),
            xi,
            weight,
        }
    }
}

/// The 3 x 3 x 3 Gauss points, `i + 3 j + 9 k`.
pub static GAUSS_POINTS: LazyLock<[Shape; POINTS]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let (x, y, z) = (RULE[k % 3], RULE[k / 3 % 3], RULE[k / 9]);
        Shape::at([x.0, y.0, z.0], x.1 * y.1 * z.1)
    })
});

/// The 2 x 2 x 2 Gauss points, where the volumetric law is integrated.
pub static VOLUMETRIC_POINTS: LazyLock<[Shape; CORNERS]> = LazyLock::new(|| {
    let x = 1.0 / 3.0_f64.sqrt();
    let at = |upper: usize| if upper == 0 { -x } else { x };
    std::array::from_fn(|k| Shape::at([at(k % 2), at(k / 2 % 2), at(k / 4)], 1.0))
});

/// Values at `xi` of the polynomials that interpolate between the Gauss points.
pub fn gauss_lagrange(xi: [f64; 3]) -> [f64; POINTS] {
    Shape::at(xi.map(|x| x / GAUSS), 0.0).n
}

/// Values at `xi` of the trilinear functions that interpolate between the volumetric points.
pub fn volumetric_lagrange(xi: [f64; 3]) -> [f64; CORNERS] {
    Shape::at(xi.map(|x| x * 3.0_f64.sqrt()), 0.0).p
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_a_partition_of_unity() {
        let s = Shape::at([0.3, -0.7, 0.2], 0.0);
        approx::assert_relative_eq!(s.n.iter().sum::<f64>(), 1.0, max_relative = 1e-14);
        approx::assert_relative_eq!(s.p.iter().sum::<f64>(), 1.0, max_relative = 1e-14);
        for d in 0..3 {
            assert!(s.dn.iter().map(|g| g[d]).sum::<f64>().abs() < 1e-14);
            assert!(s.dp.iter().map(|g| g[d]).sum::<f64>().abs() < 1e-14);
        }
        let volume = |rule: &[Shape]| rule.iter().map(|s| s.weight).sum::<f64>();
        approx::assert_relative_eq!(volume(&*GAUSS_POINTS), 8.0, max_relative = 1e-14);
        approx::assert_relative_eq!(volume(&*VOLUMETRIC_POINTS), 8.0, max_relative = 1e-14);
    }

    /// Values and derivatives of triquadratics are reproduced from the nodes, values from the Gauss points.
    #[test]
    fn triquadratics_are_reproduced() {
        let f = |x: [f64; 3]| 1.0 + x[0] - 2.0 * x[1] * x[2] + x[0] * x[0] * x[1] * x[1] * x[2] * x[2];
        let slope = |x: [f64; 3]| -2.0 * x[2] + 2.0 * x[0] * x[0] * x[1] * x[2] * x[2];
        let x = [0.9, -0.4, 0.3];
        let s = Shape::at(x, 0.0);
        let node = |a: usize| [a % 3, a / 3 % 3, a / 9].map(|i| i as f64 - 1.0);
        let value: f64 = (0..NODES).map(|a| s.n[a] * f(node(a))).sum();
        approx::assert_relative_eq!(value, f(x), max_relative = 1e-13);
        let derivative: f64 = (0..NODES).map(|a| s.dn[a][1] * f(node(a))).sum();
        approx::assert_relative_eq!(derivative, slope(x), max_relative = 1e-13);
        let value: f64 = gauss_lagrange(x).iter().zip(GAUSS_POINTS.iter()).map(|(l, g)| l * f(g.xi)).sum();
        approx::assert_relative_eq!(value, f(x), max_relative = 1e-13);
    }
}
