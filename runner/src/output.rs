//! Result files: every file that the program writes goes through here. Never half a file, never over anything that
//! poropunch did not write.

pub mod folder;
pub mod guard;
pub mod mark;

pub use folder::Folder;
pub use guard::{check_no_device, protect, read_input};

use crate::pool::ForceCurve;
use poropunch::variables;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Write as _;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A file that cannot be written.
#[derive(Debug, Error)]
#[error("cannot write {}: {reason}", file.display())]
pub struct OutputError {
    /// The file.
    pub file: PathBuf,
    /// Reason and remedy.
    pub reason: String,
}

/// Writes a file whole or not at all, with its mark, and on disk before it takes its name; its directory is made if it is
/// not there. A file of the same name is replaced only if it carries the mark and is no input of this command.
///
/// # Errors
/// When there is something of that name that poropunch did not write, the disk is full, permission is missing, ...
pub fn write_file(file: &Path, contents: &[u8]) -> Result<(), OutputError> {
    write_file_in_parts(file, |out| out.write_all(&mark::marked(file, contents)))
}

/// As [`write_file`], for contents that need not be in memory at once; `write` puts the mark into them.
///
/// # Errors
/// As [`write_file`], and those of `write`.
pub fn write_file_in_parts(
    file: &Path,
    write: impl FnOnce(&mut (dyn Write + Send)) -> std::io::Result<()>,
) -> Result<(), OutputError> {
    let fail = |reason: String| OutputError { file: file.to_owned(), reason };
    let target = replaceable(file).map_err(fail)?;
    let attempt = |target: &Path, replaces: bool| -> std::io::Result<()> {
        let directory = directory_of(target);
        std::fs::create_dir_all(directory)?;
        let mut temporary =
            tempfile::Builder::new().prefix(UNFINISHED).permissions(readable()).tempfile_in(directory)?;
        let mut out = BufWriter::new(&mut temporary);
        write(&mut out)?;
        out.flush()?;
        drop(out);
        temporary.as_file().sync_all()?;
        // What appeared under this name meanwhile is somebody else's.
        if replaces {
            temporary.persist(target)?
        } else {
            temporary.persist_noclobber(target)?
        };
        std::fs::File::open(directory)?.sync_all()
    };
    attempt(target.as_deref().unwrap_or(file), target.is_some()).map_err(|e| fail(reason(&e)))
}

/// The directory that a file or directory is in.
pub fn directory_of(path: &Path) -> &Path {
    path.parent().filter(|d| !d.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// How names of files begin that are not whole yet: only a process that was killed leaves one behind.
const UNFINISHED: &str = ".poropunch-unfinished-";

/// Checks that nothing is where a file is to be written that must not be lost.
///
/// # Errors
/// When there is; `option` is the one that names another place.
pub fn check_free(file: &Path, option: &str) -> Result<(), OutputError> {
    match file.symlink_metadata() {
        Ok(_) => Err(taken(file, option)),
        Err(_) => Ok(()),
    }
}

/// Makes a directory that no other run may fill, too.
///
/// # Errors
/// When it is there, or cannot be made; `option` is the one that names another place.
pub fn claim_directory(directory: &Path, option: &str) -> Result<(), OutputError> {
    let made = std::fs::create_dir_all(directory_of(directory)).and_then(|()| std::fs::create_dir(directory));
    made.map_err(|e| match e.kind() {
        std::io::ErrorKind::AlreadyExists => taken(directory, option),
        _ => OutputError { file: directory.to_owned(), reason: reason(&e) },
    })
}

fn taken(path: &Path, option: &str) -> OutputError {
    let reason =
        format!("it exists, and another run made or makes it; choose another with {option}, or move it away");
    OutputError { file: path.to_owned(), reason }
}

/// Checks that a file that is written by other means, the FMU's, may be replaced.
///
/// # Errors
/// As [`write_file`], for something of that name that poropunch did not write.
pub fn check_replaceable(file: &Path) -> Result<(), OutputError> {
    replaceable(file).map(drop).map_err(|reason| OutputError { file: file.to_owned(), reason })
}

/// Gives the mark to a file that the FMU wrote at a place that was free, or that had the mark.
///
/// # Errors
/// When it cannot be written.
pub fn mark_written(file: &Path) -> Result<(), OutputError> {
    let write = || std::fs::write(file, mark::marked(file, &std::fs::read(file)?));
    write().map_err(|e| OutputError { file: file.to_owned(), reason: reason(&e) })
}

/// The file to be replaced, links resolved; `None` when there is nothing of that name.
fn replaceable(file: &Path) -> Result<Option<PathBuf>, String> {
    const OTHER: &str = "choose another with --out, or move it away";
    if file.symlink_metadata().is_err() {
        return Ok(None);
    }
    let target = file.canonicalize().map_err(|e| format!("it leads nowhere ({e}); {OTHER}"))?;
    if !target.is_file() {
        let what = if target.is_dir() { "a directory" } else { "no regular file, perhaps a device" };
        return Err(format!("it is {what}; {OTHER}"));
    }
    if guard::is_input(&target) {
        return Err("it is an input of this command; choose another with --out".to_owned());
    }
    match mark::has_mark(&target) {
        Ok(true) => Ok(Some(target)),
        Ok(false) => Err(format!("it is there already and was not written by poropunch; {OTHER}")),
        Err(e) => Err(format!("it is there already and cannot be read ({e}); {OTHER}")),
    }
}

/// JSON of a result that is certain to be read again: a number that is not finite would come out as `null`.
///
/// # Errors
/// Names the field that could not be read back.
pub fn json<T: Serialize + DeserializeOwned>(file: &Path, value: &T) -> Result<Vec<u8>, OutputError> {
    let fail = |e: serde_json::Error| OutputError {
        file: file.to_owned(),
        reason: format!("the result cannot be kept as JSON, a number in it is not finite: {e}"),
    };
    let text = serde_json::to_vec_pretty(value).map_err(fail)?;
    serde_json::from_slice::<T>(&text).map_err(fail)?;
    Ok(text)
}

/// Removes a folder with everything in it.
///
/// # Errors
/// When it is not there, or permission is missing.
pub fn remove_folder(folder: &Path) -> Result<(), OutputError> {
    std::fs::remove_dir_all(folder).map_err(|e| OutputError { file: folder.to_owned(), reason: reason(&e) })
}

/// Why, with a remedy where there is a general one.
fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            format!("{error}; free some space or choose another place with --out")
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            format!("{error}; choose another place with --out")
        }
        _ => error.to_string(),
    }
}

