//! The punch's motion in time: protocols, and the path that is integrated along them.

mod interpolation;
pub mod path;
pub mod protocol;
mod step_control;
pub mod stops;
#[cfg(test)]
mod tests;

pub use path::Path;
pub use stops::{Reached, Stops};
