//! `runner report`: the views of an earlier identification again.

use super::terminal;
use super::{CliResult, Ending};
use crate::output::{Folder, directory_of, json, protect};
use crate::report::{FitReport, SCHEMA, curves_csv, page, parameters_csv, posterior_csv, table};
use clap::Args;
use std::path::PathBuf;

/// Render the HTML page of an earlier identification again.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Directory of an identification, or its result.json
    #[arg(value_name = "DIR|RESULT")]
    result: PathBuf,
    /// Directory to write to [default: that of RESULT]
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> CliResult {
    let within = arguments.result.join(RESULT);
    let file = if arguments.result.is_dir() { &within } else { &arguments.result };
    let fail = |reason: String| format!("{}: {reason}", file.display());
    let text = std::fs::read(file).map_err(|e| fail(e.to_string()))?;
    let wrong = |e: serde_json::Error| fail(format!("is not a result of schema {SCHEMA}: {e}"));
    let report: FitReport = serde_json::from_slice(&text).map_err(wrong)?;
    if report.schema != SCHEMA {
        return Err(fail(format!("is of schema {}, this program reads {SCHEMA}", report.schema)).into());
    }
    protect(file);
    let beside = directory_of(file);
    let folder = Folder::resume(arguments.out.as_deref().unwrap_or(beside), "identify")?;
    let is_there = folder.path().join(RESULT).canonicalize().ok() == file.canonicalize().ok();
    if !is_there {
        folder.write(RESULT, &json(&folder.path().join(RESULT), &report)?)?;
    }
    write_views(&report, &folder)?;
    terminal::result(&report)?;
    Ok(Ending::Complete)
}

/// The result, from which all views are made.
pub(super) const RESULT: &str = "result.json";

/// Prints the table, and writes parameters.csv, curves.csv and report.html.
pub(super) fn write_views(report: &FitReport, folder: &Folder) -> Result<(), Box<dyn std::error::Error>> {
    say!("{}", table(report));
    let views = [
        ("parameters.csv", parameters_csv(report)),
        ("curves.csv", curves_csv(report)),
        ("report.html", page(report)),
    ];
    if let Some(posterior) = &report.posterior {
        folder.write("posterior.csv", posterior_csv(posterior).as_bytes())?;
    }
    for (name, text) in &views {
        folder.write(name, text.as_bytes())?;
    }
    say!("wrote {RESULT}, parameters.csv, curves.csv and report.html to {}", folder.path().display());
    Ok(())
}
