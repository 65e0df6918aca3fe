//! The model for samplers: an HTTP server that speaks UM-Bridge 1.0 (<https://um-bridge-benchmarks.readthedocs.io>).
//!
//! ```text
//! POST /Evaluate {"input": [[...]]} -> message -> ForwardModel (one instance per thread) -> {"output": [[...]]}
//! ```
//! One model, `force_mN`: the values of some parameters (SI) give the force (mN) at the times of a motion.

mod forward;
mod message;
mod server;
#[cfg(test)]
mod tests;

pub use forward::{Config, ForwardModel, Worker};
pub use message::{NAME, Refusal, answer};
pub use server::{ServerError, serve};
