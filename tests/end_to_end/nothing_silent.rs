//! Files of the user are safe, and nothing that a result rests on is kept silent.

use super::program::{
    column, directory, fail, json, one_line, refuse, repository, run, runner, succeed, text,
};
use super::third_party::{WIRING, bench, build, measurement};
use std::path::Path;
use std::process::{Command, Stdio};

/// A fit of one parameter of the quick third-party FMU.
fn quick_fit<'a>(data: &'a str, fmu: &'a str, out: &'a str) -> Vec<&'a str> {
    let mut arguments = vec!["identify", data, "--fmu", fmu, "--out", out];
    arguments.extend([
        "--free",
        "k_slow",
        "--bounds",
        "k_slow=0.1:100",
        "--set",
        "k_fast=8",
        "--set",
        "tau=1.2s",
    ]);
    arguments.extend(WIRING);
    arguments
}

/// The program, started in a directory of its own.
fn inside(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output = runner().current_dir(folder).args(arguments).output().expect("the program starts");
    let error = one_line(&String::from_utf8_lossy(&output.stderr));
    (output.status.code().unwrap_or(-1), error)
}

#[test]
fn a_measurement_is_never_overwritten_by_its_simulation() {
    let d = directory();
    let source = repository("data/measurement/table1-one-cycle/P2.csv");
    let (file, before) = (d.path().join("P2.csv"), std::fs::read(&source).expect("data"));
    std::fs::write(&file, &before).expect("a copy");
    let (code, error) = inside(d.path(), &["simulate", "P2.csv", "--mesh", "coarse"]);
    assert_eq!(code, 1, "{error}");
    assert!(error.contains("P2.csv") && error.contains("an input") && error.contains("--out"), "{error}");
    assert_eq!(std::fs::read(&file).expect("the file"), before);
    // A protocol's curve of the same name does not replace it either; poropunch's own curve is replaced.
    let (code, error) = inside(d.path(), &["simulate", "P2", "--mesh", "coarse", "--points", "10"]);
    assert!(code == 1 && error.contains("not written by poropunch"), "{error}");
    assert_eq!(std::fs::read(&file).expect("the file"), before);
    for points in ["10", "20"] {
        let arguments = ["simulate", "P1", "--mesh", "coarse", "--points", points];
        assert_eq!(inside(d.path(), &arguments).0, 0);
    }
    assert_eq!(column(&d.path().join("P1.csv"), "time_s").len(), 21);
    // What poropunch computed is told apart from what was measured.
    assert!(succeed(&["inspect", text(&d.path().join("P1.csv"))]).contains("SYNTHETIC"));
}

#[test]
fn a_series_of_fields_replaces_only_its_own() {
    let d = directory();
    let (pvd, out) = (d.path().join("P2.pvd"), d.path().join("curve"));
    std::fs::write(&pvd, "<VTKFile type=\"Collection\"/>").expect("a file");
    let base = ["simulate", "P2", "--mesh", "coarse", "--points", "10", "--out", text(&out)];
    let arguments = [&base[..], &["--fields", text(&pvd), "--fields-interval", "50"]].concat();
    assert!(fail(&arguments).contains("not written by poropunch"));
    std::fs::remove_file(&pvd).expect("removed");
    succeed(&arguments);
    succeed(&arguments);
    assert!(std::fs::read_to_string(&pvd).expect("a series").contains("<!-- written by poropunch"));
}

