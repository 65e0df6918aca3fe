//! The packaged FMU, instances of it, and Python.

use runner::fmi::{Fmu, FmuInstance, Version, builtin_library};
use runner::package::{Binary, lint_description, write_archive};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use tempfile::TempDir;

/// This machine's library.
pub fn own_library() -> [Binary; 1] {
    [Binary::of_this_machine(builtin_library().unwrap())]
}

/// The archive, packaged once per test run.
pub fn archive() -> &'static Path {
    static ARCHIVE: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    &ARCHIVE.get_or_init(|| package(Version::Two, "poropunch.fmu")).1
}

/// The archive of FMI 3.0.
pub fn archive3() -> &'static Path {
    static ARCHIVE: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    &ARCHIVE.get_or_init(|| package(Version::Three, "poropunch-fmi3.fmu")).1
}

fn package(version: Version, name: &str) -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    write_archive(version, &path, &own_library()).unwrap();
    (folder, path)
}

/// The packaged FMU, loaded once.
pub fn fmu() -> &'static Fmu {
    static FMU: OnceLock<Fmu> = OnceLock::new();
    FMU.get_or_init(|| Fmu::open(archive()).unwrap())
}

/// Value reference.
pub fn reference(name: &str) -> u32 {
    fmu().description().variable(name).unwrap().value_reference
}

/// Value reference of an instance of either version.
fn own_reference(instance: &FmuInstance, name: &str) -> u32 {
    instance.description().variable(name).unwrap().value_reference
}

pub fn set(instance: &mut FmuInstance, name: &str, value: f64) {
    let reference = own_reference(instance, name);
    instance.set_real(&[reference], &[value]).unwrap();
}

pub fn get(instance: &mut FmuInstance, name: &str) -> f64 {
    let reference = own_reference(instance, name);
    instance.get_real(&[reference]).unwrap()[0]
}

/// A coarse instance that follows the inputs, still to be initialised.
pub fn coarse() -> FmuInstance {
    let mut instance = fmu().instantiate("test").unwrap();
    choose_coarse(&mut instance);
    instance
}

pub fn choose_coarse(instance: &mut FmuInstance) {
    let choices = ["mesh.preset", "protocol.source"].map(|name| own_reference(instance, name));
    instance.set_integer(&choices, &[1, 1]).unwrap();
}

pub fn initialise(instance: &mut FmuInstance, stop_time: Option<f64>) {
    instance.setup_experiment(0.0, stop_time).unwrap();
    instance.enter_initialization_mode().unwrap();
    instance.exit_initialization_mode().unwrap();
}

/// A coarse instance ready to step.
pub fn running() -> FmuInstance {
    let mut instance = coarse();
    initialise(&mut instance, None);
    instance
}

/// A coarse instance ready to step along the built-in P2.
pub fn running_p2() -> FmuInstance {
    let mut instance = coarse();
    instance.set_integer(&[reference("protocol.source")], &[2]).unwrap();
    initialise(&mut instance, None);
    instance
}

/// Loads at 1 mm/s over `steps` steps of `size` (s) from `start`; force after each, as bits.
pub fn load(instance: &mut FmuInstance, start: f64, size: f64, steps: usize) -> Vec<u64> {
    let mut forces = Vec::with_capacity(steps);
    for n in 0..steps {
        let time = start + n as f64 * size;
        set(instance, "displacement", 1e-3 * (time + size));
        instance.do_step(time, size).unwrap();
        forces.push(get(instance, "force").to_bits());
    }
    forces
}

/// Every step that makes no sense is an error that tells its reason, and a reset leads out of it.
pub fn check_bad_steps(running: impl Fn() -> FmuInstance, function: &str) {
    let expected = load(&mut running(), 0.0, 0.1, 3);
    for (time, size) in
        [(0.0, 0.0), (0.0, -0.1), (0.0, f64::NAN), (0.0, f64::INFINITY), (f64::NAN, 0.1), (1.0, 0.1)]
    {
        let mut instance = running();
        let error = instance.do_step(time, size).unwrap_err().to_string();
        assert!(error.contains(function) && !error.contains("no reason"), "{error}");
        instance.do_step(0.0, 0.1).expect_err("in state error until Reset");
        instance.reset().unwrap();
        choose_coarse(&mut instance);
        initialise(&mut instance, None);
        assert_eq!(load(&mut instance, 0.0, 0.1, 3), expected);
    }
}

