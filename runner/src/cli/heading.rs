//! What the JSON of a run at given parameters begins with.

use super::job::Invocation;
use crate::assumption::Assumption;
use crate::engine::Engine;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Of which command, of which model, and what it rests on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Heading {
    /// Command that was given.
    pub command: String,
    /// Name and identification of the model.
    pub model: String,
    /// What it rests on: every parameter, given or assumed.
    pub assumptions: Vec<Assumption>,
}

impl Heading {
    /// Of a command's result.
    pub fn new(call: &Invocation, engine: &Engine, assumptions: Vec<Assumption>) -> Self {
        Self { command: call.command(), model: engine.model_name().to_owned(), assumptions }
    }
}
