//! The state machine of a co-simulation slave (FMI 2.0.5, section 4.2.4).

/// Where a slave is in its life.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// After `fmi2Instantiate` or `fmi2Reset`.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// Ready for the next step.
    StepComplete,
    /// A step or the initialisation failed.
    Error,
    /// After `fmi2Terminate`.
    Terminated,
}

/// Set of phases in which a function may be called.
pub type Allowed = &'static [Phase];

use Phase::{Error, Initialization, Instantiated, StepComplete, Terminated};

/// State functions, Reset, Free, SetDebugLogging.
pub const ANY: Allowed = &[Instantiated, Initialization, StepComplete, Error, Terminated];
/// SetupExperiment and EnterInitializationMode.
pub const INSTANTIATED: Allowed = &[Instantiated];
/// ExitInitializationMode.
pub const INITIALIZATION: Allowed = &[Initialization];
/// DoStep, Terminate.
pub const STEP_COMPLETE: Allowed = &[StepComplete];
/// Set functions.
pub const SETTABLE: Allowed = &[Instantiated, Initialization, StepComplete];
/// Get functions.
pub const GETTABLE: Allowed = &[Initialization, StepComplete, Error, Terminated];
/// Status and output derivatives.
pub const AFTER_START: Allowed = &[StepComplete, Error, Terminated];
