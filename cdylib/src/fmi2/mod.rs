//! The FMI 2.0 face: 34 C functions.

pub mod abi;
mod common;
mod cosimulation;

pub use common::*;
pub use cosimulation::*;
