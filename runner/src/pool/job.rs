//! What is run, and what comes out of it.

use poropunch::motion::protocol::Protocol;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use thiserror::Error;

/// One simulation: everything that its result depends on, apart from the FMU itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Values of the parameters that are set (SI); the others keep the FMU's start values.
    pub parameters: BTreeMap<String, f64>,
    /// Motion of the punch.
    pub protocol: Arc<Protocol>,
    /// Times at which outputs are wanted (s), increasing, within the protocol.
    pub time_s: Arc<[f64]>,
}

/// Result of a run: force and other outputs against time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ForceCurve {
    /// Times (s).
    pub time_s: Vec<f64>,
    /// Displacement of the punch (m).
    pub displacement_m: Vec<f64>,
    /// Name of each output, the force first.
    pub names: Vec<String>,
    /// Values of each output (SI), in the order of `names`.
    pub values: Vec<Vec<f64>>,
}

impl ForceCurve {
    /// Force on the punch (N).
    pub fn force_n(&self) -> &[f64] {
        self.values.first().map_or(&[], Vec::as_slice)
    }

    /// Values of an output, if it was recorded.
    pub fn output(&self, name: &str) -> Option<&[f64]> {
        let i = self.names.iter().position(|n| n == name)?;
        self.values.get(i).map(Vec::as_slice)
    }
}

/// Why there is no curve.
#[derive(Debug, Clone, PartialEq, Eq, Error, Serialize, Deserialize)]
pub enum RunFailure {
    /// The model refused the parameters or could not make a step: the same every time.
    #[error("{0}")]
    Model(String),
    /// Something around the model failed: may work another time.
    #[error("{0}")]
    Engine(String),
    /// Nobody waits for it any more, or the user stopped the program.
    #[error("cancelled")]
    Cancelled,
}

/// How a run ended.
pub type Outcome = Result<Arc<ForceCurve>, RunFailure>;
