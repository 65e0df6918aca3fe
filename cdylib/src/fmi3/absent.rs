//! What this FMU does not offer: types that no variable has, clocks, derivatives, the other kinds of simulation.
// SAFETY of all functions here: as in life.rs.
#![allow(clippy::missing_safety_doc, clippy::too_many_arguments)]

use super::abi::{Boolean, ValueReference};
use crate::guard::{Status, call};
use crate::phase::ANY;
use std::ffi::{c_int, c_void};

const NO_SUCH_TYPE: &str = "no variable of this FMU has this type";
const NO_CLOCKS: &str = "this FMU has no clocks: corners and contact are events";
const NO_DERIVATIVES: &str =
    "this FMU has no directional or adjoint derivatives; sensitivities are ordinary outputs";
const NO_DEPENDENCIES: &str =
    "dependencies of single elements are not told (providesPerElementDependencies is false)";
const CO_SIMULATION_ONLY: &str = "this FMU offers co-simulation only";

/// Functions that fail with a reason, but not when they are asked for nothing.
macro_rules! absent {
    ($reason:expr; $($name:ident($($type:ty),*);)+) => {
        $(/// Not offered.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            instance: *mut c_void,
            _references: *const ValueReference,
            n: usize,
            $(_: $type),*
        ) -> Status {
            // SAFETY: see the top of this file.
            unsafe {
                call(instance, stringify!($name), ANY, |_| {
                    if n == 0 { Ok(()) } else { Err($reason.to_owned()) }
                })
            }
        })+
    };
}

/// Functions that always fail with a reason.
macro_rules! refused {
    ($reason:expr; $($name:ident($($type:ty),*);)+) => {
        $(/// Not offered.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: *mut c_void, $(_: $type),*) -> Status {
            // SAFETY: see the top of this file.
            unsafe { call(instance, stringify!($name), ANY, |_| Err($reason.to_owned())) }
        })+
    };
}

absent! { NO_SUCH_TYPE;
    fmi3GetFloat32(*mut f32, usize);
    fmi3SetFloat32(*const f32, usize);
    fmi3GetInt8(*mut i8, usize);
    fmi3SetInt8(*const i8, usize);
    fmi3GetUInt8(*mut u8, usize);
    fmi3SetUInt8(*const u8, usize);
    fmi3GetInt16(*mut i16, usize);
    fmi3SetInt16(*const i16, usize);
    fmi3GetUInt16(*mut u16, usize);
    fmi3SetUInt16(*const u16, usize);
    fmi3GetUInt32(*mut u32, usize);
    fmi3SetUInt32(*const u32, usize);
    fmi3GetBinary(*mut usize, *mut *const u8, usize);
    fmi3SetBinary(*const usize, *const *const u8, usize);
}

absent! { NO_CLOCKS;
    fmi3GetClock(*mut Boolean);
    fmi3SetClock(*const Boolean);
    fmi3GetIntervalDecimal(*mut f64, *mut c_int);
    fmi3GetIntervalFraction(*mut u64, *mut u64, *mut c_int);
    fmi3GetShiftDecimal(*mut f64);
    fmi3GetShiftFraction(*mut u64, *mut u64);
    fmi3SetIntervalDecimal(*const f64);
    fmi3SetIntervalFraction(*const u64, *const u64);
    fmi3SetShiftDecimal(*const f64);
    fmi3SetShiftFraction(*const u64, *const u64);
}

absent! { NO_DERIVATIVES;
    fmi3GetDirectionalDerivative(
        *const ValueReference, usize, *const f64, usize, *mut f64, usize);
    fmi3GetAdjointDerivative(
        *const ValueReference, usize, *const f64, usize, *mut f64, usize);
}

refused! { NO_DEPENDENCIES;
    fmi3GetNumberOfVariableDependencies(ValueReference, *mut usize);
    fmi3GetVariableDependencies(
        ValueReference, *mut usize, *mut ValueReference, *mut usize, *mut c_int, usize);
}

refused! { CO_SIMULATION_ONLY;
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(Boolean, *mut Boolean, *mut Boolean);
    fmi3SetTime(f64);
    fmi3SetContinuousStates(*const f64, usize);
    fmi3GetContinuousStateDerivatives(*mut f64, usize);
    fmi3GetEventIndicators(*mut f64, usize);
    fmi3GetContinuousStates(*mut f64, usize);
    fmi3GetNominalsOfContinuousStates(*mut f64, usize);
    fmi3GetNumberOfEventIndicators(*mut usize);
    fmi3GetNumberOfContinuousStates(*mut usize);
    fmi3ActivateModelPartition(ValueReference, f64);
}