/// Temporary files are private by default; results are for everyone that the directory lets in.
#[cfg(unix)]
fn readable() -> std::fs::Permissions {
    std::os::unix::fs::PermissionsExt::from_mode(0o644)
}

/// CSV of a curve: time, displacement, and each output in its display unit, with the units in the names.
pub fn curve_csv(curve: &ForceCurve, comments: &[String]) -> String {
    let mut text = String::new();
    for comment in comments {
        let _ = writeln!(text, "# {comment}");
    }
    let columns: Vec<(String, f64)> =
        curve.names.iter().enumerate().map(|(i, name)| output_column(name, i == 0)).collect();
    text.push_str("time_s,displacement_mm");
    for (name, _) in &columns {
        let _ = write!(text, ",{name}");
    }
    text.push('\n');
    for i in 0..curve.time_s.len() {
        let _ = write!(text, "{},{}", short(curve.time_s[i]), short(curve.displacement_m[i] * 1e3));
        for (series, (_, factor)) in curve.values.iter().zip(&columns) {
            let _ = write!(text, ",{}", short(series[i] * factor));
        }
        text.push('\n');
    }
    text
}

/// Name with unit, and factor from SI, of an output. The first output is the force, whatever its name.
fn output_column(name: &str, is_force: bool) -> (String, f64) {
    let unit = variables::by_name(name).and_then(|(_, v)| v.unit());
    match unit {
        _ if is_force => ("force_mN".into(), 1e3),
        Some(unit) if unit.symbol != "1" => (format!("{name}_{}", unit.display), unit.factor),
        _ => (name.to_owned(), 1.0),
    }
}

/// Ten significant digits without trailing zeros.
fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.9e}").parse().unwrap_or(value);
    format!("{rounded}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_written_in_display_units() {
        let curve = ForceCurve {
            time_s: vec![0.1],
            displacement_m: vec![1e-3],
            names: vec!["force".into(), "force_fluid".into(), "stored_energy".into()],
            values: vec![vec![12e-3], vec![5e-3], vec![2.5e-6]],
        };
        let text = curve_csv(&curve, &["one".into()]);
        assert_eq!(
            text,
            "# one\ntime_s,displacement_mm,force_mN,force_fluid_mN,stored_energy_uJ\n0.1,1,12,5,2.5\n"
        );
    }

    #[test]
    fn an_unwritable_place_is_an_error_with_the_file_name() {
        let directory = tempfile::tempdir().unwrap();
        let blocker = directory.path().join("file");
        std::fs::write(&blocker, b"x").unwrap();
        let error = write_file(&blocker.join("below"), b"x").unwrap_err();
        assert!(error.to_string().contains("below"));
        assert_eq!(std::fs::read(&blocker).unwrap(), b"x");
    }

    #[test]
    fn only_own_files_are_replaced() {
        let directory = tempfile::tempdir().unwrap();
        let refused = |name: &str, part: &str| {
            let error = write_file(&directory.path().join(name), b"x").unwrap_err().to_string();
            assert!(error.contains(name) && error.contains(part) && error.contains("--out"), "{error}");
        };
        let (own, other) = (directory.path().join("own.csv"), directory.path().join("other.csv"));
        write_file(&own, b"1").unwrap();
        write_file(&own, b"2").unwrap();
        assert!(std::fs::read(&own).unwrap().ends_with(b"2"));
        std::fs::write(&other, "mine").unwrap();
        refused("other.csv", "not written by poropunch");
        std::fs::create_dir(directory.path().join("folder")).unwrap();
        refused("folder", "a directory");
        // An input stays, whoever wrote it, under any name.
        let input = directory.path().join("input.csv");
        write_file(&input, b"1").unwrap();
        assert!(read_input(&input).is_ok());
        refused("input.csv", "an input");
        #[cfg(unix)]
        {
            let link = |to: &Path, name: &str| {
                std::os::unix::fs::symlink(to, directory.path().join(name)).unwrap();
            };
            link(&other, "link.csv");
            refused("link.csv", "not written by poropunch");
            link(&input, "input_link.csv");
            refused("input_link.csv", "an input");
            link(Path::new("/dev/null"), "null.csv");
            refused("null.csv", "perhaps a device");
            link(Path::new("nowhere"), "dangling.csv");
            refused("dangling.csv", "nowhere");
        }
        assert_eq!(std::fs::read(&other).unwrap(), b"mine");
    }

    #[test]
    fn json_that_could_not_be_read_back_is_refused() {
        let file = Path::new("result.json");
        assert!(json(file, &vec![1.0, 2.0]).is_ok());
        let error = json(file, &vec![1.0, f64::NAN]).unwrap_err().to_string();
        assert!(error.contains("result.json") && error.contains("not finite"), "{error}");
    }
}
