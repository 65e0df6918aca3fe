//! Types of the FMI 2.0.5 headers (`fmi2TypesPlatform.h`, `fmi2FunctionTypes.h`).

use crate::guard::Status;
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::ptr::{null, null_mut};

/// `fmi2Boolean`: 0 is false.
pub type Boolean = c_int;
/// `fmi2ValueReference`.
pub type ValueReference = c_uint;

/// `fmi2CoSimulation` of `fmi2Type`.
pub const CO_SIMULATION: c_int = 1;

/// `fmi2CallbackLogger`.
pub type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, ...);
/// The same without the variadic part, as a host in Rust can define it.
pub type FixedLogger = unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char);

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

impl CallbackFunctions {
    /// Of a host that hears nothing.
    pub const SILENT: Self = Self {
        logger: None,
        allocate_memory: null(),
        free_memory: null(),
        step_finished: null(),
        component_environment: null_mut(),
    };

    /// Of a host in Rust that hears messages.
    pub fn hearing(logger: FixedLogger, component_environment: *mut c_void) -> Self {
        // SAFETY: the variadic part is never used; x86-64 and aarch64 Linux pass the named arguments alike.
        let logger = unsafe { std::mem::transmute::<FixedLogger, Logger>(logger) };
        Self { logger: Some(logger), component_environment, ..Self::SILENT }
    }
}
