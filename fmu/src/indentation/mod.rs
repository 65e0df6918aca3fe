//! The indentation test: contact, boundary conditions, machine, load cell, the punch's motion.

mod adhesion;
pub mod boundary;
pub mod contact;
#[cfg(test)]
mod contact_tests;
pub mod coupling;
pub mod engine;
pub mod load_cell;
pub mod motion;
pub mod profile;
mod yielding;
