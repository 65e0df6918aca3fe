//! The command that a diagnosis was begun with, kept beside it: `--resume` repeats it from any directory, on the same data.

use super::diagnose::Arguments;
use crate::identification::{SettingsError, Source};
use crate::output::{Folder, OutputError, json};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Name of the file.
pub const FILE: &str = "command.json";
const SCHEMA: &str = "poropunch.command/1";

/// A command line with what it meant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KeptCommand {
    /// `poropunch.command/1`.
    schema: String,
    /// Words of the command line.
    pub words: Vec<String>,
    /// Directory that its relative paths start from.
    directory: PathBuf,
    /// The measurements, with absolute paths and the hashes of their contents.
    data: Vec<Source>,
}

/// A command that cannot be repeated.
#[derive(Debug, Error)]
pub enum KeptCommandError {
    /// There is none.
    #[error("{} has no diagnosis to resume ({source}); name the measurements instead", directory.display())]
    Nothing {
        /// The output directory.
        directory: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// The file is damaged.
    #[error("{}: {reason}; begin anew without --resume", file.display())]
    Damaged {
        /// The file.
        file: PathBuf,
        /// Reason.
        reason: String,
    },
    /// The measurements.
    #[error(transparent)]
    Data(#[from] SettingsError),
    /// Writing.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The current directory is gone.
    #[error("the current directory is unknown: {0}")]
    Directory(std::io::Error),
}

impl KeptCommand {
    /// The present command, with its measurements as they are now.
    ///
    /// # Errors
    /// When a measurement cannot be read.
    pub fn of(measurements: &[PathBuf]) -> Result<Self, KeptCommandError> {
        let directory = std::env::current_dir().map_err(KeptCommandError::Directory)?;
        let data = measurements.iter().map(|m| Source::of(m)).collect::<Result<_, _>>()?;
        Ok(Self { schema: SCHEMA.to_owned(), words: std::env::args().collect(), directory, data })
    }

    /// The one that was kept in `directory`, and its arguments with paths that hold from anywhere.
    ///
    /// # Errors
    /// When there is none, it is damaged, or a measurement has changed since.
    pub fn load(directory: &Path) -> Result<(Self, Box<Arguments>), KeptCommandError> {
        let file = directory.join(FILE);
        let text = std::fs::read(&file)
            .map_err(|source| KeptCommandError::Nothing { directory: directory.to_owned(), source })?;
        let damaged = |reason: String| KeptCommandError::Damaged { file: file.clone(), reason };
        let kept: Self = serde_json::from_slice(&text).map_err(|e| damaged(e.to_string()))?;
        if kept.schema != SCHEMA {
            return Err(damaged(format!("is of schema {}, this program reads {SCHEMA}", kept.schema)));
        }
        let mut arguments = super::diagnose_arguments(&kept.words)
            .ok_or_else(|| damaged("no command line of a diagnosis".to_owned()))?;
        for source in &kept.data {
            if Source::of(&source.file)? != *source {
                return Err(SettingsError::Changed { file: source.file.clone() }.into());
            }
        }
        arguments.measurements = kept.data.iter().map(|s| s.file.clone()).collect();
        arguments.out = directory.to_owned();
        for path in [&mut arguments.cache, &mut arguments.engine.fmu].into_iter().flatten() {
            *path = kept.directory.join(&*path);
        }
        Ok((kept, arguments))
    }

    /// Keeps it.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn save(&self, folder: &Folder) -> Result<(), OutputError> {
        folder.write(FILE, &json(&folder.path().join(FILE), self)?)
    }
}
