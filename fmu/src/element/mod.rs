//! The axisymmetric Q2/Q1 (Taylor–Hood) element: residual, consistent tangent, history update.

pub mod assembly;
pub mod field;
pub mod geometry;
pub mod kernel;
pub mod shape;

pub use kernel::{ElementSystem, Point, PointState};
