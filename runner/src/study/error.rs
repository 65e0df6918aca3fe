//! Studies that cannot be planned, worked on or gathered.

use crate::data::DataError;
use crate::output::OutputError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a study cannot go on.
#[derive(Debug, Error)]
pub enum StudyError {
    /// A file or directory.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// Something in a file that people wrote.
    #[error("{}, line {line}: {problem}", file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: u64,
        /// What is wrong with which field, and the remedy.
        problem: String,
    },
    /// A file as a whole.
    #[error("{}: {problem}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What is wrong, and the remedy.
        problem: String,
    },
    /// A unit that the plan does not have.
    #[error("the plan has no unit {number}: it has 1 to {count}")]
    NoUnit {
        /// The number that was asked for.
        number: usize,
        /// Number of units.
        count: usize,
    },
    /// The program is not the one that the plan was made with.
    #[error(
        "this program or its FMU is not the one that the plan was made with ({planned}, here {here}), and its answers could \
         differ: run that one, or plan again with this one (results of equal questions are kept apart)"
    )]
    OtherProgram {
        /// Hash in the plan.
        planned: String,
        /// Hash of this one.
        here: String,
    },
    /// The data are not those that the plan was made with.
    #[error("{} has changed since the plan was made; plan again (what did not change is not computed again)", file.display())]
    Changed {
        /// The measurement.
        file: PathBuf,
    },
    /// A measurement that cannot be read.
    #[error(transparent)]
    Data(#[from] DataError),
    /// Writing.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A command of the engine.
    #[error("{command} {problem}")]
    Engine {
        /// What was run.
        command: String,
        /// What it said.
        problem: String,
    },
}

impl StudyError {
    pub(super) fn io(file: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| Self::Io { file: file.to_owned(), source }
    }
}
