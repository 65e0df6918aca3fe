//! `runner package`: the FMU archive, checked.

use super::{CliResult, Ending};
use crate::fmi::{Version, builtin_library};
use crate::package::{lint, write_archive_of};
use clap::Args;
use std::path::PathBuf;

/// Write the FMU archive, and check it.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Where to write [default: poropunch.fmu, with --fmi 3 poropunch-fmi3.fmu]
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Version of FMI: 2, which every master knows, or 3 with arrays, events and early return
    #[arg(long, value_name = "VERSION", value_parser = clap::value_parser!(u8).range(2..=3), default_value_t = 2)]
    fmi: u8,
    /// Check this archive instead of writing one
    #[arg(long, value_name = "FILE", conflicts_with = "out")]
    check: Option<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> CliResult {
    let (version, name) = match arguments.fmi {
        3 => (Version::Three, "poropunch-fmi3.fmu"),
        _ => (Version::Two, "poropunch.fmu"),
    };
    let default = PathBuf::from(name);
    let file = arguments.check.as_ref().or(arguments.out.as_ref()).unwrap_or(&default);
    if arguments.check.is_none() {
        write_archive_of(version, file, &builtin_library()?)?;
        say!("wrote {}", file.display());
    }
    let problems = lint(file)?;
    if problems.is_empty() {
        say!("checked: no problems");
        return Ok(Ending::Complete);
    }
    Err(format!("{}: {} problems:\n  {}", file.display(), problems.len(), problems.join("\n  ")).into())
}