/// A thousand steps repeat bit for bit from a saved state, and in a fresh instance from its bytes.
pub fn check_states(mut instance: FmuInstance, mut fresh: FmuInstance) {
    load(&mut instance, 0.0, 0.1, 2);
    let state = instance.get_state().unwrap();
    let bytes = instance.serialize_state(&state).unwrap();
    let first = load(&mut instance, 0.2, 5e-4, 1000);
    instance.set_state(&state).unwrap();
    assert_eq!(load(&mut instance, 0.2, 5e-4, 1000), first, "set_state");
    // The parameters are among the bytes.
    let read = fresh.deserialize_state(&bytes).unwrap();
    fresh.set_state(&read).unwrap();
    assert_eq!(load(&mut fresh, 0.2, 5e-4, 1000), first, "deserialised");
    instance.free_state(state).unwrap();
}

/// The same library gives the same archive to the byte, and in it are these files; returns it, read.
pub fn check_contents(
    version: Version,
    archive: &Path,
    expected: &[&str],
) -> zip::ZipArchive<Cursor<Vec<u8>>> {
    let bytes = std::fs::read(archive).unwrap();
    let again = tempfile::TempDir::new().unwrap();
    let path = again.path().join("again.fmu");
    write_archive(version, &path, &own_library()).unwrap();
    assert!(std::fs::read(&path).unwrap() == bytes, "two archives of the same contents differ");
    let zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let names: Vec<_> = zip.file_names().map(|name| name.unwrap().into_owned()).collect();
    for file in expected {
        assert!(names.iter().any(|name| name == file), "{file} is missing in {names:?}");
    }
    zip
}

/// The lint finds every planted problem: descriptions, all made from `good`, with a part of what it shall say.
pub fn check_lint(good: &str, planted: impl IntoIterator<Item = (String, &'static str)>) {
    let of_both = [
        (good.replacen("valueReference=\"1\"", "valueReference=\"0\"", 1), "value reference 0 is used twice"),
        (good.replacen("start=\"0.032\"", "start=\"-1.0\"", 1), "outside its own range"),
        (good.replacen(" start=\"0.032\"", "", 1), "no start value"),
        (good.replacen("name=\"force_solid\"", "name=\"force\"", 1), "the name is used twice"),
        (good.replacen("Unit name=\"N\"", "Unit name=\"kN\"", 1), "its unit is not defined"),
        (good.replacen(" dependencies=\"\"", "", 1), "no dependencies"),
        (good.replacen(" tolerance=", " notTolerance=", 1), "DefaultExperiment: no tolerance"),
    ];
    for (xml, expected) in of_both.into_iter().chain(planted) {
        assert_ne!(xml, good, "nothing planted for: {expected}");
        let problems = lint_description(&xml).unwrap();
        assert!(problems.iter().any(|p| p.contains(expected)), "not found: {expected}; found {problems:?}");
    }
}

/// Resident memory of this process [MB].
pub fn resident_mb() -> f64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap();
    statm.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap() * 4096e-6
}

/// Runs `importer.py`; returns its standard output.
pub fn python(arguments: &[&str]) -> String {
    script("importer.py", arguments)
}

/// The same of `fmi3.py`.
pub fn python3(arguments: &[&str]) -> String {
    script("fmi3.py", arguments)
}

/// The same of another file beside it.
pub fn script(name: &str, arguments: &[&str]) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let python = std::env::var_os("POROPUNCH_PYTHON").map_or(root.join(".venv/bin/python"), PathBuf::from);
    let ready = Command::new(&python).args(["-c", "import fmpy, lxml, numpy"]).output();
    assert!(
        ready.is_ok_and(|output| output.status.success()),
        "{} with FMPy is missing. Remedy: python3 -m venv .venv && .venv/bin/pip install -r tests/requirements.txt \
         in the repository's folder, or set POROPUNCH_PYTHON to a Python that has these packages",
        python.display()
    );
    let script = root.join("tests/fmi/python").join(name);
    let output = Command::new(&python).arg(script).args(arguments).output().unwrap();
    let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{name} {arguments:?}\n{stdout}\n{stderr}");
    stdout.into_owned()
}

/// Rows of numbers of a CSV file without a header.
pub fn read_rows(path: &Path) -> Vec<Vec<f64>> {
    rows(&std::fs::read_to_string(path).unwrap())
}

/// The same of its text.
pub fn rows(text: &str) -> Vec<Vec<f64>> {
    text.lines().map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect()
}
