//! The functions of an FMI 2.0 library.
#![allow(unsafe_code)]

use super::core::{Component, Plain};
use super::states::StateNames;
use super::symbols::functions;
use std::ffi::{c_char, c_int, c_void};

/// Signature of our logger: the fixed arguments only; C passes them alike to variadic functions.
pub type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char);

/// `fmi2CallbackFunctions`.
#[repr(C)]
pub struct Callbacks {
    pub logger: Logger,
    pub allocate: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    pub free: unsafe extern "C" fn(*mut c_void),
    pub step_finished: *const c_void,
    pub environment: *mut c_void,
}

type Get<T> = unsafe extern "C" fn(Component, *const u32, usize, *mut T) -> c_int;
type Set<T> = unsafe extern "C" fn(Component, *const u32, usize, *const T) -> c_int;

functions! { Binary2: STATES;
    instantiate: "fmi2Instantiate" as unsafe extern "C" fn(
        *const c_char, c_int, *const c_char, *const c_char, *const Callbacks, c_int, c_int) -> Component;
    free_instance: "fmi2FreeInstance" as unsafe extern "C" fn(Component);
    enter_initialization: "fmi2EnterInitializationMode" as Plain;
    exit_initialization: "fmi2ExitInitializationMode" as Plain;
    terminate: "fmi2Terminate" as Plain;
    reset: "fmi2Reset" as Plain;
    setup_experiment: "fmi2SetupExperiment" as unsafe extern "C" fn(
        Component, c_int, f64, f64, c_int, f64) -> c_int;
    get_real: "fmi2GetReal" as Get<f64>;
    get_integer: "fmi2GetInteger" as Get<c_int>;
    get_boolean: "fmi2GetBoolean" as Get<c_int>;
    set_real: "fmi2SetReal" as Set<f64>;
    set_integer: "fmi2SetInteger" as Set<c_int>;
    set_boolean: "fmi2SetBoolean" as Set<c_int>;
    #[optional] get_string: "fmi2GetString" as Get<*const c_char>;
    #[optional] set_string: "fmi2SetString" as Set<*const c_char>;
    do_step: "fmi2DoStep" as unsafe extern "C" fn(Component, f64, f64, c_int) -> c_int;
    #[optional] set_input_derivatives: "fmi2SetRealInputDerivatives" as unsafe extern "C" fn(
        Component, *const u32, usize, *const c_int, *const f64) -> c_int;
}

const STATES: StateNames = StateNames {
    handles: ["fmi2GetFMUstate", "fmi2SetFMUstate", "fmi2FreeFMUstate"],
    bytes: ["fmi2SerializedFMUstateSize", "fmi2SerializeFMUstate", "fmi2DeSerializeFMUstate"],
};

// Plain C memory for FMUs that want the master's. C's own calloc and free keep the size for us.
unsafe extern "C" {
    /// C's calloc.
    pub fn calloc(n: usize, size: usize) -> *mut c_void;
    /// C's free.
    pub fn free(memory: *mut c_void);
}
