//! Contact of the punch's face with the surface: which nodes touch, stick, slide and peel.

pub mod adhesion;
pub mod conditions;
pub mod decision;
pub mod parameters;
pub mod profile;
pub mod status;
pub mod surface;
#[cfg(test)]
mod tests;
mod yielding;

pub use adhesion::Adhesion;
pub use conditions::{Condition, Conditions};
pub use decision::Decision;
pub use profile::Profile;
pub use status::{Contact, Status};
pub use surface::{Surface, Touch};
