//! Saved states behind handles, alike in FMI 2.0 and 3.0.

use crate::component::{Component, Saved};
use crate::guard::{Outcome, bytes, write, write_each};
use std::ffi::c_void;

/// `fmi2FMUstate`, `fmi3FMUState`: here a token, never dereferenced.
pub type FmuState = *mut c_void;

const UNKNOWN_STATE: &str = "the state is not one of this instance, or is freed already";

/// The state behind a handle.
fn saved(component: &Component, state: FmuState) -> Result<&Saved, String> {
    component.states.get(&(state as usize)).ok_or_else(|| UNKNOWN_STATE.to_owned())
}

/// Copies the present state; an existing handle is overwritten, NULL gets a new one.
///
/// # Safety
/// `state` is NULL or may be read and written.
pub unsafe fn get(c: &mut Component, state: *mut FmuState) -> Outcome {
    // SAFETY: the caller's promise. The one handle that goes in and out: the standard wants a copy to be overwritten.
    let present = *unsafe { state.as_ref() }.ok_or("the pointer to the state is NULL")?;
    let saved = c.save();
    if present.is_null() {
        // SAFETY: not NULL, and the caller's promise.
        return unsafe { write(state, c.keep(saved) as FmuState) };
    }
    *c.states.get_mut(&(present as usize)).ok_or(UNKNOWN_STATE)? = saved;
    Ok(())
}

/// Back to a saved state.
pub fn set(c: &mut Component, state: FmuState) -> Outcome {
    let saved = saved(c, state)?.clone();
    c.restore(&saved)
}

/// Frees a saved state and sets the handle to NULL; NULL is ignored.
///
/// # Safety
/// `state` is NULL or may be read and written.
pub unsafe fn free(c: &mut Component, state: *mut FmuState) -> Outcome {
    // SAFETY: the caller's promise.
    let Some(state) = unsafe { state.as_mut() }.filter(|state| !state.is_null()) else { return Ok(()) };
    c.states.remove(&(*state as usize)).ok_or(UNKNOWN_STATE)?;
    *state = std::ptr::null_mut();
    Ok(())
}

/// Bytes that [`serialise`] will write.
///
/// # Safety
/// `size` is NULL or may be written.
pub unsafe fn size(c: &Component, state: FmuState, size: *mut usize) -> Outcome {
    let length = saved(c, state)?.to_bytes()?.len();
    // SAFETY: the caller's promise.
    unsafe { write(size, length) }
}

/// Writes a saved state, valid in another process.
///
/// # Safety
/// `place` is NULL or has room for `size` bytes.
pub unsafe fn serialise(c: &Component, state: FmuState, place: *mut u8, size: usize) -> Outcome {
    let written = saved(c, state)?.to_bytes()?;
    if size < written.len() {
        return Err(format!("the state needs {} bytes, the buffer has {size}", written.len()));
    }
    // SAFETY: there is room, and the caller's promise.
    unsafe { write_each(place, &written) }
}

/// Reads a saved state into a new handle; corrupt bytes are an error.
///
/// # Safety
/// `place` is NULL or holds `size` bytes, `state` is NULL or may be written.
pub unsafe fn deserialise(c: &mut Component, place: *const u8, size: usize, state: *mut FmuState) -> Outcome {
    if state.is_null() {
        return Err("the pointer to the state is NULL".to_owned());
    }
    // SAFETY: the caller's promise.
    let saved = Saved::from_bytes(unsafe { bytes(place, size) }?)?;
    // SAFETY: not NULL, and the caller's promise.
    unsafe { write(state, c.keep(saved) as FmuState) }
}

/// Defines a version's functions for states: their names differ, their arguments do not.
macro_rules! state_functions {
    (
        $get:ident, $set:ident, $free:ident, $size:ident, $serialise:ident, $deserialise:ident
    ) => {
        /// Copies the present state; an existing handle is overwritten, NULL gets a new one.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(instance: *mut c_void, state: *mut FmuState) -> Status {
            // SAFETY: see the top of this file.
            unsafe { call(instance, stringify!($get), ANY, |c| states::get(c, state)) }
        }

        /// Back to a saved state.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(instance: *mut c_void, state: FmuState) -> Status {
            // SAFETY: see the top of this file.
            unsafe { call(instance, stringify!($set), ANY, |c| states::set(c, state)) }
        }

        /// Frees a saved state and sets the handle to NULL; NULL is ignored.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $free(instance: *mut c_void, state: *mut FmuState) -> Status {
            // SAFETY: see the top of this file.
            unsafe { call(instance, stringify!($free), ANY, |c| states::free(c, state)) }
        }

        /// Bytes that the next function will write.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $size(instance: *mut c_void, state: FmuState, size: *mut usize) -> Status {
            // SAFETY: see the top of this file.
            unsafe { call(instance, stringify!($size), ANY, |c| states::size(c, state, size)) }
        }

        /// Writes a saved state, valid in another process and in the other version of FMI.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $serialise(
            instance: *mut c_void,
            state: FmuState,
            bytes: *mut u8,
            size: usize,
        ) -> Status {
            // SAFETY: see the top of this file.
            unsafe {
                call(instance, stringify!($serialise), ANY, |c| states::serialise(c, state, bytes, size))
            }
        }

        /// Reads a saved state into a new handle; corrupt bytes are an error.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $deserialise(
            instance: *mut c_void,
            serialized: *const u8,
            size: usize,
            state: *mut FmuState,
        ) -> Status {
            // SAFETY: see the top of this file.
            unsafe {
                call(instance, stringify!($deserialise), ANY, |c| {
                    states::deserialise(c, serialized, size, state)
                })
            }
        }
    };
}
pub(crate) use state_functions;
