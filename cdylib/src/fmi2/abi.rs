//! Types of the FMI 2.0.5 headers (`fmi2TypesPlatform.h`, `fmi2FunctionTypes.h`).

use crate::guard::Status;
use std::ffi::{c_char, c_int, c_uint, c_void};

/// `fmi2Boolean`: 0 is false.
pub type Boolean = c_int;
/// `fmi2ValueReference`.
pub type ValueReference = c_uint;

/// `fmi2CoSimulation` of `fmi2Type`.
pub const CO_SIMULATION: c_int = 1;

/// `fmi2CallbackLogger`.
pub type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`. The memory callbacks are not used (`canNotUseMemoryManagementFunctions`),
/// and `stepFinished` is for asynchronous slaves only.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct CallbackFunctions {
    /// Called with every message.
    pub logger: Option<Logger>,
    /// Unused.
    pub allocate_memory: *const c_void,
    /// Unused.
    pub free_memory: *const c_void,
    /// Unused.
    pub step_finished: *const c_void,
    /// Given back to the logger.
    pub component_environment: *mut c_void,
}
