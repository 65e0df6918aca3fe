//! Saved states, alike in FMI 2.0 and 3.0 but for the functions' names.
#![allow(unsafe_code)]

use super::FmiError;
use super::core::{Component, Core};
use libloading::Library;
use std::ffi::{c_int, c_void};

/// `fmi2FMUstate`, `fmi3FMUState`.
pub type State = *mut c_void;

/// A saved state; free it with [`FmuInstance::free_state`](super::FmuInstance::free_state), or it lives as long as the instance.
#[derive(Debug)]
pub struct FmuState(State);

// SAFETY: an opaque handle, only used through its instance.
unsafe impl Send for FmuState {}

/// Names of the functions for states.
#[derive(Clone, Copy)]
pub struct StateNames {
    /// Of saving, restoring and freeing.
    pub handles: [&'static str; 3],
    /// Of the size in bytes, of writing and of reading.
    pub bytes: [&'static str; 3],
}

/// Those functions, as far as the library has them.
#[derive(Clone, Copy)]
pub struct StateFunctions {
    names: StateNames,
    save: Option<unsafe extern "C" fn(Component, *mut State) -> c_int>,
    restore: Option<unsafe extern "C" fn(Component, State) -> c_int>,
    free: Option<unsafe extern "C" fn(Component, *mut State) -> c_int>,
    size: Option<unsafe extern "C" fn(Component, State, *mut usize) -> c_int>,
    write: Option<unsafe extern "C" fn(Component, State, *mut u8, usize) -> c_int>,
    read: Option<unsafe extern "C" fn(Component, *const u8, usize, *mut State) -> c_int>,
}

impl StateFunctions {
    /// Looks them up.
    ///
    /// # Safety
    /// The library's functions of these names have the signatures of the FMI headers; it stays loaded while they are used.
    pub unsafe fn of(library: &Library, names: StateNames) -> Self {
        /// A function, where there is one.
        unsafe fn find<T: Copy>(library: &Library, name: &str) -> Option<T> {
            // SAFETY: the caller's promise.
            unsafe { library.get::<T>(name) }.ok().map(|symbol| *symbol)
        }
        let StateNames { handles: [save, restore, free], bytes: [size, write, read] } = names;
        // SAFETY: the caller's promise.
        unsafe {
            Self {
                names,
                save: find(library, save),
                restore: find(library, restore),
                free: find(library, free),
                size: find(library, size),
                write: find(library, write),
                read: find(library, read),
            }
        }
    }
}

impl Core {
    /// Saves the present state.
    pub fn get_state(&self) -> Result<FmuState, FmiError> {
        let save = self.states.save.filter(|_| self.description.capabilities.get_and_set_state);
        let save = save.ok_or(FmiError::NotSupported("save its state"))?;
        let mut state = std::ptr::null_mut();
        // SAFETY: a live component of this library; NULL asks for a new state.
        let status = unsafe { save(self.component, &raw mut state) };
        self.messages.check(self.states.names.handles[0], status)?;
        Ok(FmuState(state))
    }

    /// Returns to a saved state.
    pub fn set_state(&self, state: &FmuState) -> Result<(), FmiError> {
        let restore = self.states.restore.ok_or(FmiError::NotSupported("restore its state"))?;
        // SAFETY: a live component of this library and a state it made.
        let status = unsafe { restore(self.component, state.0) };
        self.messages.check(self.states.names.handles[1], status)
    }

    /// Frees a saved state.
    pub fn free_state(&self, mut state: FmuState) -> Result<(), FmiError> {
        let free = self.states.free.ok_or(FmiError::NotSupported("free its state"))?;
        // SAFETY: a live component of this library and a state it made.
        let status = unsafe { free(self.component, &raw mut state.0) };
        self.messages.check(self.states.names.handles[2], status)
    }

    /// A saved state as bytes.
    pub fn serialize_state(&self, state: &FmuState) -> Result<Vec<u8>, FmiError> {
        let missing = FmiError::NotSupported("serialise its state");
        let (Some(size_of), Some(write)) = (self.states.size, self.states.write) else {
            return Err(missing);
        };
        let mut size = 0;
        // SAFETY: a live component of this library and a state it made.
        let status = unsafe { size_of(self.component, state.0, &raw mut size) };
        self.messages.check(self.states.names.bytes[0], status)?;
        let mut bytes = vec![0; size];
        // SAFETY: the buffer has the size the FMU asked for.
        let status = unsafe { write(self.component, state.0, bytes.as_mut_ptr(), size) };
        self.messages.check(self.states.names.bytes[1], status)?;
        Ok(bytes)
    }

    /// A state from bytes.
    pub fn deserialize_state(&self, bytes: &[u8]) -> Result<FmuState, FmiError> {
        let read = self.states.read.ok_or(FmiError::NotSupported("deserialise its state"))?;
        let mut state = std::ptr::null_mut();
        // SAFETY: a live component of this library; the buffer has the stated length.
        let status = unsafe { read(self.component, bytes.as_ptr(), bytes.len(), &raw mut state) };
        self.messages.check(self.states.names.bytes[2], status)?;
        Ok(FmuState(state))
    }
}
