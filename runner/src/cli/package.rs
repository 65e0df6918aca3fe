//! `runner package`: the FMU archive, checked.

use super::{CliResult, Ending};
use crate::fmi::builtin_library;
use crate::package::{lint, write_archive};
use clap::Args;
use std::path::PathBuf;

/// Write the FMU archive, and check it.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Where to write
    #[arg(long, short, value_name = "FILE", default_value = "poropunch.fmu")]
    out: PathBuf,
    /// Check this archive instead of writing one
    #[arg(long, value_name = "FILE", conflicts_with = "out")]
    check: Option<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> CliResult {
    let file = arguments.check.as_ref().unwrap_or(&arguments.out);
    if arguments.check.is_none() {
        write_archive(file, &builtin_library()?)?;
        say!("wrote {}", file.display());
    }
    let problems = lint(file)?;
    if problems.is_empty() {
        say!("checked: no problems");
        return Ok(Ending::Complete);
    }
    Err(format!("{}: {} problems:\n  {}", file.display(), problems.len(), problems.join("\n  ")).into())
}
