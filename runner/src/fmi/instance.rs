//! One instance of an FMU, whatever the version of FMI.

use super::core::Core;
use super::states::FmuState;
use super::{FmiError, Fmu, ModelDescription};

/// Declares what every version of FMI does, and the same for users.
macro_rules! face {
    ($($(#[$doc:meta])+ $name:ident($($argument:ident: $type:ty),*) -> $result:ty;)+) => {
        /// An instance behind one version of FMI.
        pub trait Face: Send {
            /// What it consists of in every version.
            fn core(&self) -> &Core;

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

/// What every version does alike, for users.
macro_rules! alike {
    ($($(#[$doc:meta])+ $name:ident($($argument:ident: $type:ty),*) -> $result:ty;)+) => {
        impl FmuInstance {
            $($(#[$doc])+
            ///
            /// # Errors
            /// As the FMU says, or when it cannot.
            pub fn $name(&mut self, $($argument: $type),*) -> Result<$result, FmiError> {
                self.face.core().$name($($argument),*)
            })+
        }
    };
}

alike! {
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
}

/// One instance. Send: it may move between threads, but is used by one at a time.
pub struct FmuInstance {
    face: Box<dyn Face>,
}

impl FmuInstance {
    pub(super) fn new(fmu: &Fmu, name: &str) -> Result<Self, FmiError> {
        Ok(Self { face: fmu.face(name)? })
    }

    /// The FMU's description.
    pub fn description(&self) -> &ModelDescription {
        &self.face.core().description
    }

    /// Messages logged since the last call or error.
    pub fn take_messages(&self) -> Vec<String> {
        self.face.core().messages.take()
    }
}
