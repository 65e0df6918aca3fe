//! The FMI 2.0 co-simulation face: 34 C functions over [`poropunch::cosimulation::Slave`].
//!
//! No threads, no thread-locals with destructors and no output here: hosts load and free this
//! library in loops, and print nothing of ours. Every entry point runs inside `guard::call`,
//! which checks the state machine, catches panics and logs the reason of every error.

pub mod abi;
mod component;
mod entry_common;
mod entry_cosimulation;
mod guard;
mod logger;
mod phase;

pub use entry_common::*;
pub use entry_cosimulation::*;
