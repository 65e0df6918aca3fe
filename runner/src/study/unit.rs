//! One unit of work: what is asked, and the hash under which its result is found.

use super::{Question, StudyError};
use crate::cache::Hasher;
use crate::data::source::Source;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A line of `units.jsonl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Unit {
    /// Its number, from 1.
    pub unit: usize,
    /// Hash of what is asked: program, FMU, settings and data, wherever they are kept.
    pub key: String,
    /// Specimen, case, or rows of the table.
    pub specimen: String,
    /// Its group.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Other columns of the table.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub covariates: BTreeMap<String, String>,
    /// Options of the command, its name left out.
    pub options: Vec<String>,
    /// Measurements, or the table of `batch`.
    pub inputs: Vec<Input>,
    /// First and last row of the table of `batch`, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rows: Option<(usize, usize)>,
}

/// A file that a unit reads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Input {
    /// As the command line takes it, absolute.
    pub argument: String,
    /// blake3 of its bytes; of the hashes where there are several files; of the rows.
    pub blake3: String,
    /// It is named by an option, not by its position.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_option: bool,
}

impl Input {
    /// A measurement as it is now.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn measurement(argument: &Path) -> Result<Self, StudyError> {
        let Source { file, hash } = Source::of(argument)?;
        let argument = file.to_string_lossy().into_owned();
        Ok(Self { argument, blake3: hash, is_option: false })
    }

    /// What an option names: a file, a measurement, or a folder (of an FMU) with all that is in it.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn of_option(argument: &Path) -> Result<Self, StudyError> {
        if !argument.is_dir() {
            return Ok(Self { is_option: true, ..Self::measurement(argument)? });
        }
        let folder = std::path::absolute(argument).map_err(StudyError::io(argument))?;
        let mut hash = Hasher::new("study folder");
        add_folder(&folder, &folder, &mut hash)?;
        let blake3 = blake3::Hash::from(hash.finish()).to_hex().to_string();
        Ok(Self { argument: folder.to_string_lossy().into_owned(), blake3, is_option: true })
    }

    /// The same as it is now.
    fn again(&self) -> Result<Self, StudyError> {
        let path = Path::new(&self.argument);
        if self.is_option { Self::of_option(path) } else { Self::measurement(path) }
    }

    /// Name in the answer, which depends on it: of the test, or of the file.
    fn name(&self) -> String {
        match self.argument.split_once('=') {
            Some((name, _)) if !Path::new(&self.argument).exists() => name.to_owned(),
            _ => PathBuf::from(&self.argument).file_name().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }
}

impl Unit {
    /// The hash of what is asked. Where the data are kept does not change it, nor the specimen's name or group.
    pub fn key_of(program: &str, question: Question, options: &[String], inputs: &[Input]) -> String {
        let mut hash = Hasher::new("study unit");
        hash.bytes(program.as_bytes()).bytes(question.command().as_bytes()).count(options.len());
        for option in options {
            let named = inputs.iter().filter(|i| i.is_option).find(|i| option.ends_with(&i.argument));
            let word = named.map_or_else(|| option.clone(), |i| option.replace(&i.argument, &i.name()));
            hash.bytes(word.as_bytes());
        }
        hash.count(inputs.len());
        for input in inputs {
            hash.bytes(input.name().as_bytes()).bytes(input.blake3.as_bytes());
        }
        blake3::Hash::from(hash.finish()).to_hex().to_string()
    }

    /// Checks that the data are those that the plan was made with.
    ///
    /// # Errors
    /// When one is not, or cannot be read.
    pub fn check_inputs(&self) -> Result<(), StudyError> {
        // Rows are checked when they are cut out of the table.
        for input in self.inputs.iter().filter(|i| i.is_option || self.rows.is_none()) {
            if input.again()?.blake3 != input.blake3 {
                return Err(StudyError::Changed { file: PathBuf::from(&input.argument) });
            }
        }
        Ok(())
    }
}

fn add_folder(root: &Path, folder: &Path, hash: &mut Hasher) -> Result<(), StudyError> {
    let entries = std::fs::read_dir(folder).map_err(StudyError::io(folder))?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            add_folder(root, &path, hash)?;
            continue;
        }
        let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().into_owned();
        hash.bytes(name.as_bytes()).bytes(&std::fs::read(&path).map_err(StudyError::io(&path))?);
    }
    Ok(())
}

/// Hash of the running program and of the FMU's library beside it: what answers.
///
/// # Errors
/// When one of them cannot be read.
pub fn program_hash() -> Result<String, StudyError> {
    let program = std::env::current_exe().map_err(StudyError::io(Path::new("the running program")))?;
    let library = crate::fmi::builtin_library()
        .map_err(|e| StudyError::File { file: program.clone(), problem: e.to_string() })?;
    let mut hash = Hasher::new("study program");
    for file in [&program, &library] {
        hash.bytes(&std::fs::read(file).map_err(StudyError::io(file))?);
    }
    Ok(blake3::Hash::from(hash.finish()).to_hex().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn input(argument: &str, blake3: &str) -> Input {
        Input { argument: argument.to_owned(), blake3: blake3.to_owned(), is_option: false }
    }

    #[test]
    fn a_key_follows_what_is_asked_and_not_where_it_is_kept() {
        let coarse = ["--mesh=coarse".to_owned()];
        let key = |program: &str, question, options: &[String], i: &[Input]| {
            Unit::key_of(program, question, options, i)
        };
        let base = key("p", Question::Identify, &coarse, &[input("/a/P2.csv", "1")]);
        assert_eq!(base, key("p", Question::Identify, &coarse, &[input("/b/P2.csv", "1")]));
        for other in [
            key("q", Question::Identify, &coarse, &[input("/a/P2.csv", "1")]),
            key("p", Question::Diagnose, &coarse, &[input("/a/P2.csv", "1")]),
            key("p", Question::Identify, &[], &[input("/a/P2.csv", "1")]),
            key("p", Question::Identify, &coarse, &[input("/a/P2.csv", "2")]),
            key("p", Question::Identify, &coarse, &[input("/a/P1.csv", "1")]),
            key("p", Question::Identify, &coarse, &[input("/a/P2.csv", "1"), input("/a/P1.csv", "1")]),
        ] {
            assert_ne!(base, other);
        }
        // A file that an option names counts by its bytes.
        let job = |place: &str, hash: &str| {
            let file = Input { is_option: true, ..input(place, hash) };
            key("p", Question::Identify, &[format!("--job={place}")], &[file])
        };
        assert_eq!(job("/a/x.toml", "1"), job("/b/x.toml", "1"));
        assert_ne!(job("/a/x.toml", "1"), job("/a/x.toml", "2"));
    }
}