#[test]
fn a_directory_is_locked_and_holds_one_run() {
    let (d, fmu, data) = bench(3.0, 8.0, 1.2);
    let out = d.path().join("out");
    let fit = quick_fit(text(&data), text(&fmu), text(&out));
    let mut slow = Command::new(env!("CARGO_BIN_EXE_runner"));
    let slow = slow.args(&fit).args(["--set", "delay_ms=20"]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut first = slow.spawn().expect("the program starts");
    let list = out.join(".poropunch");
    while !list.exists() {
        assert!(first.try_wait().expect("its state").is_none(), "it ended without a list");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let error = refuse(1, &fit);
    assert!(error.contains(&format!("process {}", first.id())) && error.contains("--out"), "{error}");
    first.kill().expect("SIGKILL");
    first.wait().expect("its end");
    // The lock went with the process.
    succeed(&fit);
    let result = std::fs::read(out.join("result.json")).expect("a result");
    assert!(refuse(1, &["inspect", text(&data), "--out", text(&out)]).contains("files of `identify`"));
    // A new run that is killed leaves none of the old run's results.
    let mut again = Command::new(env!("CARGO_BIN_EXE_runner"));
    let again = again.args(&fit).args(["--set", "delay_ms=30"]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut again = again.spawn().expect("the program starts");
    while out.join("result.json").exists() {
        assert!(again.try_wait().expect("its state").is_none(), "it ended with the old result");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    again.kill().expect("SIGKILL");
    again.wait().expect("its end");
    assert!(!out.join("report.html").exists() && !result.is_empty());
}

#[test]
fn exit_codes_are_those_of_the_help() {
    let (d, fmu, data) = bench(3.0, 8.0, 1.2);
    let out = d.path().join("out");
    assert!(succeed(&["--help"]).contains("3 the fit did not converge"));
    let fit = quick_fit(text(&data), text(&fmu), text(&out));
    refuse(0, &fit);
    let printed = refuse(3, &[&fit[..], &["--start", "k_slow=90", "--max-evaluations", "1"]].concat());
    assert!(printed.contains("The fit did not converge"), "{printed}");
    assert!(
        json(&out.join("result.json"))["verdict"]["headline"]
            .as_str()
            .unwrap()
            .starts_with("The fit did not")
    );
    refuse(2, &[&fit[..], &["--weight", "holiday=2"]].concat());
    refuse(2, &[&fit[..], &["--set", "delay_ms"]].concat());
    std::fs::write(&data, "time_s,displacement_mm,force_mN\n0,0,0\n").expect("a file");
    refuse(4, &fit);
}

#[test]
fn absurd_numbers_are_wrong_use() {
    for (arguments, part) in [
        (vec!["simulate", "P2", "--points", "1e9"], "between 2 and 1000000"),
        (vec!["simulate", "P2", "-j", "100000"], "between 0 and"),
        (vec!["identify", "P2.csv", "--starts", "0"], "between 1 and"),
        (vec!["identify", "P2.csv", "--max-evaluations", "0"], "between 1 and"),
    ] {
        let error = refuse(2, &arguments);
        assert!(error.contains(part), "{error}");
    }
}

/// Goal: what has no end is not read, and nothing is left beside devices.
#[test]
#[cfg(unix)]
fn devices_are_neither_read_nor_written() {
    assert!(refuse(4, &["inspect", "/dev/zero"]).contains("it is a device"));
    assert!(refuse(2, &["batch", "/dev/zero", "--mesh", "coarse"]).contains("it is a device"));
    let base = ["simulate", "P2", "--mesh", "coarse", "--points", "5", "--out", "/dev/null"];
    assert!(refuse(2, &base).contains("it is a device"));
    assert!(!Path::new("/dev/null.csv").exists());
}

#[test]
fn options_that_act_on_nothing_are_told() {
    let d = directory();
    let (file, out) = (repository("data/measurement/table1-one-cycle/P2.csv"), d.path().join("out"));
    for (arguments, part) in [
        (vec!["simulate", text(&file), "--points", "7"], "--points belongs to P1 and P2"),
        (vec!["simulate", text(&file), "--cycles", "2"], "--cycles belongs to P1 and P2"),
        (vec!["identify", text(&file), "--seed", "3"], "nothing is drawn"),
        (vec!["identify", text(&file), "--fd-step", "0.1"], "acts on nothing"),
        (vec!["identify", text(&file), "--weight", "ramp=1e160"], "0 or from 0.000001 to 1000000"),
        (
            vec!["identify", text(&file), "--bounds", "material.permeability=1e-8:1e-10mm^2"],
            "lower bound 1.000e-8 mm^2 is not below upper bound 1.000e-10 mm^2",
        ),
        (
            vec!["identify", text(&file), "--set", "material.n0s=2"],
            "= 2 is outside its bounds [0.000001, 0.999]",
        ),
    ] {
        let more = ["--mesh", "coarse", "--out", text(&out)];
        let error = refuse(2, &[&arguments[..], &more].concat());
        assert!(error.contains(part), "{arguments:?}: {error}");
    }
    let quick =
        ["simulate", "P2", "--mesh", "coarse", "--points", "5", "--zero", "contact", "--out", text(&out)];
    assert!(refuse(0, &quick).contains("note: P2 is no file"));
}

/// Goal: two tests of one name keep their results apart. Set-up: the same file name in two directories, and one name for two files.
#[test]
fn tests_of_one_name_are_told_apart() {
    let d = directory();
    let (fmu, out) = (build(d.path()), d.path().join("out"));
    let files = ["a", "b"].map(|folder| d.path().join(folder).join("m.csv"));
    for (k, file) in files.iter().enumerate() {
        std::fs::create_dir(file.parent().expect("a directory")).expect("a directory");
        measurement(file, 3.0 + k as f64, 8.0, 1.2);
    }
    let base = ["validate", "--fmu", text(&fmu), "--noise", "none"];
    let common = [&base[..], &WIRING[..]].concat();
    let printed = succeed(&[&common[..], &["--out", text(&out), text(&files[0]), text(&files[1])]].concat());
    assert!(printed.contains("a_m ") && printed.contains("b_m "), "{printed}");
    assert!(out.join("a_m.csv").exists() && out.join("b_m.csv").exists() && !out.join("m.csv").exists());
    assert!(printed.lines().all(|line| line.chars().count() <= 80), "{printed}");
    let other = d.path().join("a/other.csv");
    measurement(&other, 5.0, 8.0, 1.2);
    let named = [&files[0], &other].map(|file| format!("gel={}", text(file)));
    let error = refuse(4, &[&common[..], &[&named[0], &named[1]]].concat());
    assert!(error.contains("a second test is called `a_gel`") && error.contains("remedy"), "{error}");
}

#[test]
#[cfg(unix)]
fn names_that_are_not_utf8_are_wrong_use() {
    use std::os::unix::ffi::OsStrExt;
    let name = std::ffi::OsStr::from_bytes(b"P\xff.csv");
    let output = runner().arg("inspect").arg(name).output().expect("the program starts");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && error.contains("not UTF-8; rename"), "{error}");
}

#[test]
fn what_was_assumed_stands_in_terminal_page_and_json() {
    let d = directory();
    let (file, out) = (d.path().join("m.csv"), d.path().join("out"));
    let source =
        std::fs::read_to_string(repository("data/measurement/table1-one-cycle/P2.csv")).expect("data");
    let rows: Vec<&str> = source.lines().take(60).collect();
    std::fs::write(&file, rows.join("\n") + "\n").expect("a file");
    let base = ["identify", text(&file), "--mesh", "coarse", "--out", text(&out), "--max-evaluations", "1"];
    let fit = ["--free", "material.branch[1].eta", "--set", "geometry.sample_radius=20mm", "--noise", "none"];
    let printed = refuse(3, &[&base[..], &fit[..]].concat());
    assert!(
        printed.starts_with("warning: punch radius 2 mm, sample height 10 mm: the defaults"),
        "{printed}"
    );
    assert!(printed.contains("given: geometry.sample_radius = 20 mm"), "{printed}");
    assert!(printed.contains("lambda star 100000 Pa"), "{printed}");
    let all = json(&out.join("result.json"))["assumptions"].as_array().expect("a list").clone();
    let row = |name: &str| all.iter().find(|a| a["name"] == name).unwrap_or_else(|| panic!("no {name}"));
    let radius = row("geometry.punch_radius");
    assert!(radius["value"] == "2" && radius["unit"] == "mm" && radius["given"] == false, "{radius}");
    assert_eq!(row("geometry.sample_radius")["given"], true);
    assert!(all.iter().all(|a| a["name"] != "material.branch[1].eta"), "what is fitted is not assumed");
    let page = std::fs::read_to_string(out.join("report.html")).expect("a page");
    assert!(page.contains("Given and assumed") && page.contains("geometry.punch_radius"));
    // A chi^2 far below one is no agreement.
    let spread: Vec<String> = source.lines().take(60).map(str::to_owned).collect();
    let wide = spread.iter().map(|l| {
        if l.starts_with('#') || l.starts_with('t') {
            l.clone()
        } else {
            let f: Vec<&str> = l.split(',').collect();
            format!("{},{},{},5", f[0], f[1], f[2])
        }
    });
    let header = |l: String| {
        if l.starts_with("time") { "time_s,displacement_mm,force_mN,force_std_mN".to_owned() } else { l }
    };
    std::fs::write(&file, wide.map(header).collect::<Vec<_>>().join("\n")).expect("a file");
    let fit = ["--free", "material.branch[1].eta", "--max-evaluations", "20"];
    let output = run(&[&base[..4], &["--out", text(&out)], &fit[..]].concat());
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(one_line(&printed).contains("far below one"), "{printed}");
}

#[test]
fn data_that_weigh_without_end_are_refused() {
    let d = directory();
    let (file, out) = (d.path().join("m.csv"), d.path().join("out"));
    let rows: String =
        (0..20).map(|i| format!("{},{},{},0\n", 0.1 * f64::from(i), 0.02 * f64::from(i), i)).collect();
    std::fs::write(&file, format!("time_s,displacement_mm,force_mN,force_std_mN\n{rows}")).expect("a file");
    let error = refuse(4, &["identify", text(&file), "--mesh", "coarse", "--out", text(&out)]);
    assert!(error.contains("m.csv") && error.contains("--noise none"), "{error}");
}

#[test]
fn a_resumed_diagnosis_needs_the_same_data_and_no_directory() {
    let d = directory();
    let (home, elsewhere) = (d.path().join("home"), d.path().join("elsewhere"));
    for folder in [&home, &elsewhere] {
        std::fs::create_dir(folder).expect("a directory");
    }
    let source =
        std::fs::read_to_string(repository("data/measurement/table1-one-cycle/P2.csv")).expect("data");
    std::fs::write(home.join("m.csv"), &source).expect("a file");
    let base = ["diagnose", "m.csv", "--mesh", "coarse", "--quick", "--max-evaluations", "2", "--out", "out"];
    assert_eq!(inside(&home, &base).0, 0);
    let (code, error) = inside(&elsewhere, &["diagnose", "--resume", "--out", "../home/out"]);
    assert_eq!(code, 0, "{error}");
    assert!(!elsewhere.join("out").exists() && !elsewhere.join("../home/out/out").exists());
    std::fs::write(home.join("m.csv"), source.replace("-0.0351", "-0.0361")).expect("a file");
    let (code, error) = inside(&elsewhere, &["diagnose", "--resume", "--out", "../home/out"]);
    assert!(code != 0 && error.contains("m.csv has changed"), "{error}");
}

#[test]
fn a_batch_keeps_the_parameters_and_its_names_apart() {
    let d = directory();
    let (fmu, sets, out) = (build(d.path()), d.path().join("sets.csv"), d.path().join("out"));
    let base = ["batch", text(&sets), "--fmu", text(&fmu), "--out", text(&out)];
    let arguments = [&base[..], &WIRING[..]].concat();
    for (name, part) in
        [("summary", "writes that itself"), ("Cache", "writes that itself"), ("a", "second run")]
    {
        std::fs::write(&sets, format!("name,k_slow\na,1\n{name},2\n")).expect("a file");
        let error = refuse(2, &arguments);
        assert!(error.contains("line 3") && error.contains(part), "{error}");
    }
    let rows: String = (1..=40).map(|i| format!("{i},{}\n", 100 * i)).collect();
    std::fs::write(&sets, format!("k_slow,tau [ms]\n{rows}")).expect("a file");
    succeed(&arguments);
    let summary = out.join("summary.csv");
    assert_eq!(column(&summary, "k_slow").len(), 40);
    assert_eq!(column(&summary, "tau [s]")[39], 4.0);
    let last = column(&summary, "last_force_mN");
    assert!((last[39] / last[0] - 40.0).abs() < 1e-3, "{last:?}");
    let curve = std::fs::read_to_string(out.join("0040.csv")).expect("a curve");
    assert!(curve.contains("# k_slow = 40, tau [s] = 4"), "{curve}");
    // A shorter table in the same place leaves nothing of the longer one.
    std::fs::write(&sets, "k_slow\n1\n").expect("a file");
    succeed(&arguments);
    assert!(out.join("0001.csv").exists() && !out.join("0040.csv").exists());
}

/// A protocol by its corners is followed as it is: the same force as from the built-in one.
#[test]
fn a_protocol_of_corners_is_no_noisy_recording() {
    let d = directory();
    let peak = |protocol: &str, out: &str| {
        let out = d.path().join(out);
        succeed(&["simulate", protocol, "--mesh", "coarse", "--out", text(&out)]);
        column(&out, "force_mN").into_iter().fold(0.0, f64::max)
    };
    let (from_file, built_in) =
        (peak(text(&repository("data/protocols/P2.csv")), "a.csv"), peak("P2", "b.csv"));
    assert!(built_in > 10.0 && (from_file / built_in - 1.0).abs() < 1e-3, "{from_file} {built_in}");
}
