//! `runner completions` and `runner man`: what shells and `man` need, from the options that there are.

use super::{CliResult, Ending, called, program};
use crate::output::Folder;
use clap::Args;
use clap_complete::{Shell, generate};
use std::path::PathBuf;

/// Print a script that completes the command line in a shell.
#[derive(Debug, Args)]
pub struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Write manual pages.
#[derive(Debug, Args)]
pub struct Man {
    /// Directory for the program's page and one for each command
    #[arg(value_name = "DIR")]
    directory: PathBuf,
}

/// Prints the script.
pub fn completions(arguments: &Completions) -> CliResult {
    let mut script = Vec::new();
    generate(arguments.shell, &mut program(), called(), &mut script);
    // As it is: a script must not be wrapped.
    let _ = std::io::Write::write_all(&mut std::io::stdout(), &script);
    Ok(Ending::Complete)
}

/// Writes the pages.
pub fn man(arguments: &Man) -> CliResult {
    let folder = Folder::begin(&arguments.directory, "man")?;
    let mut pages = Vec::new();
    collect(program().disable_help_subcommand(true), called(), &mut pages)?;
    for (name, text) in &pages {
        folder.write(&format!("{name}.1"), text)?;
    }
    say!("wrote {} pages to {}", pages.len(), folder.path().display());
    Ok(Ending::Complete)
}

fn collect(command: clap::Command, name: &str, pages: &mut Vec<(String, Vec<u8>)>) -> std::io::Result<()> {
    for inner in command.get_subcommands().filter(|c| c.get_name() != "help") {
        let full = format!("{name}-{}", inner.get_name());
        collect(inner.clone().disable_help_subcommand(true), &full, pages)?;
    }
    let mut text = Vec::new();
    clap_mangen::Man::new(command.name(name.to_owned())).render(&mut text)?;
    pages.push((name.to_owned(), text));
    Ok(())
}
