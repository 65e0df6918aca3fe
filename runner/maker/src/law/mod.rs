//! The laws at a point, Eqs. 7-12, each with its exact tangent.
//!
//! In-plane tensors are written `[rr, rz, zr, zz, hoop]`, symmetric ones `[rr, zz, rz, hoop]`.

mod branch;
mod ogden;
mod point;
mod porous;

pub use branch::Thinning;
pub use point::{Laws, Past, Point, Response, Softening};
pub use porous::{Seepage, Volumetric};

/// `[rr, rz, zr, zz, hoop]`.
pub type Tensor = [f64; 5];

/// `[rr, zz, rz, hoop]`.
pub type Symmetric = [f64; 4];

/// Determinant.
pub fn determinant(f: &Tensor) -> f64 {
    (f[0] * f[3] - f[1] * f[2]) * f[4]
}

/// Inverse.
pub fn inverse(f: &Tensor) -> Tensor {
    let d = 1.0 / (f[0] * f[3] - f[1] * f[2]);
    [f[3] * d, -f[1] * d, -f[2] * d, f[0] * d, 1.0 / f[4]]
}

/// `f c f^T`.
pub fn push(f: &Tensor, c: &Symmetric) -> Symmetric {
    let (a, b) = (f[0] * c[0] + f[1] * c[2], f[0] * c[2] + f[1] * c[1]);
    let (d, e) = (f[2] * c[0] + f[3] * c[2], f[2] * c[2] + f[3] * c[1]);
    [a * f[0] + b * f[1], d * f[2] + e * f[3], a * f[2] + b * f[3], f[4] * f[4] * c[3]]
}

/// The identity.
pub const ONE: Symmetric = [1.0, 1.0, 0.0, 1.0];
