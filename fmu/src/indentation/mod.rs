//! The indentation test: sample, boundary conditions, one time step, the punch's motion.

mod adhesion;
pub mod boundary;
pub mod contact;
#[cfg(test)]
mod contact_tests;
pub mod coupling;
pub mod discretisation;
pub mod engine;
pub mod load_cell;
pub mod motion;
pub mod profile;
pub mod sample;
pub mod sensitivity;
pub mod snapshot;
mod stage;
pub mod step;
pub mod trend;
