//! Constitutive laws at a point, in principal logarithmic strains.
//!
//! Symmetric tensors of the axisymmetric problem are 4-vectors `[rr, zz, tt, rz]`;
//! as strains, the last component is the engineering shear `2 d_rz`.
//!
//! What an element's residual needs is written for any [`crate::number::Real`], one point or one of several
//! elements at once.

pub mod branch;
pub mod darcy;
pub mod extension_sensitivity;
pub mod extensions;
pub mod eyring;
pub mod magnitude;
pub mod ogden;
pub mod parameter;
pub mod parameters;
pub mod point;
pub(crate) mod relaxation;
pub mod sensitivity;
pub mod softening;
pub mod spectral;
pub mod volumetric;

pub use magnitude::Magnitude;
pub use parameter::{MaterialParameter, Spring};
pub use point::{Elasticity, PointMaterial};

/// Symmetric tensor of the axisymmetric problem, `[rr, zz, tt, rz]`.
pub type Voigt<T = f64> = [T; 4];

/// Linear map between two [`Voigt`] tensors.
pub type Voigt2<T = f64> = [[T; 4]; 4];

/// The unit tensor.
pub const IDENTITY: Voigt = [1.0, 1.0, 1.0, 0.0];
