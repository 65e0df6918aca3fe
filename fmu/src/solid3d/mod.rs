//! The paper's three-dimensional model: a quarter of the cylinder in Q2/Q1 hexahedra with hanging nodes.
//!
//! It solves the same equations with the same constitutive laws as the axisymmetric model and is its
//! verification twin. Symmetric tensors are 6-vectors `[xx, yy, zz, xy, yz, zx]`; as strains, the
//! last three components are engineering shears.

pub mod assembly;
pub mod boundary;
pub mod field;
pub mod forest;
pub mod geometry;
pub mod kernel;
pub mod krylov;
pub mod layout;
pub mod linear;
pub mod mesh;
pub mod point;
pub mod sample;
pub mod shape;
pub mod spectral;
pub mod step;

/// Symmetric tensor `[xx, yy, zz, xy, yz, zx]`.
pub type Voigt = [f64; 6];

/// Linear map between two [`Voigt`] tensors.
pub type Voigt2 = [[f64; 6]; 6];

/// Second-order tensor by rows.
pub type Tensor = [[f64; 3]; 3];

/// The unit tensor: `Cv^-1` before any flow.
pub const IDENTITY: Voigt = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];

/// Place of the component (i, j) in a [`Voigt`].
pub const PLACE: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
