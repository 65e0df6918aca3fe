//! Bounded nonlinear least squares, ordinary and generalised.
//!
//! ```text
//! Problem (residuals, Jacobian) [-> shared_errors] -> trust_region / multi_start -> Solution
//! ```
//!
//! Nothing here knows what the residuals come from. Everything is deterministic: the same problem,
//! start and options give the same evaluations in the same order, so that a fit can be replayed from
//! a cache of runs.

mod coleman_li;
mod correction;
pub mod multi_start;
mod options;
pub mod problem;
pub mod products;
pub mod shared_errors;
pub mod solution;
mod step;
pub(crate) mod subproblem;
pub mod trust_region;

pub use multi_start::{MultiStart, MultiStartOptions, StartRecord};
pub use options::{Options, Scaling};
pub use problem::{Bounds, EvaluationFailure, FitError, Problem};
pub use shared_errors::{Prior, SharedErrors, SharedNoise, Whitening, likeliest_heights};
pub use solution::{IterationRecord, Solution, StopReason};
pub use trust_region::minimise;
