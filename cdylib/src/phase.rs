//! The state machine of a co-simulation slave (FMI 2.0.5, section 4.2.4; FMI 3.0, section 4.2).

/// Where a slave is in its life.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// After the instantiation or Reset.
    Instantiated,
    /// Between EnterInitializationMode and ExitInitializationMode.
    Initialization,
    /// Ready for the next step: FMI 3.0's step mode.
    StepComplete,
    /// A step or the initialisation failed.
    Error,
    /// After Terminate.
    Terminated,
    /// FMI 3.0: sizes of arrays may be set.
    Configuration,
    /// FMI 3.0: something happened at this instant.
    Event,
    /// FMI 3.0: the master is called back within a step.
    IntermediateUpdate,
}

/// Set of phases in which a function may be called.
pub type Allowed = &'static [Phase];

use Phase::{
    Configuration, Error, Event, Initialization, Instantiated, IntermediateUpdate, StepComplete, Terminated,
};

/// State functions, Reset, SetDebugLogging.
pub const ANY: Allowed =
    &[Instantiated, Configuration, Initialization, Event, StepComplete, Error, Terminated];
/// SetupExperiment, EnterInitializationMode, EnterConfigurationMode.
pub const INSTANTIATED: Allowed = &[Instantiated];
/// ExitInitializationMode.
pub const INITIALIZATION: Allowed = &[Initialization];
/// DoStep, EnterEventMode.
pub const STEP_COMPLETE: Allowed = &[StepComplete];
/// Terminate.
pub const RUNNING: Allowed = &[Event, StepComplete];
/// Set functions.
pub const SETTABLE: Allowed = &[Instantiated, Initialization, Event, StepComplete, IntermediateUpdate];
/// Sizes of arrays; before the configuration mode, too, which some masters do not know.
pub const RESIZABLE: Allowed = &[Instantiated, Configuration];
/// Get functions.
pub const GETTABLE: Allowed = &[Initialization, Event, StepComplete, IntermediateUpdate, Error, Terminated];
/// Status and output derivatives.
pub const AFTER_START: Allowed = &[Event, StepComplete, Error, Terminated];
/// ExitConfigurationMode.
pub const CONFIGURATION: Allowed = &[Configuration];
/// EnterStepMode, UpdateDiscreteStates.
pub const EVENT: Allowed = &[Event];
/// After the master was called back.
pub const INTERMEDIATE: Allowed = &[IntermediateUpdate];
