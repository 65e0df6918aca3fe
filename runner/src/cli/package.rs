//! `runner package`: the FMU archive, checked.

use super::{CliResult, Ending};
use crate::fmi::{PLATFORM, Version, builtin_library};
use crate::package::{Binary, Problems, lint, write_archive};
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
    /// A library for another platform, or instead of this machine's own: linux64, win64, darwin64, aarch64-linux
    /// (repeatable; cdylib/build-all builds them all)
    #[arg(long = "binary", value_name = "PLATFORM=FILE")]
    binaries: Vec<Binary>,
    /// Check this archive, to be given away, instead of writing one
    #[arg(long, value_name = "FILE", conflicts_with_all = ["out", "binaries"])]
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
        let mut binaries = arguments.binaries.clone();
        if !binaries.iter().any(|binary| binary.platform.folder == PLATFORM) {
            binaries.push(Binary::of_this_machine(builtin_library()?));
        }
        write_archive(version, file, &binaries)?;
        say!("wrote {}", file.display());
    }
    let Problems { own: mut problems, elsewhere } = lint(file)?;
    // What cargo builds for this machine alone need not serve another.
    let for_this_machine = arguments.check.is_none() && arguments.binaries.is_empty();
    if !for_this_machine {
        problems.extend(elsewhere);
    } else if !elsewhere.is_empty() {
        say!("for machines like this one; cdylib/build-all makes one for all");
    }
    if problems.is_empty() {
        say!("checked: no problems");
        return Ok(Ending::Complete);
    }
    Err(format!("{}: {} problems:\n  {}", file.display(), problems.len(), problems.join("\n  ")).into())
}
