//! Job files that cannot be used.

use crate::data::DataError;
use crate::output::OutputError;
use std::path::PathBuf;
use thiserror::Error;

/// A job file that cannot be used.
#[derive(Debug, Error)]
pub enum JobError {
    /// The file itself.
    #[error("{}: cannot be read: {source}; check the path", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// No TOML.
    #[error("{}: line {line}: {problem}; see https://toml.io for how a job file is written", file.display())]
    Syntax {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        problem: String,
    },
    /// A field.
    #[error("{}: line {line}: `{field}`: {problem}", file.display())]
    Field {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Its keys, joined by dots.
        field: String,
        /// What is wrong, and the remedy.
        problem: String,
    },
    /// A measurement that is not what it was.
    #[error(
        "{} has changed since {} was written: begin anew without --resume, or take `blake3` out of the job file",
        data.display(),
        file.display()
    )]
    Changed {
        /// The measurement.
        data: PathBuf,
        /// The job file.
        file: PathBuf,
    },
    /// Nothing to resume.
    #[error("{} has no {name}: there is nothing to resume; leave out --resume", directory.display(), name = super::FILE)]
    NothingToResume {
        /// The output directory.
        directory: PathBuf,
    },
    /// What was kept is damaged.
    #[error("{0}; begin anew without --resume (runs in the cache are kept)")]
    Damaged(Box<JobError>),
    /// The command line asks for something else.
    #[error(
        "--resume continues what was begun, but the command line differs in {what}; give the same options, or only --resume and --out"
    )]
    Differs {
        /// Which field.
        what: String,
    },
    /// A measurement that cannot be read.
    #[error(transparent)]
    Data(#[from] DataError),
    /// Writing.
    #[error(transparent)]
    Output(#[from] OutputError),
}
