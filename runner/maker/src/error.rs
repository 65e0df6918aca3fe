//! What can go wrong.

use thiserror::Error;

/// Why a test could not be simulated.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MakerError {
    /// A parameter outside of its physical range.
    #[error("{0}")]
    Invalid(&'static str),
    /// Newton's method failed even with the smallest step.
    #[error("no equilibrium found at {time_s} s with steps down to {step_s} s: {reason}")]
    NoConvergence {
        /// Time that was reached (s).
        time_s: f64,
        /// Smallest step tried (s).
        step_s: f64,
        /// What the last attempt died of.
        reason: Failure,
    },
    /// More steps than any sensible test needs.
    #[error("more than {0} attempts at a step")]
    TooManySteps(usize),
}

/// Why one step failed; a smaller one may succeed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Failure {
    /// An element turned inside out, or the solid was compacted beyond its volume fraction.
    #[error("an element is inverted or compacted")]
    Inverted,
    /// The flow rule of a branch has no solution.
    #[error("a branch's flow did not converge")]
    Flow,
    /// The tangent is singular.
    #[error("the tangent is singular")]
    Singular,
    /// Newton's method did not converge.
    #[error("Newton's method did not converge")]
    Newton,
    /// The error of the step is too large.
    #[error("the time error is too large")]
    TimeError,
}
