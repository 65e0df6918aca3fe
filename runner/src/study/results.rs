//! Results by the hash of what was asked: written once, whole, by whoever comes first; safe on network file systems.
//!
//! ```text
//! results/ab/ab12....json    an answer
//! failures/ab/ab12....json   why there is none: the program's or the model's reason; `--again` removes it
//! running/ab12...            who works on it, touched while it lasts: told by `status`, decides nothing
//! ```
//! A result takes its name by a rename or link that fails where the name is taken: no lock is needed, and one that is there already
//! is as good as one's own.

use super::{Question, StudyError};
use crate::output::mark;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::fs::Permissions;
use std::io::{ErrorKind, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Version of the layout.
pub const SCHEMA: &str = "poropunch.study-unit/1";
/// A worker that did not touch its file for so long is gone: several times the interval at which it does, and the time for which
/// network file systems keep attributes.
const GONE: Duration = Duration::from_secs(90);

/// A unit's result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct UnitResult {
    /// [`SCHEMA`].
    pub schema: String,
    /// Hash of what was asked.
    pub key: String,
    /// What was asked.
    pub question: Question,
    /// The fit converged; always true of other questions.
    pub converged: bool,
    /// How it was computed; no answer depends on it.
    pub run: Provenance,
    /// What the command wrote: `result.json`, `diagnosis.json`, or the rows of `summary.csv`.
    pub answer: serde_json::Value,
}

/// Where and how a unit was computed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Provenance {
    /// Machine.
    pub host: String,
    /// Vector instructions of its processor, which may change last bits.
    pub vector: String,
    /// Instances at a time.
    pub jobs: usize,
    /// Wall time (s).
    pub seconds: f64,
    /// Of that, outside the command: reading, checking, writing (s).
    pub overhead_seconds: f64,
    /// Largest memory of the worker's commands so far (MB).
    pub memory_mb: f64,
}

/// Why a unit has no result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Failure {
    /// [`SCHEMA`].
    pub schema: String,
    /// Hash of what was asked.
    pub key: String,
    /// Exit code of the command.
    pub exit_code: Option<i32>,
    /// Its message.
    pub reason: String,
    /// Machine.
    pub host: String,
}

/// The store.
#[derive(Debug, Clone)]
pub struct Results {
    root: PathBuf,
}

/// Kinds of entries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// An answer.
    Result,
    /// A reason.
    Failure,
}

impl Kind {
    fn folder(self) -> &'static str {
        match self {
            Self::Result => "results",
            Self::Failure => "failures",
        }
    }
}

impl Results {
    /// The store at a place, which is made when something is written.
    pub fn new(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    fn path(&self, kind: Kind, key: &str) -> PathBuf {
        // 256 folders: a hundred thousand names in one are slow on many file systems.
        self.root.join(kind.folder()).join(&key[..2.min(key.len())]).join(format!("{key}.json"))
    }

    /// Whether a unit has one.
    ///
    /// # Errors
    /// When that cannot be told.
    pub fn has(&self, kind: Kind, key: &str) -> Result<bool, StudyError> {
        let path = self.path(kind, key);
        Ok(missed(std::fs::metadata(&path)).map_err(StudyError::io(&path))?.is_some())
    }

    /// Reads one; `None` where there is none.
    ///
    /// # Errors
    /// When it is there and cannot be read.
    pub fn get<T: DeserializeOwned>(&self, kind: Kind, key: &str) -> Result<Option<T>, StudyError> {
        let path = self.path(kind, key);
        let Some(bytes) = missed(std::fs::read(&path)).map_err(StudyError::io(&path))? else {
            return Ok(None);
        };
        serde_json::from_slice(&bytes).map(Some).map_err(|e| StudyError::File {
            file: path,
            problem: format!("it cannot be read ({e}); delete it, and the unit is computed again"),
        })
    }

    /// Keys of all that there are: a folder is read once, whatever the number of units.
    ///
    /// # Errors
    /// When a folder is there and cannot be read.
    pub fn keys(&self, kind: Kind) -> Result<HashSet<String>, StudyError> {
        let root = self.root.join(kind.folder());
        let mut keys = HashSet::new();
        for folder in listed(&root)? {
            for file in listed(&folder)? {
                // Files that are being written have other names.
                let is_entry = file.extension().is_some_and(|e| e == "json");
                let stem = file.file_stem().map(|s| s.to_string_lossy().into_owned());
                keys.extend(stem.filter(|s| is_entry && !s.starts_with('.')));
            }
        }
        Ok(keys)
    }

    /// Keeps an entry unless there is one; whether it was new. Whole or not at all, on disk before it has its name.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn publish<T: Serialize>(&self, kind: Kind, key: &str, entry: &T) -> Result<bool, StudyError> {
        let path = self.path(kind, key);
        let folder = path.parent().unwrap_or(&self.root);
        let text = serde_json::to_vec(entry)
            .map_err(|e| StudyError::File { file: path.clone(), problem: e.to_string() })?;
        let write = || -> std::io::Result<bool> {
            shared_folder(folder)?;
            let mut file = tempfile::Builder::new().prefix(".writing-").tempfile_in(folder)?;
            file.write_all(&mark::marked(&path, &text))?;
            // Temporary files are private, results are the group's, whatever the worker's umask.
            file.as_file().set_permissions(Permissions::from_mode(0o644))?;
            file.as_file().sync_all()?;
            match file.persist_noclobber(&path) {
                Ok(_) => {}
                Err(e) if e.error.kind() == ErrorKind::AlreadyExists => return Ok(false),
                Err(e) => return Err(e.error),
            }
            std::fs::File::open(folder)?.sync_all()?;
            Ok(true)
        };
        write().map_err(StudyError::io(&path))
    }

