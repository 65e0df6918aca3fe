//! The command line.

/// Prints a line; a reader that has gone away (`| head`) is no reason to fail.
macro_rules! say {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($part)*);
    }};
}

mod assumed;
mod batch;
mod challenge;
pub(crate) mod count;
mod diagnose;
pub mod engine_args;
mod exit;
mod fields;
mod identify;
mod idle;
mod inspect;
mod kept_command;
mod package;
mod parameter_sets;
mod plots;
mod progress;
mod protocols;
mod report;
mod simulate;
mod validate;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a command may fail with: shown to the user as it is.
type CliResult = Result<Ending, Box<dyn std::error::Error>>;

/// How a command that did not fail ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ending {
    /// All done.
    Complete,
    /// Done, but the fit did not converge.
    NotConverged,
    /// Stopped by the user; what was reached is kept.
    Interrupted,
}

/// Nonlinear poro-viscoelastic indentation: simulate it, identify its material parameters.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, max_term_width = 110, after_help = exit::HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Compute the force of a protocol or of a measured motion.
    Simulate(simulate::Arguments),
    /// Show what measurements say without a model: cycles, peaks, relaxation, contact, noise.
    Inspect(inspect::Arguments),
    /// Identify material parameters from measurements.
    Identify(Box<identify::Arguments>),
    /// Tell which unmodelled effect explains the gap between the best fit and the measurements.
    Diagnose(Box<diagnose::Arguments>),
    /// Check the diagnosis on cases whose cause it does not know: make them, answer them, score the answers.
    Challenge(challenge::Arguments),
    /// Score given parameters against measurements, without fitting.
    Validate(validate::Arguments),
    /// Run many parameter sets in parallel.
    Batch(batch::Arguments),
    /// Render the HTML page of an earlier identification again.
    Report(report::Arguments),
    /// Write the FMU archive, and check it.
    Package(package::Arguments),
}

/// Runs the command line; what the program's `main` returns.
pub fn main() -> ExitCode {
    // The list of parameters comes from the variable table, so it is added when the program runs.
    let help = engine_args::parameter_help();
    let mut command = Cli::command();
    for name in ["simulate", "identify", "diagnose", "validate", "batch"] {
        let help = format!("{help}\n\n{}", exit::HELP);
        command = command.mut_subcommand(name, |c| c.after_long_help(help));
    }
    // Names go into reports, JSON and the FMU, which are UTF-8.
    if let Some(bad) = std::env::args_os().find(|a| a.to_str().is_none()) {
        eprintln!(
            "error: the argument `{}` is not UTF-8; rename the file or directory",
            bad.to_string_lossy()
        );
        return ExitCode::from(exit::USAGE);
    }
    let cli = match Cli::from_arg_matches(&command.get_matches()) {
        Ok(cli) => cli,
        Err(error) => error.exit(),
    };
    let stop = Arc::new(AtomicBool::new(false));
    stop_on_ctrl_c(&stop);
    let result = match &cli.command {
        Command::Simulate(arguments) => simulate::run(arguments, &stop),
        Command::Inspect(arguments) => inspect::run(arguments),
        Command::Identify(arguments) => identify::run(arguments, &stop),
        Command::Diagnose(arguments) => diagnose::run(arguments, &stop),
        Command::Challenge(arguments) => challenge::run(arguments, &stop),
        Command::Validate(arguments) => validate::run(arguments, &stop),
        Command::Batch(arguments) => batch::run(arguments, &stop),
        Command::Report(arguments) => report::run(arguments),
        Command::Package(arguments) => package::run(arguments),
    };
    match result {
        Ok(Ending::Complete) => ExitCode::SUCCESS,
        Ok(Ending::NotConverged) => ExitCode::from(exit::NOT_CONVERGED),
        Ok(Ending::Interrupted) => ExitCode::from(exit::STOPPED),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(exit::code_of(error.as_ref()))
        }
    }
}

/// Arguments of a diagnosis in a command line that was kept.
fn diagnose_arguments(words: &[String]) -> Option<Box<diagnose::Arguments>> {
    match Cli::try_parse_from(words).ok()?.command {
        Command::Diagnose(arguments) => Some(arguments),
        _ => None,
    }
}

/// The first Ctrl-C asks to stop; the second ends the program at once.
fn stop_on_ctrl_c(stop: &Arc<AtomicBool>) {
    let stop = Arc::clone(stop);
    let handler = move || {
        if stop.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        eprintln!("stopping; what is done is kept (press Ctrl-C again to end at once)");
    };
    // Without a handler Ctrl-C ends the program at once, which the run cache survives too.
    let _ = ctrlc::set_handler(handler);
}
