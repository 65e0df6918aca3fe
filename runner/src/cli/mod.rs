//! The command line.

/// Says a text of the result.
macro_rules! say {
    ($($part:tt)*) => { $crate::cli::terminal::text(&format!($($part)*)) };
}

mod assumed;
mod batch;
mod challenge;
pub(crate) mod count;
mod diagnose;
pub mod engine_args;
mod exit;
mod fields;
mod heading;
mod identify;
mod idle;
mod inspect;
pub mod job;
mod manual;
mod package;
mod parameter_sets;
mod plots;
mod progress;
pub mod protocols;
mod report;
mod schemas;
mod simulate;
mod study;
pub(crate) mod terminal;
mod um_bridge;
mod validate;

use self::job::{Expanded, Invocation, JobError};
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
#[command(name = "runner", version, propagate_version = true, max_term_width = 80, after_help = exit::HELP)]
struct Cli {
    #[command(flatten)]
    speech: terminal::Speech,
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
    #[command(subcommand)]
    Challenge(challenge::Step),
    /// Score given parameters against measurements, without fitting.
    Validate(validate::Arguments),
    /// Run many parameter sets in parallel.
    Batch(batch::Arguments),
    /// Ask the same of many specimens, on this machine or on a cluster.
    #[command(subcommand)]
    Study(Box<study::Step>),
    /// Serve the model to samplers that speak UM-Bridge: parameters in, force and derivatives out.
    UmBridge(um_bridge::Arguments),
    /// Render the HTML page of an earlier identification again.
    Report(report::Arguments),
    /// Write the FMU archive, and check it.
    Package(package::Arguments),
    /// Print a script that completes the command line in a shell.
    Completions(manual::Completions),
    /// Write manual pages.
    Man(manual::Man),
    /// Print the JSON schema of a result or of a job file.
    Schema(schemas::Arguments),
}

/// What the program was called as, in what is to be typed again: its own name, or that of the Python package.
pub(crate) fn called() -> &'static str {
    const PACKAGE: &str = "poropunch";
    let name = std::env::args_os().next().map(std::path::PathBuf::from);
    let is_package = name.as_deref().and_then(std::path::Path::file_stem).is_some_and(|stem| stem == PACKAGE);
    if is_package { PACKAGE } else { "runner" }
}

/// The program's commands and options.
pub(crate) fn program() -> clap::Command {
    // The list of parameters comes from the variable table, so it is added when the program runs.
    let help = format!("{}\n\n{}", engine_args::parameter_help(), exit::HELP);
    let mut command = Cli::command();
    for name in ["simulate", "identify", "diagnose", "validate", "batch", "um-bridge"] {
        command = command.mut_subcommand(name, |c| c.after_long_help(help.clone()));
    }
    // Builds the options that all commands share into each of them.
    command.build();
    command
}

/// Runs the command line; what the program's `main` returns.
pub fn main() -> ExitCode {
    crate::study::work::follow_worker();
    // Names go into reports, JSON and the FMU, which are UTF-8.
    if let Some(bad) = std::env::args_os().find(|a| a.to_str().is_none()) {
        let bad = bad.to_string_lossy();
        terminal::error(&format!("the argument `{bad}` is not UTF-8; rename the file or directory"));
        return ExitCode::from(exit::USAGE);
    }
    match parsed() {
        Ok((cli, call)) => ended(run(&cli, &call), &call),
        Err(error) => {
            terminal::error(&error.to_string());
            ExitCode::from(exit::code_of(&error))
        }
    }
}

/// What the command line and its job file ask for; does not return where they ask for help or clap refuses them.
fn parsed() -> Result<(Cli, Invocation), JobError> {
    let program = program();
    let expanded = Expanded::new(&program, std::env::args().collect())?;
    let matches = match program.clone().try_get_matches_from(&expanded.words) {
        Ok(matches) => matches,
        Err(error) => return Err(expanded.explained(&error).unwrap_or_else(|| error.exit())),
    };
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    terminal::choose(cli.speech);
    let stop = Arc::new(AtomicBool::new(false));
    stop_on_ctrl_c(&stop);
    let call = expanded.invocation(&program, &matches, stop)?;
    Ok((cli, call))
}

fn run(cli: &Cli, call: &Invocation) -> CliResult {
    if let Some(unused) = call.unused() {
        terminal::note(&unused);
    }
    match &cli.command {
        Command::Simulate(arguments) => simulate::run(arguments, call),
        Command::Inspect(arguments) => inspect::run(arguments, call),
        Command::Identify(arguments) => identify::run(arguments, call),
        Command::Diagnose(arguments) => diagnose::run(arguments, call),
        Command::Challenge(step) => challenge::run(step, call),
        Command::Validate(arguments) => validate::run(arguments, call),
        Command::Batch(arguments) => batch::run(arguments, call),
        Command::Study(step) => study::run(step, &call.stop),
        Command::UmBridge(arguments) => um_bridge::run(arguments, call),
        Command::Report(arguments) => report::run(arguments),
        Command::Package(arguments) => package::run(arguments),
        Command::Completions(arguments) => manual::completions(arguments),
        Command::Man(arguments) => manual::man(arguments),
        Command::Schema(arguments) => schemas::run(arguments),
    }
}

fn ended(result: CliResult, call: &Invocation) -> ExitCode {
    match result {
        Ok(Ending::Complete) => ExitCode::SUCCESS,
        Ok(Ending::NotConverged) => ExitCode::from(exit::NOT_CONVERGED),
        Ok(Ending::Interrupted) => ExitCode::from(exit::STOPPED),
        Err(error) => {
            let code = exit::code_of(error.as_ref());
            let located = (code == exit::USAGE).then(|| call.located(error.as_ref())).flatten();
            terminal::error(&located.map_or_else(|| error.to_string(), |e| e.to_string()));
            ExitCode::from(code)
        }
    }
}

/// The first Ctrl-C asks to stop; the second ends the program at once.
fn stop_on_ctrl_c(stop: &Arc<AtomicBool>) {
    let stop = Arc::clone(stop);
    let handler = move || {
        if stop.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        terminal::aside("stopping", "stopping; what is done is kept (press Ctrl-C again to end at once)");
    };
    // Without a handler Ctrl-C ends the program at once, which the run cache survives too.
    let _ = ctrlc::set_handler(handler);
}
