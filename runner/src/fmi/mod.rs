//! Loads and drives FMI 2.0 co-simulation FMUs: ours and anybody's.
//!
//! ```text
//! Fmu::open(path) -> description() -> instantiate(name) -> set, initialise, do_step, get -> reset, again
//! ```
//! One shared library serves all instances; an instance may move between threads.

mod archive;
mod binary;
mod description;
mod error;
mod fmu;
mod instance;

pub use archive::{Files, PLATFORM, read_description};
pub use description::{Capabilities, DefaultExperiment, ModelDescription, ScalarVariable, VariableKind};
pub use error::FmiError;
pub use fmu::{Fmu, builtin_library};
pub use instance::{FmuInstance, FmuState};
