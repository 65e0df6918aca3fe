//! The FMI 3.0 face: the 75 C functions of its headers, of which those of model exchange and scheduled execution
//! answer that they are not offered.

pub mod abi;
mod absent;
mod life;
mod step;
mod values;

pub use absent::*;
pub use life::*;
pub use step::*;
pub use values::*;

use abi::IntermediateUpdate;
use std::ffi::c_void;

/// What a master of FMI 3.0 wants of an instance.
#[derive(Clone, Copy)]
pub struct Modes {
    /// Whether it handles events.
    pub events: bool,
    /// Whether a step may end early, at an event.
    pub early_return: bool,
    /// Called within steps.
    pub intermediate_update: Option<IntermediateUpdate>,
    /// Whether it gives the displacement at the end of a step when asked for it there.
    pub gives_displacement: bool,
    /// Whether it gave it.
    pub gave_displacement: bool,
    /// Given back to the callback.
    pub environment: *mut c_void,
}
