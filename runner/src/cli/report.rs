//! `runner report`: the views of an earlier identification again.

use super::{CliResult, Ending};
use crate::output::write_file;
use crate::report::{FitReport, SCHEMA, curves_csv, page, parameters_csv, table};
use clap::Args;
use std::path::{Path, PathBuf};

/// Render the HTML page of an earlier identification again.
#[derive(Debug, Args)]
pub struct Arguments {
    /// result.json of an identification
    #[arg(value_name = "RESULT")]
    result: PathBuf,
    /// Directory to write to [default: that of RESULT]
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> CliResult {
    let file = &arguments.result;
    let fail = |reason: String| format!("{}: {reason}", file.display());
    let text = std::fs::read_to_string(file).map_err(|e| fail(e.to_string()))?;
    let wrong = |e: serde_json::Error| fail(format!("is not a result of schema {SCHEMA}: {e}"));
    let report: FitReport = serde_json::from_str(&text).map_err(wrong)?;
    if report.schema != SCHEMA {
        return Err(fail(format!("is of schema {}, this program reads {SCHEMA}", report.schema)).into());
    }
    let beside = file.parent().unwrap_or(Path::new("")).to_owned();
    write_views(&report, arguments.out.as_ref().unwrap_or(&beside))?;
    Ok(Ending::Complete)
}

/// Writes result.json, parameters.csv, curves.csv and report.html, and prints the table.
pub(super) fn write_views(report: &FitReport, directory: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let json = serde_json::to_string_pretty(report)?;
    let views = [
        ("result.json", json),
        ("parameters.csv", parameters_csv(report)),
        ("curves.csv", curves_csv(report)),
        ("report.html", page(report)),
    ];
    for (name, text) in &views {
        write_file(&directory.join(name), text.as_bytes())?;
    }
    say!("{}", table(report));
    say!("wrote result.json, parameters.csv, curves.csv and report.html to {}", directory.display());
    Ok(())
}
