//! Contact of the punch's face with the surface: which nodes touch, stick, slide and peel.

pub mod adhesion;
pub mod conditions;
pub mod parameters;
pub mod profile;
pub mod surface;
#[cfg(test)]
mod tests;
mod yielding;

pub use adhesion::Adhesion;
pub use conditions::{Condition, Conditions};
pub use profile::Profile;
pub use surface::{Contact, Decision, Status, Surface, Touch};
