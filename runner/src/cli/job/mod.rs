//! Job files: what a command line says, in a file that can be kept, shared and repeated.
//!
//! ```text
//! poropunch.toml -> Job (fields, lines) -> words --+
//!                            the user's own words --+-> clap -> arguments -> the command
//!                                                          -> Kept -> poropunch.toml beside the results
//! ```
//! The options of the command line are the fields: what clap checks of the one holds for the other.

mod error;
mod file;
mod keep;
mod place;
mod schema;

pub use error::JobError;
pub use file::Job;
pub use keep::Kept;
pub use place::COMMANDS;
pub use schema::schema;

use self::place::given_command;
use crate::output::{Folder, write_file};
use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Name of the file that is kept beside results.
pub const FILE: &str = "poropunch.toml";

/// The option that names a job file.
#[derive(Debug, Clone, Default, Args)]
pub struct JobArguments {
    /// Job file (TOML): measurements, columns, geometry, parameters, outputs. What stands on the command line wins over what stands
    /// in it. Each run keeps the one that repeats it beside its results
    #[arg(long, value_name = "FILE")]
    pub job: Option<PathBuf>,
}

/// What was asked for, and whether to stop.
#[derive(Debug)]
pub struct Invocation {
    /// Raised when the user stops the program.
    pub stop: Arc<AtomicBool>,
    kept: Kept,
    /// The job file it came from.
    job: Option<Job>,
    /// The first field in which it differs from that file.
    difference: Option<String>,
}

/// The command line with what the job file adds to it.
#[derive(Debug)]
pub struct Expanded {
    /// All words.
    pub words: Vec<String>,
    job: Option<Job>,
    /// What the words mean to a run that is resumed, and what it was begun with.
    resumed: bool,
}

impl Expanded {
    /// Adds to the words what the job file says, that of `--resume` included; words of the command line win.
    ///
    /// # Errors
    /// When the job file cannot be used.
    pub fn new(program: &Command, words: Vec<String>) -> Result<Self, JobError> {
        // Only to see what is there: what is wrong with it is told when everything is together.
        let probe = forgiving(program.clone()).try_get_matches_from(&words).ok();
        let found = probe.as_ref().and_then(given_command);
        let found = found.filter(|(name, _)| COMMANDS.contains(&name.as_str()));
        let Some((name, matches)) = found else { return Ok(Self { words, job: None, resumed: false }) };
        let resumed = matches.try_get_one::<bool>("resume").ok().flatten().copied().unwrap_or(false);
        let path = |id: &str| matches.try_get_one::<PathBuf>(id).ok().flatten().cloned();
        let asked = path("job");
        let file = if resumed { path("out").map(|out| out.join(FILE)) } else { asked };
        let Some(file) = file else { return Ok(Self { words, job: None, resumed }) };
        if resumed && !file.exists() {
            let directory = file.parent().unwrap_or(Path::new(".")).to_owned();
            return Err(JobError::NothingToResume { directory });
        }
        let job = match Job::load(&file, program, &name) {
            Err(changed @ (JobError::Changed { .. } | JobError::Data(_))) => return Err(changed),
            Err(error) if resumed => return Err(JobError::Damaged(Box::new(error))),
            other => other?,
        };
        Ok(Self { words: together(&job, &name, matches, words, resumed), job: Some(job), resumed })
    }

    /// The complaint about a word of the job file.
    pub fn explained(&self, error: &clap::Error) -> Option<JobError> {
        self.job.as_ref()?.explained(error)
    }

    /// What the command is run with.
    ///
    /// # Errors
    /// When a resumed run is asked for something else than it was begun with.
    pub fn invocation(
        self,
        program: &Command,
        matches: &ArgMatches,
        stop: Arc<AtomicBool>,
    ) -> Result<Invocation, JobError> {
        let (name, given) = given_command(matches).unwrap_or_else(|| (String::new(), matches));
        let kept = Kept::of(program, &name, given);
        let mut difference = None;
        if let Some(job) = &self.job {
            let begun = std::iter::once(program.get_name()).chain(name.split(' ')).map(str::to_owned);
            let words = job.entries.iter().flat_map(|e| e.words.iter().cloned());
            let words: Vec<String> = begun.chain(in_order(words.collect())).collect();
            let said = forgiving(program.clone()).try_get_matches_from(words).ok();
            let said = said.as_ref().and_then(given_command).map(|(name, m)| Kept::of(program, &name, m));
            difference = said.and_then(|said| said.difference(&kept));
        }
        if let (true, Some(what)) = (self.resumed, &difference) {
            return Err(JobError::Differs { what: format!("`{what}`") });
        }
        Ok(Invocation { stop, kept, job: self.job, difference })
    }
}

