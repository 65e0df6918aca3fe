//! Somebody else's FMU: other names, other units, no input derivatives, plain C.

use super::program::{column, directory, fail, json, succeed, text};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Input and output of the third-party FMU on the command line.
pub const WIRING: [&str; 4] = ["--input", "indent", "--output", "load"];

/// The FMU on the command line, with its input and output.
pub fn wired(fmu: &Path) -> Vec<&str> {
    [&["--fmu", text(fmu)], &WIRING[..]].concat()
}

/// A directory with the FMU and a measurement of that solid: the directory, and the places of both.
pub fn bench(slow: f64, fast: f64, tau: f64) -> (TempDir, PathBuf, PathBuf) {
    let d = directory();
    let (fmu, data) = (build(d.path()), d.path().join("m.csv"));
    measurement(&data, slow, fast, tau);
    (d, fmu, data)
}

/// Compiles the FMU into `directory`; returns its folder.
pub fn build(directory: &Path) -> PathBuf {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/end_to_end/third_party");
    let fmu = directory.join("solid");
    let binaries = fmu.join("binaries").join("linux64");
    std::fs::create_dir_all(&binaries).expect("a folder");
    std::fs::copy(source.join("modelDescription.xml"), fmu.join("modelDescription.xml")).expect("a copy");
    let status = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", "-o"])
        .arg(binaries.join("solid.so"))
        .arg(source.join("solid.c"))
        .arg("-lm")
        .status()
        .expect("a C compiler called cc (Rust needs one too)");
    assert!(status.success());
    fmu
}

/// Force (mN) of the standard linear solid (stiffnesses in mN/mm) under a ramp to 1 mm in 1 s and a hold.
pub fn exact(time: f64, slow: f64, fast: f64, tau: f64) -> f64 {
    let ramp = time.min(1.0);
    let loading = fast * tau * (1.0 - (-ramp / tau).exp());
    slow * ramp + loading * (-(time - ramp) / tau).exp()
}

/// A measurement of that solid, written to a file.
pub fn measurement(file: &Path, slow: f64, fast: f64, tau: f64) {
    let mut csv = "# synthetic: closed form\ntime_s,displacement_mm,force_mN\n".to_owned();
    let times = (0..=20).map(|i| 0.05 * f64::from(i)).chain((1..=30).map(|i| 1.0 + 0.3 * f64::from(i)));
    for t in times {
        let _ = writeln!(csv, "{t},{},{}", t.min(1.0), exact(t, slow, fast, tau));
    }
    std::fs::write(file, csv).expect("a file");
}

#[test]
fn simulate_follows_the_closed_form_in_its_own_units() {
    let (d, fmu, data) = bench(4.0, 6.0, 2.0);
    let out = d.path().join("curve");
    succeed(&[&["simulate", text(&data), "--fmu", text(&fmu), "--out", text(&out)], &WIRING[..]].concat());
    let csv = out.with_extension("csv");
    let (times, forces) = (column(&csv, "time_s"), column(&csv, "force_mN"));
    assert_eq!(times.len(), 51);
    for (t, f) in times.iter().zip(&forces) {
        let expected = exact(*t, 4.0, 6.0, 2.0);
        // The input is held over steps of 0.5 % of the depth.
        assert!((f - expected).abs() < 0.05, "{t}: {f} instead of {expected}");
    }
    assert!(std::fs::read_to_string(out.with_extension("svg")).expect("a plot").contains("<svg"));
}

#[test]
fn identify_recovers_its_parameters() {
    let (d, fmu, data) = bench(3.0, 8.0, 1.2);
    let out = d.path().join("out");
    let fit = ["--free", "k_slow,k_fast,tau", "--bounds", "k_slow=0.1:100", "--bounds", "k_fast=0.1:100"];
    let more = ["--bounds", "tau=50ms:50s", "--out", text(&out), "--fmu", text(&fmu)];
    succeed(&[&["identify", text(&data)], &fit[..], &more[..], &WIRING[..]].concat());
    let result = json(&out.join("result.json"));
    for (name, expected) in [("k_slow", 3.0), ("k_fast", 8.0), ("tau", 1.2)] {
        let rows = result["parameters"].as_array().expect("rows");
        let row = rows.iter().find(|r| r["name"] == name).expect("the parameter");
        let value = row["value"].as_f64().expect("a number");
        assert!((value / expected - 1.0).abs() < 0.01, "{name} = {value} instead of {expected}");
    }
}