    /// Forgets a failure, so that the unit is tried again.
    ///
    /// # Errors
    /// When it cannot be removed.
    pub fn forget_failure(&self, key: &str) -> Result<(), StudyError> {
        let path = self.path(Kind::Failure, key);
        missed(std::fs::remove_file(&path)).map_err(StudyError::io(&path)).map(drop)
    }

    /// When the last so many results were written, oldest first.
    ///
    /// # Errors
    /// When the store cannot be read.
    pub fn times<'a>(&self, keys: impl Iterator<Item = &'a String>) -> Vec<SystemTime> {
        let time = |key: &String| std::fs::metadata(self.path(Kind::Result, key)).ok()?.modified().ok();
        let mut times: Vec<SystemTime> = keys.filter_map(time).collect();
        times.sort();
        times
    }

    /// Says that this process works on a unit, until what is returned is dropped. A file that cannot be written says nothing.
    pub fn claim(&self, key: &str) -> Claim {
        let path = self.claim_path(key);
        let text = format!("{} {}\n", host(), std::process::id());
        let write = || {
            shared_folder(&self.root.join("running"))?;
            std::fs::write(&path, text)
        };
        Claim { path: write().is_ok().then_some(path), touched: SystemTime::now() }
    }

    /// Whether some process works on a unit, as far as that can be told.
    pub fn is_running(&self, key: &str) -> bool {
        let path = self.claim_path(key);
        let age =
            std::fs::metadata(&path).and_then(|m| m.modified()).ok().map(|t| t.elapsed().unwrap_or_default());
        if age.is_none_or(|age| age > GONE) {
            return false;
        }
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        match text.trim().split_once(' ') {
            // A process of this machine is asked itself.
            Some((machine, process)) if machine == host() => Path::new("/proc").join(process).exists(),
            _ => true,
        }
    }

    /// Keys of the units that some process works on.
    ///
    /// # Errors
    /// When the store cannot be read.
    pub fn running(&self) -> Result<HashSet<String>, StudyError> {
        let files = listed(&self.root.join("running"))?;
        let names = files.iter().filter_map(|f| f.file_name().map(|n| n.to_string_lossy().into_owned()));
        Ok(names.filter(|key| self.is_running(key)).collect())
    }

    fn claim_path(&self, key: &str) -> PathBuf {
        self.root.join("running").join(key)
    }
}

/// Says that a unit is worked on, as long as it lives.
#[derive(Debug)]
pub struct Claim {
    path: Option<PathBuf>,
    touched: SystemTime,
}

impl Claim {
    /// Says it again from time to time.
    pub fn touch(&mut self) {
        if self.touched.elapsed().is_ok_and(|age| age < GONE / 4) {
            return;
        }
        self.touched = SystemTime::now();
        let file = self.path.as_ref().and_then(|p| std::fs::OpenOptions::new().write(true).open(p).ok());
        let _ = file.map(|f| f.set_modified(self.touched));
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        let _ = self.path.as_ref().map(std::fs::remove_file);
    }
}

