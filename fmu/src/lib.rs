//! **poropunch**: a flat punch pressed into a soft, water-saturated sample.
//!
//! Finite-strain Theory of Porous Media (solid displacement and pore pressure),
//! Ogden equilibrium with Reese–Govindjee viscous branches and Darcy flow, on
//! axisymmetric Taylor–Hood elements. SI units throughout; displacement and
//! indentation force are positive into the sample.
//!
//! ```text
//! Parameters -> Model (mesh, structure) -> Instance -> advance, advance, ... -> Outputs
//! ```

// Tensor formulae are read by their indices.
#![allow(clippy::needless_range_loop)]

pub mod cosimulation;
pub mod effect;
pub mod element;
pub mod error;
pub mod fields;
mod hash;
pub mod indentation;
pub mod instance;
pub mod material;
pub mod mesh;
pub mod model_description;
pub mod number;
pub mod outputs;
pub mod parameters;
pub mod protocol;
mod registry;
pub mod solid3d;
pub mod solver;
pub mod variables;

pub use error::{ParameterError, StepError};
pub use fields::{Fields, FieldsError};
pub use instance::{Instance, Model, Snapshot};
pub use outputs::{ForceSensitivity, Outputs, Statistics};
pub use parameters::Parameters;
pub use protocol::{Protocol, Trapezoid};
