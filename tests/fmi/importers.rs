//! F. The same input in two unrelated importers and in the native API: equal to 1e-12.
//!
//! P2 to 2 s on the coarse mesh. Reference: the native API, driven along the communication points and punch
//! displacements that the importer reports.

use super::support::{archive, archive3, get, python, read_rows, reference, rows, running_p2};
use poropunch::{Instance, Model};
use std::path::Path;
use std::process::Command;
use tests::{coarse, move_to};

/// Columns of importer.py: time, displacement, force, its solid and fluid part, stored energy.
type Row = Vec<f64>;

fn fmpy(way: &str, step: f64) -> Vec<Row> {
    let folder = tempfile::TempDir::new().unwrap();
    let out = folder.path().join("out.csv");
    python(&["simulate", archive().to_str().unwrap(), way, &step.to_string(), out.to_str().unwrap()]);
    read_rows(&out)
}

fn native(rows: &[Row]) -> Vec<Row> {
    let model = Model::new(coarse()).unwrap();
    let mut instance = Instance::new(&model, rows[0][1]).unwrap();
    let mut result = Vec::new();
    for pair in rows.windows(2) {
        move_to(&mut instance, pair[1][1], pair[1][0] - pair[0][0]);
        let o = instance.outputs();
        result.push(vec![pair[1][0], o.displacement, o.force, o.force_solid, o.force_fluid, o.stored_energy]);
    }
    result
}

/// Largest difference, relative to the largest value of the column.
fn difference(a: &[Row], b: &[Row]) -> f64 {
    assert_eq!(a.len(), b.len());
    let columns = 2..a[0].len();
    let worst = columns.map(|column| {
        let scale = b.iter().map(|row| row[column].abs()).fold(0.0, f64::max);
        a.iter().zip(b).map(|(x, y)| (x[column] - y[column]).abs() / scale).fold(0.0, f64::max)
    });
    worst.fold(0.0, f64::max)
}

/// Largest error of the force, relative to the largest force. Reference: the built-in protocol, whose corners
/// are exact whatever the steps.
fn input_error(rows: &[Row]) -> f64 {
    let mut instance = running_p2();
    let (mut scale, mut worst) = (0.0_f64, 0.0_f64);
    for pair in rows.windows(2) {
        instance.do_step(pair[0][0], pair[1][0] - pair[0][0]).unwrap();
        let force = get(&mut instance, "force");
        scale = scale.max(force);
        worst = worst.max((force - pair[1][2]).abs());
    }
    worst / scale
}

#[test]
fn fmpy_equals_the_native_api_in_three_ways_of_input() {
    for way in ["rate", "derivative"] {
        let rows = fmpy(way, 0.05);
        let worst = difference(&rows[1..], &native(&rows));
        println!("{way}: FMPy against native {worst:.1e}");
        assert!(worst < 1e-12, "{way}: {worst:e}");
    }
    // The trapezoid has its corner inside a step: 0.6875 s is no multiple of 0.05 s. The native API gets it too.
    let rows = fmpy("trapezoid", 0.0125);
    let worst = difference(&rows[1..], &native(&rows));
    println!("trapezoid: FMPy against native {worst:.1e}");
    assert!(worst < 1e-12, "trapezoid: {worst:e}");
}

#[test]
fn the_error_of_each_way_of_input_is_what_the_documentation_says() {
    let lag = [0.1, 0.01].map(|step| input_error(&fmpy("naive", step)));
    println!("displacement alone: {:.1} % at 0.1 s, {:.2} % at 0.01 s", 100.0 * lag[0], 100.0 * lag[1]);
    assert!(lag[0] > 0.05 && lag[1] > 0.005, "the trap must be real: {lag:?}");
    for way in ["rate", "derivative", "trapezoid"] {
        let error = input_error(&fmpy(way, 0.1));
        println!("{way}: {:.4} % at 0.1 s", 100.0 * error);
        assert!(error < 1e-3, "{way}: {error}");
    }
}

/// PyFMI, OMSimulator, fmuCheck, libcosim and ecos make no step of their own where the rate jumps: the corner, at 0.6875 s, must be
/// one of their communication points. Every number of steps of 1/16 s is; 0.1 s is not, and the punch goes too deep.
#[test]
fn where_masters_make_equal_steps_the_corner_must_be_one_of_their_points() {
    let [missed, met] = [0.1, 0.0625].map(|step| input_error(&fmpy("grid", step)));
    println!(
        "displacement and its rate on a grid: {:.2} % at 0.1 s, {:.4} % at 0.0625 s",
        100.0 * missed,
        100.0 * met
    );
    assert!(missed > 0.005, "the trap must be real: {missed}");
    assert!(met < 1e-9, "{met}");
}