/// What is not there, or went away while it was looked at on a network file system, is a miss.
fn missed<T>(result: std::io::Result<T>) -> std::io::Result<Option<T>> {
    match result {
        Ok(found) => Ok(Some(found)),
        Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::StaleNetworkFileHandle) => Ok(None),
        Err(e) => Err(e),
    }
}

fn listed(folder: &Path) -> Result<Vec<PathBuf>, StudyError> {
    let Some(entries) = missed(std::fs::read_dir(folder)).map_err(StudyError::io(folder))? else {
        return Ok(vec![]);
    };
    Ok(entries.flatten().map(|e| e.path()).collect())
}

/// A folder that the group may write to; one that is there is left as it is.
fn shared_folder(folder: &Path) -> std::io::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    std::fs::create_dir_all(folder)?;
    let _ = std::fs::set_permissions(folder, Permissions::from_mode(0o775));
    Ok(())
}

/// Name of this machine.
pub(super) fn host() -> String {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    if name.trim().is_empty() { "unknown".to_owned() } else { name.trim().replace(' ', "-") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn failure(reason: &str) -> Failure {
        Failure {
            schema: SCHEMA.to_owned(),
            key: "ab12".to_owned(),
            exit_code: Some(1),
            reason: reason.to_owned(),
            host: host(),
        }
    }

    #[test]
    fn the_first_result_stays_and_is_the_groups() {
        let d = tempfile::tempdir().unwrap();
        let store = Results::new(d.path());
        assert!(store.keys(Kind::Result).unwrap().is_empty());
        assert!(store.publish(Kind::Result, "ab12", &failure("first")).unwrap());
        assert!(!store.publish(Kind::Result, "ab12", &failure("second")).unwrap());
        let kept: Failure = store.get(Kind::Result, "ab12").unwrap().unwrap();
        assert_eq!(kept.reason, "first");
        let path = store.path(Kind::Result, "ab12");
        assert_eq!(path.metadata().unwrap().permissions().mode() & 0o777, 0o644);
        // Nothing else is left beside it.
        assert_eq!(listed(path.parent().unwrap()).unwrap(), [path]);
        assert_eq!(store.keys(Kind::Result).unwrap(), ["ab12".to_owned()].into());
        assert!(store.get::<Failure>(Kind::Result, "cd34").unwrap().is_none());
        store.publish(Kind::Failure, "ab12", &failure("x")).unwrap();
        store.forget_failure("ab12").unwrap();
        store.forget_failure("ab12").unwrap();
        assert!(!store.has(Kind::Failure, "ab12").unwrap());
    }

    #[test]
    fn many_writers_of_one_result_leave_one_whole_file() {
        let d = tempfile::tempdir().unwrap();
        let store = Results::new(d.path());
        let long = |k: usize| failure(&k.to_string().repeat(100_000));
        let new: usize = std::thread::scope(|scope| {
            let write = |k| {
                let store = &store;
                scope.spawn(move || usize::from(store.publish(Kind::Result, "ab12", &long(k)).unwrap()))
            };
            let all: Vec<_> = (0..8).map(write).collect();
            all.into_iter().map(|t| t.join().unwrap()).sum()
        });
        assert_eq!(new, 1);
        let kept: Failure = store.get(Kind::Result, "ab12").unwrap().unwrap();
        assert!((0..8).any(|k| kept == long(k)));
    }

    #[test]
    fn a_stale_handle_is_a_miss_and_other_errors_are_not() {
        let error = |kind: ErrorKind| missed::<()>(Err(kind.into()));
        assert!(matches!(error(ErrorKind::StaleNetworkFileHandle), Ok(None)));
        assert!(matches!(error(ErrorKind::NotFound), Ok(None)));
        assert!(error(ErrorKind::PermissionDenied).is_err());
    }

    #[test]
    fn a_claim_lasts_as_long_as_its_process() {
        let d = tempfile::tempdir().unwrap();
        let store = Results::new(d.path());
        let claim = store.claim("ab12");
        assert!(store.is_running("ab12") && store.running().unwrap().len() == 1);
        drop(claim);
        assert!(!store.is_running("ab12"));
        // A process that is gone left this; no process has a number beyond the kernel's limit of 2^22.
        std::fs::write(store.claim_path("ab12"), format!("{} 4194305\n", host())).unwrap();
        assert!(!store.is_running("ab12"));
        std::fs::write(store.claim_path("ab12"), "elsewhere 1\n").unwrap();
        assert!(store.is_running("ab12"));
    }
}