#[test]
fn missing_names_units_and_bounds_are_explained() {
    let (_d, fmu, data) = bench(3.0, 8.0, 1.2);
    let base = ["identify", text(&data), "--fmu", text(&fmu)];
    let with = |more: &[&str]| fail(&[&base[..], more].concat());
    let error = with(&[]);
    assert!(error.contains("no input called `displacement`") && error.contains("indent"), "{error}");
    let error = with(&["--input", "indent:Pa", "--output", "load"]);
    assert!(error.contains("`Pa` of `indent`"), "{error}");
    let error = with(&WIRING);
    assert!(error.contains("--free"), "{error}");
    let error = with(&[&WIRING[..], &["--free", "tau"]].concat());
    assert!(error.contains("tau has no bounds") && error.contains("--bounds tau=LOWER:UPPER"), "{error}");
    let error = with(&[&WIRING[..], &["--free", "taw"]].concat());
    assert!(error.contains("did you mean tau"), "{error}");
    let error = with(&[&WIRING[..], &["--free", "tau", "--bounds", "tau=3:9s"]].concat());
    assert!(error.contains("outside its bounds"), "{error}");
}

/// Goal: an effect that the user declares for somebody else's FMU is found in the data. Set-up: the solid's force and a load cell that
/// creeps by 0.08 mN/s, noise of 0.01 mN; the plain model has no creep. Reference: the creep that was put in.
#[test]
fn a_declared_effect_explains_its_gap() {
    let d = directory();
    let (fmu, data, out) = (build(d.path()), d.path().join("m.csv"), d.path().join("out"));
    let mut csv = "time_s,displacement_mm,force_mN\n".to_owned();
    let times = (0..=20).map(|i| 0.05 * f64::from(i)).chain((1..=90).map(|i| 1.0 + 0.2 * f64::from(i)));
    for (k, t) in times.enumerate() {
        let noise = 0.01 * [1.0, -0.5, 0.3, -1.2, 0.6, -0.9, 1.4][k % 7];
        let _ = writeln!(csv, "{t},{},{}", t.min(1.0), exact(t, 4.0, 6.0, 2.0) + 0.08 * t + noise);
    }
    std::fs::write(&data, csv).expect("a file");
    let free = ["--free", "k_slow,k_fast,tau", "--bounds", "k_slow=0.1:100", "--bounds", "k_fast=0.1:100"];
    let more = [
        "--bounds",
        "tau=50ms:50s",
        "--out",
        text(&out),
        "--fmu",
        text(&fmu),
        "--tare",
        "none",
        "--zero",
        "0",
    ];
    let effects = ["--effect", "creep of the load cell=creep:0:0.05", "--effect", "stiffer=k_limit:1e9:1e8"];
    let printed =
        succeed(&[&["diagnose", text(&data)], &free[..], &more[..], &effects, &WIRING[..]].concat());
    assert!(printed.contains("creep of the load cell"), "{printed}");
    let found = json(&out.join("diagnosis.json"));
    assert_eq!(found["verdict"]["effects"], serde_json::json!(["creep of the load cell"]), "{printed}");
    let size =
        found["effects"].as_array().unwrap().iter().find(|e| e["name"] == "creep of the load cell").unwrap();
    assert_eq!(size["place"], "declared");
    let bad = ["diagnose", text(&data), "--fmu", text(&fmu), "--effect", "x=crep:0:1", "--out", text(&out)];
    let error = fail(&[&bad[..], &WIRING[..]].concat());
    assert!(error.contains("--effect x=crep:0:1") && error.contains("creep"), "{error}");
}
