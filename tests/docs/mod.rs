//! The documentation: every command of README and of the site is run as it stands, the site is built, help and reports are as they were.
//!
//! Goal: what a reader copies works. Set-up: a page's blocks in `sh` and `python` are run in their order in an empty directory that has
//! the repository's folders; `poropunch` is the program that cargo built, or the installed wheel. A comment before a block says what
//! else holds:
//!
//! | `<!-- ... -->` | the block is run |
//! |---|---|
//! | `long: why` | by `long_commands` |
//! | `wheel: why` | by `pages_from_the_wheel`, which installs it |
//! | `importers` | by `importers`: packages that no other test needs |
//! | `not run: why` | never |
//!
//! Reference: exit codes, assertions in the blocks, snapshots (`INSTA_UPDATE=always` makes them anew).

mod blocks;
mod snapshots;

use super::end_to_end::program::{repository, shared_runs};
use super::wheel::{environment, python, staged, succeed};
use blocks::{Block, Mark, blocks};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// A page's directory, and what its commands find.
struct Place {
    scratch: TempDir,
    path: OsString,
    packages: Option<PathBuf>,
}

impl Place {
    /// With the folders `bin` in front of the path.
    fn new(bin: &[PathBuf], packages: Option<PathBuf>) -> Self {
        let scratch = tempfile::tempdir().unwrap();
        for name in ["data", "runner", "fmu", "cdylib", "tests", "modelDescription.xml"] {
            std::os::unix::fs::symlink(repository(name), scratch.path().join(name)).unwrap();
        }
        let old = std::env::var_os("PATH").unwrap_or_default();
        let path = std::env::join_paths(bin.iter().cloned().chain(std::env::split_paths(&old))).unwrap();
        Self { scratch, path, packages }
    }

    fn run(&self, page: &str, block: &Block) {
        let mut command = match block.language.as_str() {
            "python" => Command::new("python"),
            _ => Command::new("bash"),
        };
        if block.language == "sh" {
            command.args(["-euo", "pipefail"]);
        }
        command.args(["-c", &block.code]).current_dir(self.scratch.path()).env("PATH", &self.path);
        command.env("POROPUNCH_CACHE", shared_runs());
        if let Some(packages) = &self.packages {
            command.env("PYTHONPATH", packages);
        }
        let started = std::time::Instant::now();
        let output = command.output().unwrap();
        let [said, error] = [output.stdout, output.stderr].map(|t| String::from_utf8_lossy(&t).into_owned());
        let line = block.line;
        assert!(output.status.success(), "{page}, line {line}:\n{}\n{said}\n{error}", block.code);
        println!("{page}, line {line}: {:.1} s", started.elapsed().as_secs_f64());
    }
}

/// The program that cargo built under its installed name, and the package over it.
fn built() -> (TempDir, Place) {
    let folder = tempfile::tempdir().unwrap();
    let bin = folder.path().join("bin");
    std::fs::create_dir(&bin).unwrap();
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_runner"), bin.join("poropunch")).unwrap();
    staged(folder.path());
    let own = python().parent().unwrap().to_owned();
    let place = Place::new(&[bin, own], Some(folder.path().to_owned()));
    (folder, place)
}

/// Pages of the site and README, from the repository's folder.
fn pages() -> Vec<String> {
    let entries = std::fs::read_dir(repository("runner/docs/pages")).unwrap();
    let names = entries.map(|e| e.unwrap().file_name().into_string().unwrap());
    let mut pages: Vec<String> =
        names.filter(|n| n.ends_with(".md")).map(|n| format!("runner/docs/pages/{n}")).collect();
    // READMEs that the site shows as they are.
    let list = std::fs::read_to_string(repository("runner/docs/readmes.txt")).unwrap();
    pages.extend(list.lines().filter_map(|line| line.split_whitespace().nth(1)).map(str::to_owned));
    pages.sort();
    pages
}

/// Runs the blocks of a page that have one of the marks, or none, if at least one has a mark that is demanded.
fn run_page(page: &str, place: &Place, marks: &[Mark], demanded: Option<Mark>) {
    let all = blocks(&std::fs::read_to_string(repository(page)).unwrap());
    if demanded.is_some_and(|mark| all.iter().all(|b| b.mark != mark)) {
        return;
    }
    let chosen = all.iter().filter(|b| b.mark == Mark::None || marks.contains(&b.mark));
    chosen.for_each(|block| place.run(page, block));
}

#[test]
fn short_commands() {
    for page in pages() {
        let (_folder, place) = built();
        run_page(&page, &place, &[], None);
    }
}

#[test]
#[ignore = "long: fits of the documentation that take a minute or more"]
fn long_commands() {
    for page in pages() {
        let (_folder, place) = built();
        run_page(&page, &place, &[Mark::Long], Some(Mark::Long));
    }
}

#[test]
#[ignore = "long: installs libcosimpy and ecospy from PyPI"]
fn importers() {
    let (folder, place) = built();
    let packages = ["fmpy==0.3.32", "libcosimpy", "ecospy", "tbb"];
    let bin = environment(folder.path(), &["--system-site-packages"], &packages);
    let place = Place::new(&[bin, folder.path().join("bin")], place.packages);
    run_page("runner/docs/pages/fmi.md", &place, &[Mark::Importers], Some(Mark::Importers));
}

