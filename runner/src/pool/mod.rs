//! Many runs of the FMU at a time: one worker thread, one instance each.
//!
//! ```text
//! Job -> submit -> Run (a handle, at once) ... worker: Simulator::run ... -> wait -> ForceCurve or RunFailure
//! ```
//! Two queues: what the optimiser waits for goes before what it will probably need. A run that nobody waits
//! for any more (its handle was dropped) is skipped, or stopped between two steps when it already runs.

pub mod fmu_simulator;
pub mod job;
pub mod load;
pub mod run;
pub mod side_by_side;
pub mod wiring;
pub mod workers;

pub use fmu_simulator::FmuSimulator;
pub use job::{ForceCurve, Job, Outcome, RunFailure};
pub use run::Run;
pub use side_by_side::side_by_side;
pub use wiring::{Port, Wiring, WiringError};
pub use workers::{Pool, Priority, Simulator};
