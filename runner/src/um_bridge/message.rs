//! Requests and answers of UM-Bridge 1.0.

use super::{Config, Worker};
use serde::Deserialize;
use serde_json::{Value, json};
use thiserror::Error;

/// Name of the model.
pub const NAME: &str = "force_mN";

/// Why a request has no result; the names are the protocol's.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Refusal {
    /// What was sent cannot be used.
    #[error("{0}")]
    InvalidInput(String),
    /// The model cannot be computed there.
    #[error("{0}")]
    ModelError(String),
    /// Another model.
    #[error("there is no model `{0}`; there is {NAME}")]
    ModelNotFound(String),
    /// Derivatives by parameters that have none.
    #[error("the FMU has no derivatives of the force by all of these inputs")]
    UnsupportedFeature,
    /// Another address.
    #[error(
        "there is no {0}; there are Info, InputSizes, OutputSizes, ModelInfo, Evaluate, Gradient, ApplyJacobian"
    )]
    NotFound(String),
}

impl Refusal {
    fn kind(&self) -> &'static str {
        match self {
            Self::InvalidInput(_) => "InvalidInput",
            Self::ModelError(_) => "ModelError",
            Self::ModelNotFound(_) => "ModelNotFound",
            Self::UnsupportedFeature => "UnsupportedFeature",
            Self::NotFound(_) => "NotFound",
        }
    }

    fn status(&self) -> u16 {
        match self {
            Self::ModelError(_) => 500,
            Self::NotFound(_) => 404,
            _ => 400,
        }
    }
}

/// Body of every request but `Info`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Request {
    name: String,
    #[serde(default)]
    config: Config,
    #[serde(default)]
    input: Vec<Vec<f64>>,
    #[serde(default)]
    out_wrt: usize,
    #[serde(default)]
    in_wrt: usize,
    #[serde(default)]
    sens: Vec<f64>,
    #[serde(default)]
    vec: Vec<f64>,
}

impl Request {
    /// The one input vector.
    fn input(&self) -> Result<&[f64], Refusal> {
        match self.input.as_slice() {
            [input] if self.out_wrt == 0 && self.in_wrt == 0 => Ok(input),
            _ => Err(Refusal::InvalidInput(
                "the model has one input and one output vector, number 0".to_owned(),
            )),
        }
    }
}

/// HTTP status and JSON for a request.
pub fn answer(worker: &mut Worker, path: &str, body: &str) -> (u16, Value) {
    match answered(worker, path.trim_matches('/'), body) {
        Ok(value) => (200, value),
        Err(refusal) => {
            let error = json!({ "type": refusal.kind(), "message": refusal.to_string() });
            (refusal.status(), json!({ "error": error }))
        }
    }
}

fn answered(worker: &mut Worker, path: &str, body: &str) -> Result<Value, Refusal> {
    if path == "Info" {
        return Ok(json!({ "protocolVersion": 1.0, "models": [NAME] }));
    }
    if !["InputSizes", "OutputSizes", "ModelInfo", "Evaluate", "Gradient", "ApplyJacobian"].contains(&path) {
        return Err(Refusal::NotFound(path.to_owned()));
    }
    let request: Request = serde_json::from_slice(body.as_bytes())
        .map_err(|error| Refusal::InvalidInput(format!("the body: {error}")))?;
    if request.name != NAME {
        return Err(Refusal::ModelNotFound(request.name));
    }
    let config = &request.config;
    Ok(match path {
        "InputSizes" => json!({ "inputSizes": [worker.model.parameters.len()] }),
        "OutputSizes" => json!({ "outputSizes": [worker.model.time_s.len()] }),
        "ModelInfo" => {
            let derivatives = worker.model.has_derivatives();
            json!({ "support": { "Evaluate": true, "Gradient": derivatives, "ApplyJacobian": derivatives,
                "ApplyHessian": false } })
        }
        "Gradient" => json!({ "output": worker.gradient(request.input()?, &request.sens, config)? }),
        "ApplyJacobian" => {
            json!({ "output": worker.apply_jacobian(request.input()?, &request.vec, config)? })
        }
        _ => json!({ "output": [worker.evaluate(request.input()?, config)?] }),
    })
}
