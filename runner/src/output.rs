//! Result files: curves as CSV, and writing that never leaves half a file behind.

use crate::pool::ForceCurve;
use poropunch::variables;
use std::fmt::Write as _;
use std::io::{ErrorKind, Write};
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

/// Writes a file whole or not at all; its directory is made if it is not there.
///
/// # Errors
/// When the disk is full, permission is missing, ...
pub fn write_file(file: &Path, contents: &[u8]) -> Result<(), OutputError> {
    let attempt = || -> std::io::Result<()> {
        let directory = file.parent().filter(|d| !d.as_os_str().is_empty()).unwrap_or(Path::new("."));
        std::fs::create_dir_all(directory)?;
        let mut temporary = tempfile::Builder::new().permissions(readable()).tempfile_in(directory)?;
        temporary.write_all(contents)?;
        temporary.persist(file)?;
        Ok(())
    };
    attempt().map_err(|e| OutputError { file: file.to_owned(), reason: reason(&e) })
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
        write_file(&blocker, b"x").unwrap();
        let error = write_file(&blocker.join("below"), b"x").unwrap_err();
        assert!(error.to_string().contains("below"));
        assert_eq!(std::fs::read(&blocker).unwrap(), b"x");
    }
}
