//! Weak forms of momentum and mass balance (Eqs. 4, 5) at an integration point, with their tangent.

use crate::element::GaussPoint;
use crate::law::Response;

/// Quantities of an integration point in the current configuration.
pub struct Local {
    /// Gradients of the quadratic functions, and the function over the radius (1/m).
    gradient: [[f64; 3]; 6],
    linear_gradient: [[f64; 2]; 3],
    /// Kirchhoff stress with the pore pressure (Pa): rr, zz, rz, hoop.
    tau: [f64; 4],
    pore: f64,
    /// Gradient of the pore pressure (Pa/m).
    slope: [f64; 2],
}

impl Local {
    /// At a deformation gradient with its response, and the corners' pressures (Pa).
    pub fn new(g: &GaussPoint, f: &[f64; 5], r: &Response, p: &[f64; 3]) -> Self {
        let i = &r.inverse;
        let push = |v: &[f64; 2]| [i[0] * v[0] + i[2] * v[1], i[1] * v[0] + i[3] * v[1]];
        let radius = g.radius * f[4];
        let gradient = std::array::from_fn(|a| {
            let v = push(&g.gradient[a]);
            [v[0], v[1], g.shape[a] / radius]
        });
        let linear_gradient: [[f64; 2]; 3] = std::array::from_fn(|q| push(&g.linear_gradient[q]));
        let pressure: f64 = (0..3).map(|q| g.linear[q] * p[q]).sum();
        let pore = pressure * r.volume;
        let slope = [0, 1].map(|k| (0..3).map(|q| linear_gradient[q][k] * p[q]).sum());
        let tau = [r.tau[0] - pore, r.tau[1] - pore, r.tau[2], r.tau[3] - pore];
        Self { gradient, linear_gradient, tau, pore, slope }
    }

    /// Adds the weak forms of Eqs. 4 and 5, the second times `-gamma unit`.
    pub fn add_residual(
        &self,
        g: &GaussPoint,
        r: &Response,
        gamma: f64,
        unit: f64,
        residual: &mut [f64; 15],
    ) {
        let (w, t) = (g.weight, &self.tau);
        for (a, d) in self.gradient.iter().enumerate() {
            residual[2 * a] += w * (t[0] * d[0] + t[2] * d[1] + t[3] * d[2]);
            residual[2 * a + 1] += w * (t[2] * d[0] + t[1] * d[1]);
        }
        let flow = gamma * r.volume * r.mobility;
        for q in 0..3 {
            let d = &self.linear_gradient[q];
            let seepage = flow * (d[0] * self.slope[0] + d[1] * self.slope[1]);
            residual[12 + q] -= w * unit * (g.linear[q] * (r.volume - r.volume_start) + seepage);
        }
    }

    /// `D = d(tau F^-T) F^T` by `l` in `[rr, rz, zr, zz, hoop]`.
    fn moduli(&self, r: &Response) -> [[f64; 5]; 5] {
        let (t, c) = (&self.tau, &r.tangent);
        let mut d = [c[0], c[2], c[2], c[1], c[3]];
        for i in [0, 3, 4] {
            for k in [0, 3, 4] {
                d[i][k] -= self.pore;
            }
        }
        d[0][0] -= t[0];
        d[0][1] -= t[2];
        d[1][2] -= t[0];
        d[1][3] -= t[2];
        d[2][0] -= t[2];
        d[2][1] -= t[1];
        d[3][2] -= t[2];
        d[3][3] -= t[1];
        d[4][4] -= t[3];
        d
    }

    /// Adds their derivative.
    pub fn add_tangent(
        &self,
        g: &GaussPoint,
        r: &Response,
        gamma: f64,
        unit: f64,
        matrix: &mut [[f64; 15]; 15],
    ) {
        let w = g.weight;
        let d = self.moduli(r);
        // How the seepage's paths change with the displacement is left out: small, and the only part without symmetry.
        let flow = gamma * r.volume * r.mobility;
        for (b, gb) in self.gradient.iter().enumerate() {
            for i in 0..2 {
                let column = 2 * b + i;
                // Displacement `i` of node `b` as a velocity gradient, times the moduli.
                let s: [f64; 5] = std::array::from_fn(|k| match i {
                    0 => d[k][0] * gb[0] + d[k][1] * gb[1] + d[k][4] * gb[2],
                    _ => d[k][2] * gb[0] + d[k][3] * gb[1],
                });
                for (a, ga) in self.gradient.iter().enumerate() {
                    matrix[2 * a][column] += w * (s[0] * ga[0] + s[1] * ga[1] + s[4] * ga[2]);
                    matrix[2 * a + 1][column] += w * (s[2] * ga[0] + s[3] * ga[1]);
                }
                let dilation = if i == 0 { gb[0] + gb[2] } else { gb[1] };
                for q in 0..3 {
                    let volume = w * unit * g.linear[q] * r.volume * dilation;
                    matrix[12 + q][column] -= volume;
                    matrix[column][12 + q] -= volume;
                }
            }
        }
        for q in 0..3 {
            for s in 0..3 {
                let (dq, ds) = (&self.linear_gradient[q], &self.linear_gradient[s]);
                matrix[12 + q][12 + s] -= w * unit * unit * flow * (dq[0] * ds[0] + dq[1] * ds[1]);
            }
        }
    }
}