/// The same program, which says what it understood whatever is wrong with the rest; in steps of a command, too.
fn forgiving(command: Command) -> Command {
    command.ignore_errors(true).mut_subcommands(forgiving)
}

/// Words of the job file that the command line does not replace, and those of the command line.
fn together(job: &Job, name: &str, matches: &ArgMatches, words: Vec<String>, resumed: bool) -> Vec<String> {
    let is_given = |id: &str| matches.value_source(id) == Some(ValueSource::CommandLine);
    let names = |id: &str| -> Vec<String> {
        let raw = matches.get_raw(id).into_iter().flatten().map(|v| v.to_string_lossy().into_owned());
        raw.map(|v| v.split('=').next().unwrap_or_default().trim().to_owned()).collect()
    };
    let stays = |e: &&file::Entry| match &e.name {
        _ if !is_given(&e.place.id) => true,
        Some(name) => !names(&e.place.id).contains(name),
        None => false,
    };
    // Where a run goes on is where it was begun.
    let is_elsewhere = |e: &&file::Entry| resumed && e.place.is_output;
    let added = job.entries.iter().filter(stays).filter(|e| !is_elsewhere(e));
    let added = in_order(added.flat_map(|e| e.words.iter().cloned()).collect());
    let split = added.iter().position(|w| w == "--").unwrap_or(added.len());
    let (options, positions) = added.split_at(split);
    // The program's name, the command and what the user gave it; options may stand before the command, too.
    let after =
        |at: usize, word: &str| words.iter().skip(at).position(|w| w == word).map_or(at, |i| at + i + 1);
    let at = name.split(' ').fold(1, after);
    let (head, tail) = words.split_at(at.min(words.len()));
    [head, options, tail, positions].concat()
}

/// Options first, then what is told by its position.
fn in_order(words: Vec<String>) -> Vec<String> {
    let (options, positions): (Vec<String>, Vec<String>) =
        words.into_iter().partition(|w| w.starts_with("--"));
    if positions.is_empty() {
        return options;
    }
    options.into_iter().chain(["--".to_owned()]).chain(positions).collect()
}

impl Invocation {
    /// The command line that asks for the same.
    pub fn command(&self) -> String {
        self.kept.command_line()
    }

    /// Fields of the job file that the command does not use.
    pub fn unused(&self) -> Option<String> {
        let job = self.job.as_ref().filter(|j| !j.unused.is_empty())?;
        Some(format!("{}: not used by this command: {}", job.file.display(), job.unused.join(", ")))
    }

    /// An error with the place in the job file that it is about, if there is one.
    pub fn located(&self, error: &dyn std::error::Error) -> Option<JobError> {
        self.job.as_ref()?.located(&error.to_string())
    }

    /// Keeps the job file that repeats the command in the directory of its results.
    ///
    /// # Errors
    /// When it cannot be written, or a measurement can no longer be read.
    pub fn keep(&self, folder: &Folder) -> Result<(), JobError> {
        let text = self.kept.text(&folder.path().join(FILE))?;
        if !self.is_there(&folder.path().join(FILE)) {
            folder.write(FILE, text.as_bytes())?;
        }
        Ok(())
    }

    /// The same beside single files of results.
    ///
    /// # Errors
    /// As [`Self::keep`].
    pub fn keep_as(&self, file: &Path) -> Result<(), JobError> {
        let text = self.kept.text(file)?;
        if !self.is_there(file) {
            write_file(file, text.as_bytes())?;
        }
        Ok(())
    }

    /// Whether the job file that was read is at that place, and says the same.
    fn is_there(&self, file: &Path) -> bool {
        let same =
            |a: &Path, b: &Path| a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b));
        self.difference.is_none() && self.job.as_ref().is_some_and(|job| same(&job.file, file))
    }
}
