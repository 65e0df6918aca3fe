//! Constitutive laws at a point, in principal logarithmic strains.
//!
//! Symmetric tensors of the axisymmetric problem are 4-vectors `[rr, zz, tt, rz]`;
//! as strains, the last component is the engineering shear `2 d_rz`.

pub mod branch;
pub mod darcy;
pub mod ogden;
pub mod point;
pub mod spectral;
pub mod volumetric;

pub use point::{Elasticity, PointMaterial};

/// Symmetric tensor of the axisymmetric problem, `[rr, zz, tt, rz]`.
pub type Voigt = [f64; 4];

/// Linear map between two [`Voigt`] tensors.
pub type Voigt2 = [[f64; 4]; 4];

/// Inverse of the left Cauchy–Green-like history tensor of one branch, `Cv^-1`.
pub const IDENTITY: Voigt = [1.0, 1.0, 1.0, 0.0];