#[test]
#[ignore = "long: compiles runner again with the features of the extension module, and installs from PyPI"]
fn pages_from_the_wheel() {
    let folder = tempfile::tempdir().unwrap();
    // What README's block for FMPy asks for in its first line.
    let bin = environment(folder.path(), &[], &["fmpy"]);
    for page in pages() {
        let place = Place::new(std::slice::from_ref(&bin), None);
        run_page(&page, &place, &[Mark::Wheel], Some(Mark::Wheel));
    }
}

#[test]
fn every_mark_is_known_and_has_its_reason() {
    for page in pages() {
        for block in blocks(&std::fs::read_to_string(repository(&page)).unwrap()) {
            let told = matches!(block.mark, Mark::None | Mark::Importers) || block.reason.len() > 5;
            assert!(told, "{page}, line {}: {:?} without a reason", block.line, block.mark);
        }
    }
}

/// A script of this repository that a block calls is one that a shell can run, though nobody runs the block.
#[test]
fn scripts_that_blocks_call_can_be_run() {
    use std::os::unix::fs::PermissionsExt;
    let mut seen = 0;
    for page in pages() {
        for block in blocks(&std::fs::read_to_string(repository(&page)).unwrap()) {
            let programs = block.code.lines().filter_map(|line| line.split_whitespace().next());
            let of_ours =
                |program: &&str| ["tests/", "runner/", "data/"].iter().any(|f| program.starts_with(f));
            for program in programs.filter(of_ours) {
                let place = format!("{page}, line {}: {program}", block.line);
                let script = std::fs::read(repository(program)).unwrap_or_else(|e| panic!("{place}: {e}"));
                let mode = std::fs::metadata(repository(program)).unwrap().permissions().mode();
                assert!(mode & 0o100 != 0 && script.starts_with(b"#!"), "{place} is no program");
                seen += 1;
            }
        }
    }
    assert!(seen >= 2, "{seen}");
}

#[test]
fn the_site_is_built_without_a_dead_link() {
    let folder = tempfile::tempdir().unwrap();
    let site = folder.path().join("site");
    let config = repository("runner/docs/mkdocs.yml");
    let mut command = Command::new(python());
    command.args(["-m", "mkdocs", "build", "--strict", "--quiet", "--config-file"]).arg(config);
    command.arg("--site-dir").arg(&site).env("POROPUNCH_PROGRAM", env!("CARGO_BIN_EXE_runner"));
    succeed(&mut command);
    let has = |file: &str, part: &str| {
        let text = std::fs::read_to_string(site.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert!(text.contains(part), "no {part} in {file}");
    };
    has("reference/parameters/index.html", "material.permeability");
    has("reference/command-line/index.html", "--validate");
    // Within its sentence.
    has("theory/index.html", "The shear modulus at small strain is\n<span><math");
}

/// A dead link must be seen, or the test above shows nothing.
#[test]
fn a_dead_link_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let copy = |from: &Path| {
        let to = folder.path().join("runner/docs").join(from.file_name().unwrap());
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(from, to).unwrap();
    };
    for name in ["mkdocs.yml", "hooks.py"] {
        copy(&repository("runner/docs").join(name));
    }
    std::fs::write(folder.path().join("runner/docs/readmes.txt"), "").unwrap();
    for (text, code) in [("[x](nowhere.md)", Some(1)), ("[x](https://example.org)", Some(0))] {
        let pages = folder.path().join("runner/docs/pages");
        std::fs::create_dir_all(&pages).unwrap();
        std::fs::write(pages.join("index.md"), format!("# A\n\n{text}\n")).unwrap();
        let mut command = Command::new(python());
        command.args(["-m", "mkdocs", "build", "--strict", "--quiet", "--config-file"]);
        command
            .arg(folder.path().join("runner/docs/mkdocs.yml"))
            .arg("--site-dir")
            .arg(folder.path().join("site"));
        command.env("POROPUNCH_PROGRAM", env!("CARGO_BIN_EXE_runner")).env("POROPUNCH_NAVIGATION", "no");
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), code, "{text}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

/// Each equation of the theory stands beside the file that holds it: the file names its number.
#[test]
fn theory_names_the_files_of_its_equations() {
    let page = "runner/docs/pages/theory.md";
    let text = std::fs::read_to_string(repository(page)).unwrap();
    let mut seen = 0;
    for section in text.split("\n## ").skip(1) {
        let Some((_, numbers)) = section.lines().next().unwrap().split_once("(Eq") else { continue };
        let link = section.split_once("](").unwrap().1.split(')').next().unwrap();
        let file = repository(page).parent().unwrap().join(link);
        let source = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        // `Eqs. 8, 9, 12` names three.
        let named: String =
            source.split("Eq").skip(1).filter_map(|part| part.split([')', ':', '`']).next()).collect();
        let digits = |text: &str| -> Vec<u32> {
            text.split(|c: char| !c.is_ascii_digit()).filter_map(|n| n.parse().ok()).collect()
        };
        for number in digits(numbers) {
            assert!(digits(&named).contains(&number), "{link} does not name Eq. {number}");
            seen += 1;
        }
    }
    assert!(seen >= 10, "{seen}");
}
