//! F. The libraries of all platforms give the curve of this one.
//!
//! Goal: Windows' library under Wine and 64-bit arm's under QEMU, loaded by a host in C (`host.c`, which also saves and restores
//! states and hears the logger), give what this machine's gives: P2 with its hold on the coarse mesh, sensitivities too.
//! Set-up: `cdylib/build-all` makes the archive; its zig compiles the host. Wine, QEMU and arm's C library are Debian's packages.
//! macOS' cannot be run here: `macos.rs` looks at what can be seen of it.

mod macos;

use super::support::reference;
use poropunch::model_description::guid;
use runner::fmi::builtin_library;
use runner::package::lint;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use tempfile::TempDir;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
const SIZE: f64 = 0.0625;
/// The force and its parts, energy, four sensitivities.
const PRINTED: [&str; 8] = [
    "force",
    "force_solid",
    "force_fluid",
    "stored_energy",
    "sensitivity.force.material.permeability",
    "sensitivity.force.material.equilibrium.mu",
    "sensitivity.force.material.branch[1].mu",
    "sensitivity.force.material.branch[1].eta",
];

/// Runs to the end and demands success; returns what it printed.
fn succeed(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|e| panic!("{command:?}: {e}"));
    let [said, error] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(output.status.success(), "{command:?}\n{said}\n{error}");
    said
}

/// The archive for all platforms, unpacked, checked as it was written.
fn everywhere() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    FOLDER
        .get_or_init(|| {
            let folder = TempDir::new().unwrap();
            let archive = folder.path().join("poropunch.fmu");
            succeed(Command::new(format!("{ROOT}/cdylib/build-all")).arg(&archive));
            let problems = lint(&archive).unwrap();
            assert_eq!([problems.own, problems.elsewhere].concat(), Vec::<String>::new());
            zip::ZipArchive::new(std::fs::File::open(&archive).unwrap())
                .unwrap()
                .extract(folder.path())
                .unwrap();
            folder
        })
        .path()
}

fn library(platform: &str, suffix: &str) -> PathBuf {
    everywhere().join(format!("binaries/{platform}/poropunch{suffix}"))
}

/// `host.c` for a target of zig.
fn host(target: &str, name: &str) -> PathBuf {
    compile(target, "host.c", name, &[])
}

fn compile(target: &str, source: &str, name: &str, arguments: &[&str]) -> PathBuf {
    let to = everywhere().join(name);
    let tools =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| Path::new(ROOT).join("target"), Into::into);
    let mut zig = Command::new(tools.join("build-all/bin/python"));
    zig.args(["-m", "ziglang", "cc", "-O1", "-target", target, "-o"]).arg(&to);
    succeed(zig.arg(format!("{ROOT}/tests/fmi/platforms/{source}")).args(arguments));
    to
}

/// Rows of time and what is printed, after `steps` steps.
fn curve(program: &mut Command, library: &Path, steps: usize) -> Vec<Vec<f64>> {
    program.arg(library).arg(guid()).args([steps.to_string(), SIZE.to_string()]);
    let chosen = ["mesh.preset", "solver.sensitivities", "material.n0s"];
    program.args(chosen.iter().chain(&PRINTED).map(|name| reference(name).to_string()));
    super::support::rows(&succeed(program))
}

/// Largest difference of each column, relative to its largest value.
fn differences(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<f64> {
    assert_eq!(a.len(), b.len());
    let column = |column: usize| {
        let scale = b.iter().map(|row| row[column].abs()).fold(0.0, f64::max);
        a.iter().zip(b).map(|(x, y)| (x[column] - y[column]).abs() / scale).fold(0.0, f64::max)
    };
    (1..b[0].len()).map(column).collect()
}

/// This machine's, as cargo built it for this test.
fn native(steps: usize) -> Vec<Vec<f64>> {
    curve(&mut Command::new(host("x86_64-linux-gnu.2.17", "host")), &builtin_library().unwrap(), steps)
}

/// Bounds of the force's difference, and of that of everything else.
fn check(name: &str, found: &[Vec<f64>], force: f64, others: f64) {
    let worst = differences(found, &native(found.len()));
    let printed: Vec<_> = worst.iter().map(|d| format!("{d:.1e}")).collect();
    println!("{name}, {} steps: {}", found.len(), printed.join(" "));
    assert!(worst[0] <= force, "{name}");
    assert!(worst[1..].iter().all(|&d| d <= others), "{name}");
}

#[test]
#[ignore = "long: builds the libraries of all platforms"]
fn for_old_linux_the_curve_is_the_same() {
    let mut program = Command::new(host("x86_64-linux-gnu.2.17", "host"));
    check("linux64", &curve(&mut program, &library("linux64", ".so"), 1440), 0.0, 0.0);
}

#[test]
#[ignore = "long: builds the libraries of all platforms, needs Wine"]
fn for_windows_the_curve_is_the_same() {
    // Debian 12's Wine lacks this library of Windows, which Rust's standard library takes random numbers from.
    compile("x86_64-windows-gnu", "bcryptprimitives.c", "bcryptprimitives.dll", &["-shared", "-ladvapi32"]);
    let program = host("x86_64-windows-gnu", "host.exe");
    let mut wine = Command::new("wine");
    wine.arg(program).env("WINEDEBUG", "-all").env("WINEPREFIX", everywhere().join("wine"));
    wine.current_dir(everywhere());
    check("win64", &curve(&mut wine, &library("win64", ".dll"), 1440), 1e-12, 1e-12);
}

#[test]
#[ignore = "long: builds the libraries of all platforms, needs QEMU"]
fn for_arm_the_curve_is_the_same() {
    let mut qemu = Command::new("qemu-aarch64-static");
    qemu.args(["-L", "/usr/aarch64-linux-gnu"]).arg(host("aarch64-linux-gnu.2.17", "host-arm"));
    // Sums over vectors of another length have other last bits, of which the step control makes other sizes of the steps: the
    // parts of the force and the derivatives feel it more than the force.
    check("aarch64-linux", &curve(&mut qemu, &library("aarch64-linux", ".so"), 32), 1e-12, 1e-10);
}
