//! FMI 2.0 and 3.0 co-simulation over [`poropunch::cosimulation::Slave`]: one library for both archives.
//!
//! What the versions share: the component with its life cycle, guarded calls, saved states, messages. [`fmi2`] and
//! [`fmi3`] only translate C's arguments.
//!
//! No threads, no thread-locals with destructors and no output here: hosts load and free this
//! library in loops, and print nothing of ours. Every entry point runs inside `guard::call`,
//! which checks the state machine, catches panics and logs the reason of every error.

mod component;
mod content;
pub mod fmi2;
pub mod fmi3;
mod guard;
mod life;
mod logger;
mod phase;
mod states;

pub use guard::{ERROR, OK, Status};