/// libcosim and ecos, whose wheels PyPI has, know no enumerations and make equal steps.
#[test]
#[ignore = "long: installs importers from PyPI, needs Debian's libtbb12"]
fn libcosim_and_ecos_agree_with_fmpy() {
    let folder = tempfile::TempDir::new().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let succeed = |command: &mut Command| {
        let output = command.output().unwrap();
        assert!(output.status.success(), "{command:?}\n{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    succeed(Command::new("python3").args(["-m", "venv"]).arg(folder.path()));
    let program = folder.path().join("bin/python");
    let packages = ["fmpy==0.3.32", "libcosimpy==0.0.6", "ecospy==0.7.2"];
    succeed(Command::new(&program).args(["-m", "pip", "install", "--quiet"]).args(packages));
    let [fmpy, libcosim, ecos] = ["fmpy", "libcosimpy", "ecospy"].map(|name| -> Vec<f64> {
        let mut command = Command::new(&program);
        let said =
            succeed(command.arg(root.join("tests/fmi/python/others.py")).args([Path::new(name), archive()]));
        said.lines().filter_map(|line| line.strip_prefix("force ")?.parse().ok()).collect()
    });
    assert!(fmpy.len() == 32 && fmpy.iter().any(|force| *force > 0.01), "{fmpy:?}");
    let worst =
        |other: &[f64]| fmpy.iter().zip(other).map(|(a, b)| (a - b).abs() / 0.012).fold(0.0, f64::max);
    println!("libcosim {:.1e}, ecos {:.1e} from FMPy", worst(&libcosim), worst(&ecos));
    assert!(libcosim.len() == 32 && worst(&libcosim) < 1e-12);
    assert!(ecos.len() == 32 && worst(&ecos) < 1e-12);
}

/// fmi-rs, which shares nothing with FMPy nor with this project's loader, is built when it is needed.
#[test]
#[ignore = "long: builds a second importer"]
fn a_second_importer_agrees() {
    let folder = tempfile::TempDir::new().unwrap();
    let out = folder.path().join("out.csv");
    python(&["simulate", archive().to_str().unwrap(), "rate", "0.05", out.to_str().unwrap()]);
    let names = ["mesh.preset", "protocol.source", "displacement", "displacement_rate"];
    let results = ["force", "force_solid", "force_fluid", "stored_energy"];
    let references: Vec<String> =
        names.iter().chain(&results).map(|name| reference(name).to_string()).collect();
    // Value references are the same in both versions.
    for (fmu, version) in [(archive(), None), (archive3(), Some("3"))] {
        let output = Command::new(env!("CARGO"))
            .args(["run", "--release", "--quiet", "--package", "second-importer", "--"])
            .args([fmu, &out])
            .arg(references.join(","))
            .args(version)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let worst = difference(&rows(&String::from_utf8_lossy(&output.stdout)), &read_rows(&out)[1..]);
        println!("fmi-rs against FMPy, FMI {}: {worst:.1e}", version.unwrap_or("2"));
        assert!(worst < 1e-12, "{worst:e}");
    }
}

/// FMPy sets the path as a start value and ends the run with fmi2Terminate.
#[test]
fn fmpy_writes_fields() {
    let folder = tempfile::TempDir::new().unwrap();
    let pvd = folder.path().join("fields/P2.pvd");
    let printed = python(&["fields", archive().to_str().unwrap(), pvd.to_str().unwrap()]);
    let times: Vec<f64> = printed.split_whitespace().map(|time| time.parse().unwrap()).collect();
    println!("{} frames: {times:?}", times.len());
    assert!(times[0] == 0.0 && (times[times.len() - 1] - 2.0).abs() < 1e-9, "{times:?}");
    // The corner at 0.6875 s is a communication point.
    assert!(times.iter().any(|time| (time - 0.6875).abs() < 1e-9), "{times:?}");
    assert_eq!(std::fs::read_dir(pvd.with_extension("")).unwrap().count(), times.len());
}

#[test]
fn strange_paths_work_and_nothing_of_the_process_changes() {
    // Nothing is printed either: FMPy prints nothing without inputs, and we never do.
    assert_eq!(python(&["strange", archive().to_str().unwrap()]), "");
}

fn growth(command: &str, n: usize) -> f64 {
    let growth: f64 = python(&[command, archive().to_str().unwrap(), &n.to_string()]).trim().parse().unwrap();
    println!("{command} {n}: {growth:.2} MB");
    growth
}

#[test]
#[ignore = "long: nine seconds"]
fn simulating_and_loading_again_and_again_does_not_grow_the_host() {
    assert!(growth("many", 40) < 2.0);
    assert!(growth("loads", 100) < 2.0);
}

#[test]
#[ignore = "long: 2000 calls of simulate_fmu"]
fn two_thousand_simulations_do_not_grow_the_host() {
    assert!(growth("many", 2000) < 5.0);
}

#[test]
#[ignore = "long: 3000 loads"]
fn three_thousand_loads_do_not_grow_the_host() {
    assert!(growth("loads", 3000) < 5.0);
    assert!(Path::new(archive()).exists());
}
