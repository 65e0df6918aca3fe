//! Measurements as job files and plans name them: where they are, and that they are what they were.

use super::{DataError, Problem, SpecimenFiles};
use std::path::{Path, PathBuf};

/// A measurement's file, or files, as they were when they were read.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Absolute path of the file or the directory, or `NAME=FILE,FILE,...` with absolute paths.
    pub file: PathBuf,
    /// blake3 of the bytes; of the files' hashes where there are several.
    pub hash: String,
}

impl Source {
    /// A measurement as it is now.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn of(argument: &Path) -> Result<Self, DataError> {
        let source = SpecimenFiles::of(argument)?;
        let hash = |file: &PathBuf| {
            std::fs::read(file).map(|bytes| blake3::hash(&bytes)).map_err(|e| DataError {
                file: file.clone(),
                line: None,
                column: None,
                problem: Problem::Unreadable(e.to_string()),
            })
        };
        let hashes = source.files.iter().map(hash).collect::<Result<Vec<_>, _>>()?;
        let all = match hashes.as_slice() {
            [one] => *one,
            several => {
                blake3::hash(several.iter().map(blake3::Hash::to_string).collect::<String>().as_bytes())
            }
        };
        Ok(Self { file: source.argument, hash: all.to_hex().to_string() })
    }
}

/// A path, or `NAME=FILE,FILE,...`, that is meant from the directory of `job`.
pub fn from_directory(text: &str, job: &Path) -> String {
    // Protocols are no files.
    if ["P1", "P2"].contains(&text) {
        return text.to_owned();
    }
    let directory = job.parent().unwrap_or(Path::new(""));
    let place = |part: &str| {
        // `.` in the middle would show in messages.
        directory.join(part.trim()).components().collect::<PathBuf>().to_string_lossy().into_owned()
    };
    match text.split_once('=') {
        Some((name, list)) if !Path::new(&place(text)).exists() => {
            format!("{name}={}", list.split(',').map(place).collect::<Vec<_>>().join(","))
        }
        _ => place(text),
    }
}
