//! The axisymmetric Q2/Q1 (Taylor–Hood) element: residual, consistent tangent, history update.

pub mod assembly;
pub mod field;
pub mod geometry;
mod group;
pub mod history;
pub mod kernel;
mod magnitudes;
pub mod sensitivity;
pub mod shape;
#[cfg(test)]
mod tests;

pub use assembly::{AssemblyMap, Body, Inadmissible, Stage, element_history, undeformed};
pub use history::History;
pub use kernel::{Point, PointState};
