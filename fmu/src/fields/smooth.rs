//! From quadrature points to nodes: the linear function closest to the values in each direction of an element.

use crate::element::shape::{GAUSS_POINTS, POINTS, volumetric_lagrange};
use crate::mesh::{CORNERS, NODES};

/// Where local node `3 j + i` lies in the reference square.
pub(super) fn place(node: usize) -> [f64; 2] {
    [(node % 3) as f64 - 1.0, (node / 3) as f64 - 1.0]
}

/// Matrices that take the values of an element's quadrature points to its nodes.
pub(super) struct Smoothing {
    /// From the 3 x 3 points: least squares by 1, xi, eta, xi eta.
    pub gauss: [[f64; POINTS]; NODES],
    /// From the 2 x 2 points, where the same function passes through the values.
    pub volumetric: [[f64; CORNERS]; NODES],
}

impl Smoothing {
    pub fn new() -> Self {
        let gauss = std::array::from_fn(|node| {
            let [xi, eta] = place(node);
            // The four functions are orthogonal: int xi^2 = 2/3 along one side, int 1 = 2.
            let along = |x: f64, y: f64| 0.5 + 1.5 * x * y;
            std::array::from_fn(|k| {
                let point = &GAUSS_POINTS[k];
                point.weight * along(xi, point.xi[0]) * along(eta, point.xi[1])
            })
        });
        Self { gauss, volumetric: std::array::from_fn(|node| volumetric_lagrange(place(node))) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::shape::VOLUMETRIC_POINTS;

    #[test]
    fn bilinear_functions_pass_unchanged() {
        let f = |[x, y]: [f64; 2]| 2.0 - x + 3.0 * y - 4.0 * x * y;
        let smoothing = Smoothing::new();
        for node in 0..NODES {
            let gauss: f64 =
                smoothing.gauss[node].iter().zip(GAUSS_POINTS.iter()).map(|(w, p)| w * f(p.xi)).sum();
            let volumetric: f64 = smoothing.volumetric[node]
                .iter()
                .zip(VOLUMETRIC_POINTS.iter())
                .map(|(w, p)| w * f(p.xi))
                .sum();
            approx::assert_relative_eq!(gauss, f(place(node)), epsilon = 1e-12);
            approx::assert_relative_eq!(volumetric, f(place(node)), epsilon = 1e-12);
        }
    }

    /// A checkerboard that the linear functions cannot hold is smoothed away rather than blown up.
    #[test]
    fn what_oscillates_is_not_amplified() {
        let values: Vec<f64> = (0..POINTS).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        for row in Smoothing::new().gauss {
            let node: f64 = row.iter().zip(&values).map(|(w, v)| w * v).sum();
            assert!(node.abs() < 1.0, "{node}");
        }
    }
}
