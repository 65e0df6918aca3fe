//! The axisymmetric Q2/Q1 (Taylor–Hood) element: residual, consistent tangent, history update.

pub mod assembly;
pub mod field;
pub mod geometry;
mod group;
pub mod kernel;
pub mod sensitivity;
pub mod shape;
#[cfg(test)]
mod tests;

pub use assembly::{AssemblyMap, Body, History, Inadmissible, Stage};
pub use kernel::{ElementSystem, Point, PointState};
