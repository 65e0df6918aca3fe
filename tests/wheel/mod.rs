//! poropunch for Python: the package's code over the program that cargo built, and the wheel in an environment of its own.
//!
//! Goal: arrays in, the same numbers as the command line out; errors are exceptions; what runs can be stopped.
//! Set-up: the short test puts program and library where the wheel would, and leaves out what needs the extension module; the long one
//! builds and installs the wheel, as a user does.
//! Reference: the command line's curve, central differences, the shipped data's known parameters.

use crate::end_to_end::program::{repository, shared_runs};
use runner::fmi::builtin_library;
use std::path::{Path, PathBuf};
use std::process::Command;

pub(crate) fn python() -> PathBuf {
    std::env::var_os("POROPUNCH_PYTHON").map_or_else(|| repository(".venv/bin/python"), Into::into)
}

/// Runs to the end and demands success; returns what it printed.
pub(crate) fn succeed(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}; tests/run installs it"));
    let [said, error] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(output.status.success(), "{command:?}\n{said}\n{error}");
    said
}

/// Makes an environment of its own in `folder`, with packages of PyPI or from here; returns the folder of its programs.
pub(crate) fn environment(folder: &Path, options: &[&str], packages: &[&str]) -> PathBuf {
    let environment = folder.join("environment");
    succeed(Command::new(python()).args(["-m", "venv"]).args(options).arg(&environment));
    let bin = environment.join("bin");
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    succeed(Command::new(bin.join("python")).args(install).args(packages));
    bin
}

/// The package with what cargo built for this test, but without the extension module.
pub(crate) fn staged(folder: &Path) {
    let package = repository("runner/python/poropunch");
    for part in ["", "results"] {
        let to = folder.join("poropunch").join(part);
        std::fs::create_dir_all(&to).unwrap();
        for file in std::fs::read_dir(package.join(part)).unwrap().map(|entry| entry.unwrap().path()) {
            if file.extension().is_some_and(|e| e == "py") {
                std::fs::copy(&file, to.join(file.file_name().unwrap())).unwrap();
            }
        }
    }
    let built = folder.join("poropunch/built");
    std::fs::create_dir(&built).unwrap();
    let library = builtin_library().unwrap();
    std::fs::copy(&library, built.join(library.file_name().unwrap())).unwrap();
    std::fs::copy(env!("CARGO_BIN_EXE_runner"), built.join("runner")).unwrap();
}

#[test]
fn the_dataclasses_are_current() {
    succeed(Command::new(python()).arg(repository("runner/python/generate.py")).arg("--check"));
}

#[test]
fn python_speaks_with_the_program() {
    let folder = tempfile::tempdir().unwrap();
    staged(folder.path());
    let mut test = Command::new(python());
    test.arg("-W").arg("error::DeprecationWarning").arg(repository("tests/wheel/python/program.py"));
    succeed(test.arg(repository("data")).env("PYTHONPATH", folder.path()).current_dir(folder.path()));
}

#[test]
#[ignore = "long: compiles runner again with the features of the extension module, and installs from PyPI"]
fn the_wheel_from_a_fresh_environment() {
    let folder = tempfile::tempdir().unwrap();
    let wheel = format!("{}[pandas]", repository("runner/python").display());
    let bin = environment(folder.path(), &[], &[&wheel]);
    let mut test = Command::new(bin.join("python"));
    test.arg(repository("tests/wheel/python/wheel.py")).arg(repository("data"));
    println!("{}", succeed(test.current_dir(folder.path())));
}

/// Executes a notebook of the package in a directory that has the repository's folders.
fn notebook(name: &str) {
    let folder = tempfile::tempdir().unwrap();
    staged(folder.path());
    for link in ["data", "tests"] {
        std::os::unix::fs::symlink(repository(link), folder.path().join(link)).unwrap();
    }
    let bin = folder.path().join("bin");
    std::fs::create_dir(&bin).unwrap();
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_runner"), bin.join("poropunch")).unwrap();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(bin).chain(std::env::split_paths(&path))).unwrap();
    let mut test = Command::new(python());
    test.arg(repository("tests/wheel/python/notebook.py"));
    test.arg(repository(&format!("runner/python/notebooks/{name}.ipynb")));
    test.env("PATH", path).env("PYTHONPATH", folder.path()).env("POROPUNCH_CACHE", shared_runs());
    succeed(test.current_dir(folder.path()));
}

#[test]
fn notebook_own_data() {
    notebook("own_data");
}

#[test]
#[ignore = "long: a diagnosis, a minute of CPU"]
fn notebook_gap() {
    notebook("gap");
}

#[test]
#[ignore = "long: a study of twelve specimens, a minute of CPU"]
fn notebook_population() {
    notebook("population");
}
