//! The functions of an FMI 3.0 library.
#![allow(unsafe_code)]

use super::core::{Component, Plain};
use super::states::StateNames;
use super::symbols::functions;
use std::ffi::{c_char, c_int, c_void};

/// `fmi3LogMessageCallback`.
pub type LogMessage = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);

/// A get function: value references, their number, values, their number.
pub type Get<T> = unsafe extern "C" fn(Component, *const u32, usize, *mut T, usize) -> c_int;
/// A set function.
pub type Set<T> = unsafe extern "C" fn(Component, *const u32, usize, *const T, usize) -> c_int;

functions! { Binary3: STATES;
    instantiate: "fmi3InstantiateCoSimulation" as unsafe extern "C" fn(
        *const c_char, *const c_char, *const c_char, bool, bool, bool, bool, *const u32, usize, *mut c_void,
        LogMessage, *const c_void) -> Component;
    free_instance: "fmi3FreeInstance" as unsafe extern "C" fn(Component);
    enter_initialization: "fmi3EnterInitializationMode" as unsafe extern "C" fn(
        Component, bool, f64, f64, bool, f64) -> c_int;
    exit_initialization: "fmi3ExitInitializationMode" as Plain;
    terminate: "fmi3Terminate" as Plain;
    reset: "fmi3Reset" as Plain;
    get_float64: "fmi3GetFloat64" as Get<f64>;
    set_float64: "fmi3SetFloat64" as Set<f64>;
    #[optional] get_float32: "fmi3GetFloat32" as Get<f32>;
    #[optional] set_float32: "fmi3SetFloat32" as Set<f32>;
    #[optional] get_int8: "fmi3GetInt8" as Get<i8>;
    #[optional] set_int8: "fmi3SetInt8" as Set<i8>;
    #[optional] get_uint8: "fmi3GetUInt8" as Get<u8>;
    #[optional] set_uint8: "fmi3SetUInt8" as Set<u8>;
    #[optional] get_int16: "fmi3GetInt16" as Get<i16>;
    #[optional] set_int16: "fmi3SetInt16" as Set<i16>;
    #[optional] get_uint16: "fmi3GetUInt16" as Get<u16>;
    #[optional] set_uint16: "fmi3SetUInt16" as Set<u16>;
    #[optional] get_int32: "fmi3GetInt32" as Get<i32>;
    #[optional] set_int32: "fmi3SetInt32" as Set<i32>;
    #[optional] get_uint32: "fmi3GetUInt32" as Get<u32>;
    #[optional] set_uint32: "fmi3SetUInt32" as Set<u32>;
    #[optional] get_int64: "fmi3GetInt64" as Get<i64>;
    #[optional] set_int64: "fmi3SetInt64" as Set<i64>;
    #[optional] get_uint64: "fmi3GetUInt64" as Get<u64>;
    #[optional] set_uint64: "fmi3SetUInt64" as Set<u64>;
    // C's bool as a byte: what a foreign FMU writes may be neither 0 nor 1.
    #[optional] get_boolean: "fmi3GetBoolean" as Get<u8>;
    #[optional] set_boolean: "fmi3SetBoolean" as Set<u8>;
    #[optional] get_string: "fmi3GetString" as Get<*const c_char>;
    #[optional] set_string: "fmi3SetString" as Set<*const c_char>;
    do_step: "fmi3DoStep" as unsafe extern "C" fn(
        Component, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;
}

const STATES: StateNames = StateNames {
    handles: ["fmi3GetFMUState", "fmi3SetFMUState", "fmi3FreeFMUState"],
    bytes: ["fmi3SerializedFMUStateSize", "fmi3SerializeFMUState", "fmi3DeserializeFMUState"],
};
