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

mod builder;
pub mod contact;
mod edge;
pub mod effect;
pub mod element;
pub mod engine;
pub mod error;
pub mod fields;
pub mod instance;
pub mod interface;
pub mod law;
pub mod machine;
pub mod mesh;
pub mod motion;
pub mod number;
pub mod outputs;
pub mod parameters;
mod registry;
pub mod sensor;
pub mod solid3d;
pub mod solver;
pub mod specimen;
pub mod unit;

pub use error::{ParameterError, StepError};
pub use fields::{Fields, FieldsError};
pub use instance::{Instance, Model, Snapshot};
pub use interface::{cosimulation, model_description, variables};
pub use motion::protocol::{Protocol, Trapezoid};
pub use outputs::{ForceSensitivity, Outputs, Statistics};
pub use parameters::Parameters;
