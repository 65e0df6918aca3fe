//! The directory of a run's results: one run at a time writes to it, and it holds one run's files.
//!
//! `.poropunch` in the directory is locked as long as the run lasts, and lists the run's files. A later run of the same
//! command begins by removing those of them that still carry the mark, so that a run that is stopped leaves no mixture.

use super::guard::is_input;
use super::mark::{has_mark, words};
use super::{OutputError, UNFINISHED, reason, write_file};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// Name of the list.
const LIST: &str = ".poropunch";

/// A directory that this process writes to, and no other.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    list: File,
}

impl Folder {
    /// Takes a directory for a new run of `command`; it is made if it is not there. Files of the command's earlier run go.
    ///
    /// # Errors
    /// When another process uses it, it holds another command's files, or cannot be written.
    pub fn begin(path: &Path, command: &str) -> Result<Self, OutputError> {
        let (folder, listed) = Self::lock(path, command)?;
        for name in listed {
            let file = path.join(&name);
            if file.is_file() && has_mark(&file).unwrap_or(false) && !is_input(&file) {
                std::fs::remove_file(&file).map_err(|e| OutputError { file, reason: reason(&e) })?;
            }
        }
        folder.start_list(command)?;
        Ok(folder)
    }

    /// Takes a directory to go on with the run of `command` in it; its files stay.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn resume(path: &Path, command: &str) -> Result<Self, OutputError> {
        let (folder, listed) = Self::lock(path, command)?;
        folder.start_list(command)?;
        listed.iter().try_for_each(|name| folder.list(name))?;
        Ok(folder)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file of the run, as [`write_file`] does.
    ///
    /// # Errors
    /// As [`write_file`].
    pub fn write(&self, name: &str, contents: &[u8]) -> Result<(), OutputError> {
        self.list(name)?;
        write_file(&self.path.join(name), contents)
    }

    /// Begins a file of the run that grows line by line, with its mark.
    ///
    /// # Errors
    /// As [`write_file`].
    pub fn stream(&self, name: &str) -> Result<File, OutputError> {
        self.write(name, b"")?;
        let file = self.path.join(name);
        OpenOptions::new().append(true).open(&file).map_err(|e| OutputError { file, reason: reason(&e) })
    }

    /// The lock, and the names in the list.
    fn lock(path: &Path, command: &str) -> Result<(Self, Vec<String>), OutputError> {
        let fail = |reason: String| OutputError { file: path.to_owned(), reason };
        let io = |e: std::io::Error| fail(reason(&e));
        std::fs::create_dir_all(path).map_err(io)?;
        let file = path.join(LIST);
        let mut list = OpenOptions::new().read(true).append(true).create(true).open(&file).map_err(io)?;
        let locked = list.try_lock();
        let mut text = String::new();
        list.read_to_string(&mut text).map_err(io)?;
        let said = |key: &str| text.lines().find_map(|l| l.strip_prefix(key)).map(str::trim);
        match locked {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let process = said("process ").unwrap_or("unknown");
                return Err(fail(format!(
                    "another poropunch (process {process}) is writing to it; wait for it, or choose another with --out"
                )));
            }
            Err(TryLockError::Error(e)) => return Err(io(e)),
        }
        if !text.is_empty() && !text.starts_with("# written by poropunch ") {
            return Err(fail(format!(
                "its file {LIST} was not written by poropunch; choose another with --out"
            )));
        }
        if let Some(other) = said("command ").filter(|other| *other != command) {
            return Err(fail(format!(
                "it holds the files of `{other}`, and a directory holds one run's; choose another with --out"
            )));
        }
        // What a killed run left half written is nobody's now.
        for entry in std::fs::read_dir(path).map_err(io)?.flatten() {
            if entry.file_name().to_string_lossy().starts_with(UNFINISHED) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
        // A name that leads elsewhere was never listed by this program.
        let inside = |name: &&str| Path::new(name).file_name().is_some_and(|n| n == Path::new(name));
        let listed = text.lines().filter_map(|l| l.strip_prefix("file ")).filter(inside);
        Ok((Self { path: path.to_owned(), list }, listed.map(str::to_owned).collect()))
    }

    fn start_list(&self, command: &str) -> Result<(), OutputError> {
        let head = format!(
            "# {}: the files of one run are in this directory\ncommand {command}\nprocess {}\n",
            words(),
            std::process::id()
        );
        let begin = || {
            self.list.set_len(0)?;
            (&self.list).write_all(head.as_bytes())
        };
        begin().map_err(|e| OutputError { file: self.path.join(LIST), reason: reason(&e) })
    }

    fn list(&self, name: &str) -> Result<(), OutputError> {
        let line = format!("file {name}\n");
        (&self.list)
            .write_all(line.as_bytes())
            .map_err(|e| OutputError { file: self.path.join(LIST), reason: reason(&e) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_run_removes_the_files_of_the_earlier_one_and_nothing_else() {
        let d = tempfile::tempdir().unwrap();
        let has = |name: &str| d.path().join(name).exists();
        let first = Folder::begin(d.path(), "identify").unwrap();
        for name in ["a.csv", "b.csv", "mine.csv"] {
            first.write(name, b"x\n").unwrap();
        }
        drop(first);
        std::fs::write(d.path().join("mine.csv"), "edited by hand").unwrap();
        std::fs::write(d.path().join("notes.txt"), "mine").unwrap();
        let unfinished = format!("{UNFINISHED}a1b2");
        std::fs::write(d.path().join(&unfinished), "half").unwrap();
        let resumed = Folder::resume(d.path(), "identify").unwrap();
        assert!(has("a.csv") && has("b.csv") && !has(&unfinished));
        drop(resumed);
        let second = Folder::begin(d.path(), "identify").unwrap();
        assert!(!has("a.csv") && !has("b.csv") && has("mine.csv") && has("notes.txt"));
        let error = second.write("mine.csv", b"x\n").unwrap_err().to_string();
        assert!(error.contains("mine.csv") && error.contains("not written by poropunch"), "{error}");
    }

    #[test]
    fn one_run_at_a_time_and_one_command() {
        let d = tempfile::tempdir().unwrap();
        let first = Folder::begin(d.path(), "identify").unwrap();
        let error = Folder::begin(d.path(), "identify").unwrap_err().to_string();
        assert!(error.contains(&format!("process {}", std::process::id())), "{error}");
        drop(first);
        let error = Folder::begin(d.path(), "diagnose").unwrap_err().to_string();
        assert!(error.contains("files of `identify`") && error.contains("--out"), "{error}");
        std::fs::write(d.path().join(LIST), "mine").unwrap();
        assert!(Folder::begin(d.path(), "identify").unwrap_err().to_string().contains("not written by"));
    }

    #[test]
    fn a_list_that_was_tampered_with_removes_nothing_elsewhere() {
        let d = tempfile::tempdir().unwrap();
        let (inside, outside) = (d.path().join("out"), d.path().join("a.csv"));
        write_file(&outside, b"x\n").unwrap();
        drop(Folder::begin(&inside, "batch").unwrap());
        let list = std::fs::read_to_string(inside.join(LIST)).unwrap();
        std::fs::write(inside.join(LIST), format!("{list}file ../a.csv\nfile {}\n", outside.display()))
            .unwrap();
        drop(Folder::begin(&inside, "batch").unwrap());
        assert!(outside.exists());
    }
}
