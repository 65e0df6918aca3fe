//! Bounded nonlinear least squares, and what its result is worth.
//!
//! ```text
//! Problem (residuals, Jacobian) -> trust_region / multi_start -> Solution
//! Solution + Noise -> statistics (intervals, correlations)
//!                  -> identifiability (what the data do not determine, in words)
//!                  -> derived (combinations that they do)
//! ```
//!
//! Nothing here knows what the residuals come from. Everything is deterministic: the same problem,
//! start and options give the same evaluations in the same order, so that a fit can be replayed from
//! a cache of runs.

mod coleman_li;
pub mod derived;
pub mod identifiability;
pub mod multi_start;
pub mod parameter;
pub mod problem;
pub mod shared_errors;
pub mod solution;
pub mod statistics;
mod step;
mod subproblem;
pub mod trust_region;
pub mod wording;

pub use derived::{DerivedEstimate, DerivedQuantity, Values};
pub use identifiability::{Finding, FindingKind, Identifiability};
pub use multi_start::{MultiStart, MultiStartOptions, StartRecord};
pub use parameter::{FitParameter, Transform};
pub use problem::{Bounds, EvaluationFailure, FitError, Problem};
pub use shared_errors::{Prior, SharedErrors, SharedNoise, Whitening};
pub use solution::{IterationRecord, Solution, StopReason};
pub use statistics::{CommonError, Interval, Noise, ParameterEstimate, Statistics};
pub use trust_region::{Options, Scaling, minimise};
