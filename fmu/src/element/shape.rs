//! Shape functions on the reference square [-1, 1]^2 and the 3 x 3 Gauss rule.

use crate::mesh::{CORNERS, NODES};
use std::sync::LazyLock;

/// Integration points per element.
pub const POINTS: usize = 9;

/// Values at one point of the reference square, or cube, of a Q2/Q1 element.
#[derive(Debug, Clone, Copy)]
pub struct Functions<const DIMENSION: usize, const NODES: usize, const CORNERS: usize> {
    /// Quadratic functions of the nodes.
    pub n: [f64; NODES],
    /// Their derivatives with respect to the reference coordinates.
    pub dn: [[f64; DIMENSION]; NODES],
    /// Linear functions of the corners.
    pub p: [f64; CORNERS],
    /// Their derivatives.
    pub dp: [[f64; DIMENSION]; CORNERS],
    /// Position.
    pub xi: [f64; DIMENSION],
    /// Quadrature weight (0 where the point is none of the rule's).
    pub weight: f64,
}

/// Values at one point of the reference square.
pub type Shape = Functions<2, NODES, CORNERS>;

impl Shape {
    /// Shape functions at (xi, eta).
    pub fn at(xi: [f64; 2], weight: f64) -> Self {
        let (a, da) = quadratic(xi[0]);
        let (b, db) = quadratic(xi[1]);
        let (c, d) = (linear(xi[0]), linear(xi[1]));
        let slope = [-0.5, 0.5];
        Self {
            n: std::array::from_fn(|k| a[k % 3] * b[k / 3]),
            dn: std::array::from_fn(|k| [da[k % 3] * b[k / 3], a[k % 3] * db[k / 3]]),
            p: std::array::from_fn(|k| c[k % 2] * d[k / 2]),
            dp: std::array::from_fn(|k| [slope[k % 2] * d[k / 2], c[k % 2] * slope[k / 2]]),
            xi,
            weight,
        }
    }
}

/// Abscissa of the 3-point Gauss rule.
pub(crate) const GAUSS: f64 = 0.774_596_669_241_483_4;
/// Abscissae and weights of the 3-point Gauss rule.
pub const RULE: [(f64, f64); 3] = [(-GAUSS, 5.0 / 9.0), (0.0, 8.0 / 9.0), (GAUSS, 5.0 / 9.0)];

/// The 3 x 3 Gauss points, `3 j + i`.
pub static GAUSS_POINTS: LazyLock<[Shape; POINTS]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let ((x, wx), (y, wy)) = (RULE[k % 3], RULE[k / 3]);
        Shape::at([x, y], wx * wy)
    })
});

/// Values at (xi, eta) of the polynomials that interpolate between the Gauss points.
pub fn gauss_lagrange(xi: [f64; 2]) -> [f64; POINTS] {
    let (a, b) = (quadratic(xi[0] / GAUSS).0, quadratic(xi[1] / GAUSS).0);
    std::array::from_fn(|k| a[k % 3] * b[k / 3])
}

/// The 2 x 2 Gauss points, `2 j + i`, where the volumetric law is integrated.
pub static VOLUMETRIC_POINTS: LazyLock<[Shape; CORNERS]> = LazyLock::new(|| {
    let x = 1.0 / 3.0_f64.sqrt();
    std::array::from_fn(|k| {
        Shape::at([if k % 2 == 0 { -x } else { x }, if k / 2 == 0 { -x } else { x }], 1.0)
    })
});

/// Values at (xi, eta) of the bilinear functions that interpolate between the volumetric points.
pub fn volumetric_lagrange(xi: [f64; 2]) -> [f64; CORNERS] {
    let (a, b) = (linear(xi[0] * 3.0_f64.sqrt()), linear(xi[1] * 3.0_f64.sqrt()));
    std::array::from_fn(|k| a[k % 2] * b[k / 2])
}

/// The three quadratic functions on [-1, 1] and their derivatives.
#[inline]
pub(crate) fn quadratic(x: f64) -> ([f64; 3], [f64; 3]) {
    ([0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)], [x - 0.5, -2.0 * x, x + 0.5])
}

/// The two linear functions on [-1, 1].
#[inline]
pub(crate) fn linear(x: f64) -> [f64; 2] {
    [0.5 * (1.0 - x), 0.5 * (1.0 + x)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_a_partition_of_unity() {
        let s = Shape::at([0.3, -0.7], 0.0);
        approx::assert_relative_eq!(s.n.iter().sum::<f64>(), 1.0, max_relative = 1e-14);
        approx::assert_relative_eq!(s.p.iter().sum::<f64>(), 1.0, max_relative = 1e-14);
        for d in 0..2 {
            assert!(s.dn.iter().map(|g| g[d]).sum::<f64>().abs() < 1e-14);
        }
    }

    #[test]
    fn gauss_lagrange_reproduces_biquadratics() {
        let f = |x: [f64; 2]| 1.0 + x[0] - 2.0 * x[1] + x[0] * x[0] * x[1] * x[1];
        let x = [0.9, 1.0];
        let value: f64 = gauss_lagrange(x).iter().zip(GAUSS_POINTS.iter()).map(|(l, g)| l * f(g.xi)).sum();
        approx::assert_relative_eq!(value, f(x), max_relative = 1e-13);
    }
}
