//! Which files make one test: a file, a directory of one file per specimen, or a list with a name.

use super::error::{DataError, Problem, Question};
use super::measurement::Measurement;
use super::reader::{Wanted, read_as};
use super::reading::Reading;
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
    pub fn read(&self, wanted: Wanted, reading: &Reading) -> Result<Synchronised, DataError> {
        let specimens = asked_together(self.files.iter().map(|file| read_as(file, wanted, reading)))?;
        for (k, one) in specimens.iter().enumerate().filter(|(_, m)| !m.force_n.is_empty()) {
            if let Some(first) =
                specimens[..k].iter().find(|m| m.force_n == one.force_n && m.time_s == one.time_s)
            {
                let name = |m: &Measurement| m.file.display().to_string();
                return Err(one.error(Problem::SameTwice { first: name(first), second: name(one) }));
            }
        }
        let warnings: Vec<String> = specimens
            .iter()
            .filter(|_| specimens.len() > 1)
            .flat_map(|m| m.warnings.iter().map(|w| format!("{}: {w}", m.name)))
            .collect();
        let mut test = synchronise(&self.name, specimens)?;
        test.measurement.name.clone_from(&self.name);
        test.measurement.warnings.extend(warnings);
        Ok(test)
    }
}

/// Files that a pattern stands for.
fn matching(pattern: &Path) -> Result<Vec<PathBuf>, Problem> {
    let bad = |reason: String| Problem::Unreadable(reason);
    let found = glob::glob(&pattern.to_string_lossy()).map_err(|e| bad(e.to_string()))?;
    let files: Result<Vec<PathBuf>, _> = found.collect();
    Ok(files.map_err(|e| bad(e.to_string()))?.into_iter().filter(|f| f.is_file()).collect())
}

/// Reads the tests that arguments of the command line name; what several files leave open is asked once.
///
/// # Errors
/// As [`SpecimenFiles::of`] and [`SpecimenFiles::read`]; when two tests are the same data, or have one name.
pub fn read_tests(
    arguments: &[PathBuf],
    wanted: Wanted,
    reading: &Reading,
) -> Result<Vec<Synchronised>, DataError> {
    let read = |argument: &PathBuf| SpecimenFiles::of(argument)?.read(wanted, reading);
    let mut tests = asked_together(arguments.iter().map(read))?;
    for (k, test) in tests.iter().enumerate() {
        let m = &test.measurement;
        let same = |t: &&Synchronised| {
            t.measurement.force_n == m.force_n && t.measurement.time_s == m.time_s && !m.force_n.is_empty()
        };
        if let Some(first) = tests[..k].iter().find(same) {
            let (first, second) =
                (first.measurement.file.display().to_string(), m.file.display().to_string());
            return Err(m.error(Problem::SameTwice { first, second }));
        }
    }
    tell_apart(&mut tests)?;
    Ok(tests)
}

/// Tests of one name are called by the directories that they are in, too.
fn tell_apart(tests: &mut [Synchronised]) -> Result<(), DataError> {
    let names: Vec<String> = tests.iter().map(|t| t.measurement.name.clone()).collect();
    let is_shared = |name: &String| names.iter().filter(|n| *n == name).count() > 1;
    for test in tests.iter_mut().filter(|t| is_shared(&t.measurement.name)) {
        let m = &mut test.measurement;
        if let Some(directory) = m.file.parent().and_then(Path::file_name) {
            m.name = format!("{}_{}", directory.to_string_lossy(), m.name);
        }
    }
    for (k, test) in tests.iter().enumerate() {
        if tests[..k].iter().any(|t| t.measurement.name == test.measurement.name) {
            return Err(test.measurement.error(Problem::SameName(test.measurement.name.clone())));
        }
    }
    Ok(())
}

/// All that could be read; otherwise everything that the files leave open at once, or the first other complaint.
fn asked_together<T>(results: impl Iterator<Item = Result<T, DataError>>) -> Result<Vec<T>, DataError> {
    let (mut read, mut open, mut first) = (Vec::new(), Vec::<Question>::new(), None);
    for result in results {
        match result {
            Ok(one) => read.push(one),
            Err(DataError { file, problem: Problem::Unclear(questions), .. }) => {
                let new = |q: &Question| !open.iter().any(|p: &Question| p.answer == q.answer);
                let new: Vec<Question> = questions.into_iter().filter(new).collect();
                open.extend(new);
                first.get_or_insert(file);
            }
            Err(other) => return Err(other),
        }
    }
    match first {
        Some(file) => Err(DataError { file, line: None, column: None, problem: Problem::Unclear(open) }),
        None => Ok(read),
    }
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
