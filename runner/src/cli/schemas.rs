//! `runner schema`: the JSON schemas of what is written and read, from the types themselves.

use super::{CliResult, Ending, job, program};
use crate::diagnosis::result::Diagnosis;
use crate::inspection::Inspection;
use crate::report::FitReport;
use crate::study::report::PopulationReport;
use crate::study::status::Status;
use crate::study::{Unit, UnitResult};
use clap::{Args, ValueEnum};
use serde_json::Value;

/// Print the JSON schema of a result or of a job file.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Of what
    #[arg(value_enum)]
    what: What,
}

/// What has a schema.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum What {
    /// poropunch.toml
    Job,
    /// result.json of `identify`
    Result,
    /// diagnosis.json of `diagnose`
    Diagnosis,
    /// inspection.json of `inspect`
    Inspection,
    /// What `simulate --json` prints
    Simulation,
    /// What `validate --json` prints
    Validation,
    /// What `batch --json` prints
    Batch,
    /// A line of units.jsonl of `study plan`
    StudyUnit,
    /// A unit's result of `study work`
    StudyResult,
    /// What `study status --json` prints
    StudyStatus,
    /// population.json of `study gather`
    StudyPopulation,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> CliResult {
    let text = serde_json::to_string_pretty(&of(arguments.what))?;
    // As it is: JSON must not be wrapped.
    let _ = std::io::Write::write_all(&mut std::io::stdout(), format!("{text}\n").as_bytes());
    Ok(Ending::Complete)
}

fn of(what: What) -> Value {
    let schema = match what {
        What::Job => return job::schema(&program()),
        What::Result => schemars::schema_for!(FitReport),
        What::Diagnosis => schemars::schema_for!(Diagnosis),
        What::Inspection => schemars::schema_for!(Inspection),
        What::Simulation => schemars::schema_for!(super::simulate::Simulation),
        What::Validation => schemars::schema_for!(super::validate::Validation),
        What::Batch => schemars::schema_for!(super::batch::Batch),
        What::StudyUnit => schemars::schema_for!(Unit),
        What::StudyResult => schemars::schema_for!(UnitResult),
        What::StudyStatus => schemars::schema_for!(Status),
        What::StudyPopulation => schemars::schema_for!(PopulationReport),
    };
    schema.to_value()
}
