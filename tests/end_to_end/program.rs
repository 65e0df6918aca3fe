//! Running the program and reading what it wrote.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use tempfile::TempDir;

/// The program that cargo built for this test.
pub fn runner() -> Command {
    Command::new(env!("CARGO_BIN_EXE_runner"))
}

/// A file of the repository.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// The program, with the runs that this process's tests made for commands alike: for those that do not ask how often the model runs.
pub fn sharing_runner() -> Command {
    let mut command = runner();
    command.env("POROPUNCH_CACHE", shared_runs());
    command
}

/// Where they are kept.
pub fn shared_runs() -> &'static Path {
    static ONCE: OnceLock<PathBuf> = OnceLock::new();
    ONCE.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("runs");
        // What earlier tests left.
        let _ = std::fs::remove_dir_all(&folder);
        folder
    })
}

/// Runs to the end.
pub fn run(arguments: &[&str]) -> Output {
    runner().args(arguments).output().expect("the program starts")
}

/// Runs to the end and demands success; returns what it printed.
pub fn succeed(arguments: &[&str]) -> String {
    let output = run(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}\n{error}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Runs to the end and demands failure without a panic; returns the message, in one line.
pub fn fail(arguments: &[&str]) -> String {
    let output = run(arguments);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(output.status.code(), Some(1 | 2 | 4)), "{arguments:?}\n{error}");
    assert!(error.starts_with("error:") && !error.contains("panicked"), "{error}");
    one_line(&error)
}

/// A text without the line breaks that the terminal's width makes.
pub fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Runs to the end and demands an exit code; returns what it printed and what it complained of, in one line.
pub fn refuse(code: i32, arguments: &[&str]) -> String {
    let output = run(arguments);
    let both =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}\n{both}");
    assert!(!both.contains("panicked"), "{both}");
    one_line(&both)
}

/// An empty directory for a test.
pub fn directory() -> TempDir {
    tempfile::tempdir().expect("a temporary directory")
}

/// A path as text.
pub fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// A JSON file.
pub fn json(file: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

/// A column of a CSV file.
pub fn column(file: &Path, name: &str) -> Vec<f64> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(file).expect("a CSV file");
    let header = reader.headers().expect("a header").clone();
    let index = header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no {name} in {header:?}"));
    let value = |r: csv::StringRecord| r[index].parse().unwrap_or_else(|e| panic!("{name}: {e}"));
    reader.records().map(|r| value(r.expect("a row"))).collect()
}
