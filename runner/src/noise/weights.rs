//! What the user wants the points to be weighed by.

use crate::data::Phase;
use clap::ValueEnum;
use std::collections::BTreeMap;

/// Which uncertainty weighs the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Uncertainty {
    /// Specimens if the file has at least three, else its spread, else the noise between neighbouring samples.
    #[default]
    Auto,
    /// Noise and differences of the file's specimens.
    Specimens,
    /// The file's spread per point (of the mean if `--specimens` tells how many there were).
    Spread,
    /// None: the plain sum of squared differences of Eq. 16.
    None,
}

/// How the points are weighed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Weights {
    /// Which uncertainty.
    pub uncertainty: Uncertainty,
    /// Number of specimens behind the spread, where the file does not hold them.
    pub specimens: Option<usize>,
    /// Weight of each phase; 1 where absent, 0 leaves the phase out.
    pub phases: BTreeMap<Phase, f64>,
}

impl Weights {
    /// Weight of a phase.
    pub fn of(&self, phase: Phase) -> f64 {
        self.phases.get(&phase).copied().unwrap_or(1.0)
    }
}
