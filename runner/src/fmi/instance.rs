//! One instance of an FMU, whatever the version of FMI.

use super::binary2::State;
use super::{FmiError, Fmu, ModelDescription};
use std::ffi::{CString, c_int};
use std::sync::{Arc, Mutex, PoisonError};

/// Messages of an instance; the FMU's logger callback writes here.
#[derive(Default)]
pub struct Messages(Mutex<Vec<String>>);

impl Messages {
    /// One more.
    pub fn push(&self, message: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    }

    /// All of them; none is left.
    pub fn take(&self) -> Vec<String> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Why the last call failed.
    pub fn reason(&self) -> String {
        let messages = self.take();
        if messages.is_empty() { "the FMU gave no reason".to_owned() } else { messages.join("; ") }
    }

    /// Turns a status into a result: warnings pass, anything worse carries the logged messages.
    pub fn check(&self, function: &'static str, status: c_int) -> Result<(), FmiError> {
        let status = match status {
            0 | 1 => return Ok(()),
            2 => "discarded".to_owned(),
            3 => "error".to_owned(),
            4 => "fatal error".to_owned(),
            other => format!("status {other}"),
        };
        Err(FmiError::Call { function, status, messages: self.reason() })
    }
}

/// A saved state; free it with [`FmuInstance::free_state`], or it lives as long as the instance.
#[derive(Debug)]
pub struct FmuState(pub(super) State);

// SAFETY: an opaque handle, only used through its instance.
#[allow(unsafe_code)]
unsafe impl Send for FmuState {}

/// A C string.
pub fn c_text(text: &str) -> Result<CString, FmiError> {
    CString::new(text).map_err(|_| FmiError::Refused(format!("`{text}` contains a zero byte")))
}

/// Declares what every version of FMI does, and the same for users.
macro_rules! face {
    ($($(#[$doc:meta])+ $name:ident($($argument:ident: $type:ty),*) -> $result:ty;)+) => {
        /// An instance behind one version of FMI.
        pub trait Face: Send {
            /// What it logged.
            fn messages(&self) -> &Messages;

            $($(#[$doc])+
            fn $name(&mut self, $($argument: $type),*) -> Result<$result, FmiError>;)+
        }

        impl FmuInstance {
            $($(#[$doc])+
            ///
            /// # Errors
            /// As the FMU says, or when it cannot.
            pub fn $name(&mut self, $($argument: $type),*) -> Result<$result, FmiError> {
                self.face.$name($($argument),*)
            })+
        }
    };
}

face! {
    /// Start and, where known, stop time (s).
    setup_experiment(start_time: f64, stop_time: Option<f64>) -> ();
    /// Begins the initialisation.
    enter_initialization_mode() -> ();
    /// Ends the initialisation.
    exit_initialization_mode() -> ();
    /// One communication step. A discarded step is an error.
    do_step(current_time: f64, step_size: f64) -> ();
    /// Ends the simulation.
    terminate() -> ();
    /// Back to the state after instantiation, for the next parameter set.
    reset() -> ();
    /// Derivatives of inputs at the start of the next step; slices of one length.
    set_input_derivatives(references: &[u32], orders: &[i32], values: &[f64]) -> ();
    /// Saves the present state.
    get_state() -> FmuState;
    /// Returns to a saved state of this instance.
    set_state(state: &FmuState) -> ();
    /// Frees a saved state.
    free_state(state: FmuState) -> ();
    /// A saved state as bytes, for another process.
    serialize_state(state: &FmuState) -> Vec<u8>;
    /// A state from bytes.
    deserialize_state(bytes: &[u8]) -> FmuState;
    /// Values of variables.
    get_real(references: &[u32]) -> Vec<f64>;
    /// Sets variables; slices of one length.
    set_real(references: &[u32], values: &[f64]) -> ();
    /// Values of variables.
    get_integer(references: &[u32]) -> Vec<i32>;
    /// Sets variables; slices of one length.
    set_integer(references: &[u32], values: &[i32]) -> ();
    /// Values of variables.
    get_boolean(references: &[u32]) -> Vec<bool>;
    /// Sets variables; slices of one length.
    set_boolean(references: &[u32], values: &[bool]) -> ();
    /// Values of texts.
    get_string(references: &[u32]) -> Vec<String>;
    /// Sets texts; slices of one length.
    set_string(references: &[u32], values: &[&str]) -> ();
}

/// One instance. Send: it may move between threads, but is used by one at a time.
pub struct FmuInstance {
    face: Box<dyn Face>,
    description: Arc<ModelDescription>,
}

impl FmuInstance {
    pub(super) fn new(fmu: &Fmu, name: &str) -> Result<Self, FmiError> {
        Ok(Self { face: fmu.face(name)?, description: Arc::clone(fmu.shared_description()) })
    }

    /// The FMU's description.
    pub fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// Messages logged since the last call or error.
    pub fn take_messages(&self) -> Vec<String> {
        self.face.messages().take()
    }
}
