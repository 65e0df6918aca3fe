//! Types of the FMI 3.0 headers (`fmi3PlatformTypes.h`, `fmi3FunctionTypes.h`).

use crate::guard::Status;
use std::ffi::{c_char, c_void};

/// `fmi3Boolean`, `fmi3Clock`: C's bool. As a byte, for what a host passes may be neither 0 nor 1.
pub type Boolean = u8;
/// `fmi3ValueReference`.
pub type ValueReference = u32;

/// `fmi3LogMessageCallback`.
pub type LogMessage = unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char);

/// `fmi3IntermediateUpdateCallback`: environment, time, whether variables are asked for and may be read, whether a step
/// of the integrator is finished, whether the master may end the step here; whether and where it wants to.
pub type IntermediateUpdate =
    unsafe extern "C" fn(*mut c_void, f64, Boolean, Boolean, Boolean, Boolean, *mut Boolean, *mut f64);
