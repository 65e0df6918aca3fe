//! The specimen under the punch: its state, one stage, one step, and their derivatives by the material and by the
//! magnitudes of effects.
//!
//! A step is a sequence of implicit stages ([`step`]). A stage looks for the equilibrium (`search`) of the nodes
//! in contact (`stage`), asks the surface whether the same nodes may stay in contact, and solves again until
//! they may. It returns what it found: nothing of a state changes while it is being solved.

pub mod derivatives;
pub mod extrapolation;
mod magnitudes;
#[cfg(test)]
mod rollover_tests;
pub mod sample;
mod search;
pub mod setup;
mod stage;
pub mod state;
pub mod step;
pub mod stepper;
mod system;

pub use derivatives::Sensitivity;
pub use sample::Sample;
pub use setup::Setup;
pub use state::{Lengths, State};
pub use step::{Constants, Discretisation, Motion, Patience, Step};
pub use stepper::Stepper;
