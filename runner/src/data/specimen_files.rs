//! Which files make one test: a file, a directory of one file per specimen, or a list with a name.

use super::error::{DataError, Problem};
use super::measurement::Measurement;
use super::reader::{Wanted, read};
use super::synchronise::{Synchronised, synchronise};
use std::path::{Path, PathBuf};

/// The files of one test.
#[derive(Debug, Clone, PartialEq)]
pub struct SpecimenFiles {
    /// Name of the test.
    pub name: String,
    /// As it was asked for, with absolute paths: asks for the same again from anywhere.
    pub argument: PathBuf,
    /// One file, or one per specimen.
    pub files: Vec<PathBuf>,
}

impl SpecimenFiles {
    /// Reads `FILE`, `DIRECTORY` or `NAME=FILE,FILE,...` (where `*` stands for any part of a file's name).
    ///
    /// # Errors
    /// When there is no file.
    pub fn of(argument: &Path) -> Result<Self, DataError> {
        let fail =
            |file: &Path, problem| DataError { file: file.to_owned(), line: None, column: None, problem };
        let absolute =
            |p: &Path| std::path::absolute(p).map_err(|e| fail(p, Problem::Unreadable(e.to_string())));
        let stem = |p: &Path| p.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        if argument.is_dir() {
            let path = absolute(argument)?;
            let mut files = matching(&path.join("*.csv")).map_err(|p| fail(argument, p))?;
            files.sort();
            let name = path.file_name().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
            return if files.is_empty() {
                Err(fail(argument, Problem::NoFiles))
            } else {
                Ok(Self { name, argument: path, files })
            };
        }
        let list = argument.to_str().and_then(|text| text.split_once('='));
        let Some((name, list)) = list.filter(|_| !argument.exists()) else {
            let path = absolute(argument)?;
            return Ok(Self { name: stem(argument), files: vec![path.clone()], argument: path });
        };
        let (mut files, mut patterns) = (Vec::new(), Vec::new());
        for part in list.split(',').map(|p| Path::new(p.trim())) {
            let part = absolute(part)?;
            let found = if part.exists() {
                vec![part.clone()]
            } else {
                matching(&part).map_err(|p| fail(&part, p))?
            };
            if found.is_empty() {
                return Err(fail(&part, Problem::NoFiles));
            }
            for file in found {
                if files.contains(&file) {
                    return Err(fail(&file, Problem::NamedTwice));
                }
                files.push(file);
            }
            patterns.push(part.to_string_lossy().into_owned());
        }
        let argument = PathBuf::from(format!("{name}={}", patterns.join(",")));
        Ok(Self { name: name.to_owned(), argument, files })
    }

    /// Reads the files; several are put onto common times.
    ///
    /// # Errors
    /// The first thing that is wrong with a file, or that they are not specimens of one test.
    pub fn read(&self, wanted: Wanted) -> Result<Synchronised, DataError> {
        let read = |file: &PathBuf| read(file, wanted);
        let specimens = self.files.iter().map(read).collect::<Result<Vec<Measurement>, _>>()?;
        synchronise(&self.name, specimens)
    }
}

/// Files that a pattern stands for.
fn matching(pattern: &Path) -> Result<Vec<PathBuf>, Problem> {
    let bad = |reason: String| Problem::Unreadable(reason);
    let found = glob::glob(&pattern.to_string_lossy()).map_err(|e| bad(e.to_string()))?;
    let files: Result<Vec<PathBuf>, _> = found.collect();
    Ok(files.map_err(|e| bad(e.to_string()))?.into_iter().filter(|f| f.is_file()).collect())
}

/// Reads the measurement that an argument of the command line names.
///
/// # Errors
/// As [`SpecimenFiles::of`] and [`SpecimenFiles::read`].
pub fn read_test(argument: &Path, wanted: Wanted) -> Result<Measurement, DataError> {
    Ok(SpecimenFiles::of(argument)?.read(wanted)?.measurement)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_a_directory_and_a_list_name_files() {
        let d = tempfile::tempdir().unwrap();
        let path = |name: &str| d.path().join(name);
        for name in ["P2_s2.csv", "P2_s1.csv", "P1_s1.csv", "notes.txt"] {
            std::fs::write(path(name), "").unwrap();
        }
        let names = |argument: &Path| -> Vec<String> {
            let files = SpecimenFiles::of(argument).unwrap().files;
            files.iter().map(|f| f.file_name().unwrap().to_string_lossy().into_owned()).collect()
        };
        assert_eq!(names(&path("P2_s2.csv")), ["P2_s2.csv"]);
        assert_eq!(names(d.path()), ["P1_s1.csv", "P2_s1.csv", "P2_s2.csv"]);
        let list = format!("P2={}", path("P2_*.csv").display());
        assert_eq!(names(Path::new(&list)), ["P2_s1.csv", "P2_s2.csv"]);
        let files = SpecimenFiles::of(Path::new(&list)).unwrap();
        assert_eq!((files.name.as_str(), files.argument.as_path()), ("P2", Path::new(&list)));
        let twice = format!("{list},{}", path("P2_s1.csv").display());
        assert_eq!(SpecimenFiles::of(Path::new(&twice)).unwrap_err().problem, Problem::NamedTwice);
        let none = format!("P3={}", path("P3_*.csv").display());
        let error = SpecimenFiles::of(Path::new(&none)).unwrap_err();
        assert!(error.problem == Problem::NoFiles && error.to_string().contains("P3_*.csv"), "{error}");
    }
}
