//! What is asked of every unit.

use clap::ValueEnum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is asked of every unit: a command of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Question {
    /// Material parameters of every specimen (profiles and posteriors by their options)
    #[default]
    Identify,
    /// Which effect the model lacks, of every specimen
    Diagnose,
    /// One simulation per row of a table of parameters, in chunks of rows
    Batch,
    /// The answer to every case of a folder that `challenge make` wrote
    Challenge,
}

impl Question {
    /// The command that answers it.
    pub fn command(self) -> &'static str {
        match self {
            Self::Identify => "identify",
            Self::Diagnose | Self::Challenge => "diagnose",
            Self::Batch => "batch",
        }
    }

    /// The file in the command's directory that is the answer.
    pub fn answer_file(self) -> &'static str {
        match self {
            Self::Identify => "result.json",
            Self::Diagnose | Self::Challenge => "diagnosis.json",
            Self::Batch => "summary.csv",
        }
    }

    /// Options that it is asked with unless others are given: those of `challenge answer`.
    pub fn defaults(self) -> &'static [&'static str] {
        match self {
            Self::Challenge => &["--max-evaluations=40"],
            _ => &[],
        }
    }
}
