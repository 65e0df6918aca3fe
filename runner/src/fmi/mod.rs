//! Loads and drives FMI 2.0 and 3.0 co-simulation FMUs: ours and anybody's.
//!
//! ```text
//! Fmu::open(path) -> description() -> instantiate(name) -> set, initialise, do_step, get -> reset, again
//! ```
//! One shared library serves all instances; an instance may move between threads.

mod archive;
mod binary2;
mod binary3;
mod core;
mod description;
mod description3;
mod error;
mod fmu;
mod instance;
mod instance2;
mod instance3;
mod places;
mod states;
mod symbols;

pub use archive::{Files, PLATFORM, PLATFORM_TUPLE};
pub use description::{
    Capabilities, DefaultExperiment, ModelDescription, Range, ScalarVariable, VariableKind, Version,
};
pub use error::FmiError;
pub use fmu::{Fmu, builtin_library};
pub use instance::FmuInstance;
pub use states::FmuState;
