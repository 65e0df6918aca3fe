//! `simulate --fields`: the series as a reader of VTK's files sees it.

use super::program::{directory, fail, repository, succeed, text};
use super::third_party;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What the Python half compares with.
const RECORD: &str = "force_fluid,viscous_dissipation_rate,porous_dissipation_rate";

/// Opens the series with meshio and holds it against the curve; returns what the script printed.
fn check(pvd: &Path, csv: &Path) -> String {
    let python = std::env::var_os("POROPUNCH_PYTHON");
    let python = python.map_or_else(|| repository(".venv/bin/python"), PathBuf::from);
    let script = repository("tests/end_to_end/python/fields.py");
    let output = Command::new(&python).arg(script).args([pvd, csv]).output().unwrap_or_else(|e| {
        panic!(
            "{}: {e}. Remedy: python3 -m venv .venv && .venv/bin/pip install -r tests/requirements.txt in the \
             repository's folder, or set POROPUNCH_PYTHON to a Python that has these packages",
            python.display()
        )
    });
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Number of frames that a series lists; its folder holds no others.
fn frames(pvd: &Path) -> usize {
    let listed = std::fs::read_to_string(pvd).expect("a series").matches("<DataSet").count();
    assert_eq!(std::fs::read_dir(pvd.with_extension("")).expect("its folder").count(), listed);
    listed
}

#[test]
fn p2_opens_in_a_vtk_reader_and_agrees_with_the_curve() {
    let d = directory();
    let (plain, out, fields) =
        (d.path().join("plain.csv"), d.path().join("with.csv"), d.path().join("some ü fields"));
    let p2 = |out: &Path, more: &[&str]| {
        let base = ["simulate", "P2", "--mesh", "coarse", "--record", RECORD, "--out", text(out)];
        succeed(&[&base[..], more].concat())
    };
    p2(&plain, &[]);
    let printed = p2(&out, &["--fields", text(&fields)]);
    let pvd = fields.join("P2.pvd");
    assert!(printed.contains("P2.pvd") && printed.contains("ParaView"), "{printed}");
    let read = |file| std::fs::read(file).expect("a curve");
    assert!(read(&plain) == read(&out), "writing fields changes no digit of the curve");
    println!("{}", check(&pvd, &out));
    let many = frames(&pvd);

    // A shorter series in the same place leaves nothing of the longer one.
    p2(&out, &["--fields", text(&pvd), "--fields-interval", "10"]);
    assert!((9..12).contains(&frames(&pvd)) && many > 12);
}

#[test]
fn fields_that_cannot_be_written_are_errors_with_a_remedy() {
    let d = directory();
    let (file, out) = (d.path().join("file"), d.path().join("out"));
    std::fs::write(&file, "mine").expect("a file");
    let p2 = |mesh, more: &[&str]| {
        fail(&[&["simulate", "P2", "--mesh", mesh, "--out", text(&out)], more].concat())
    };
    let error = p2("coarse", &["--fields", text(&file.join("below"))]);
    assert!(error.contains("file/below") && error.contains("fields.path"), "{error}");
    assert_eq!(std::fs::read(&file).expect("the file"), b"mine");
    let error = p2("paper-3d", &["--fields", text(&out)]);
    assert!(error.contains("paper-3d") && error.contains("axisymmetric"), "{error}");
    assert!(!out.exists(), "nothing is left of it");
    let error = p2("coarse", &["--set", "fields.path=x"]);
    assert!(error.contains("--fields PATH"), "{error}");

    let (fmu, data) = (third_party::build(d.path()), d.path().join("m.csv"));
    third_party::measurement(&data, 4.0, 6.0, 2.0);
    let base = ["simulate", text(&data), "--fmu", text(&fmu), "--fields", text(&out)];
    let error = fail(&[&base[..], &third_party::WIRING].concat());
    assert!(error.contains("fields.path") && error.contains("poropunch"), "{error}");
}
