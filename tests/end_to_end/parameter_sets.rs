//! Parameter sets (SSV): `identify` writes one, `--parameters` takes one, other tools' included.
//!
//! Goal: what was identified is simulated again from the file alone; what is wrong in a file is told with file, line, parameter, unit
//! and remedy.
//! Reference: the same values by `--set`; the standard's schema and FMPy's reader.

use super::program::{column, directory, json, refuse, repository, succeed, text};
use std::path::Path;
use std::process::Command;

const GEOMETRY: &str = "geometry.punch_radius=2mm";

fn simulated(folder: &Path, name: &str, words: &[&str]) -> Vec<f64> {
    let out = folder.join(name);
    let given = ["simulate", "P2", "--points", "30", "--mesh", "coarse", "--out", text(&out)];
    succeed(&[given.as_slice(), words].concat());
    column(&out.with_extension("csv"), "force_mN")
}

/// A file in the form that OMSimulator writes: version 2.0, units by name only.
fn foreign(folder: &Path, unit: &str) -> std::path::PathBuf {
    let file = folder.join("foreign.ssv");
    let said = format!(
        "<?xml version='1.0' encoding='utf-8'?>\n\
         <ssv:ParameterSet xmlns:ssc=\"http://ssp-standard.org/SSP1/SystemStructureCommon\" \
         xmlns:ssv=\"http://ssp-standard.org/SSP1/SystemStructureParameterValues\" version=\"2.0\" name=\"parameters\">\n  \
         <ssv:Parameters>\n    <ssv:Parameter name=\"material.permeability\">\n      <ssv:Real value=\"1e-8\" unit=\"{unit}\"/>\n    \
         </ssv:Parameter>\n    <ssv:Parameter name=\"geometry.sample_height\">\n      <ssv:Real value=\"0.008\"/>\n    \
         </ssv:Parameter>\n    <ssv:Parameter name=\"engine.speed\">\n      <ssv:Real value=\"3.0\"/>\n    \
         </ssv:Parameter>\n  </ssv:Parameters>\n</ssv:ParameterSet>\n"
    );
    std::fs::write(&file, said).unwrap();
    file
}

#[test]
fn what_was_identified_is_simulated_again_from_its_file() {
    let d = directory();
    let (p2, out) = (repository("data/measurement/table1-one-cycle/P2.csv"), d.path().join("found"));
    let fitted =
        ["identify", text(&p2), "--mesh", "coarse", "--set", GEOMETRY, "--out", text(&out), "--jobs", "2"];
    succeed(&fitted);
    let set = out.join("parameters.ssv");
    let validated = succeed(&["validate", text(&p2), "--parameters", text(&set), "--json"]);
    let validated: serde_json::Value = serde_json::from_str(&validated).unwrap();
    let result = json(&out.join("result.json"));
    let (again, rms) = (&validated["tests"][0], &result["measurements"][0]["rms_mn"]);
    let gap = again["rms_mn"].as_f64().unwrap() / rms.as_f64().unwrap_or(f64::NAN) - 1.0;
    assert!(gap.abs() < 1e-6, "{again} {rms}");

    let python =
        std::env::var_os("POROPUNCH_PYTHON").map_or_else(|| repository(".venv/bin/python"), Into::into);
    let read =
        Command::new(python).arg(repository("tests/end_to_end/python/ssv.py")).arg(&set).output().unwrap();
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
    let read = String::from_utf8_lossy(&read.stdout).into_owned();
    for line in ["geometry.punch_radius\tReal\t0.002\tm", "mesh.preset\tEnumeration\tcoarse\t-"] {
        assert!(read.lines().any(|l| l == line), "no {line} in {read}");
    }
    assert!(
        read.lines().any(|l| l.starts_with("material.branch[1].eta\tReal\t") && l.ends_with("\tPa s")),
        "{read}"
    );
}

#[test]
fn a_set_of_another_tool_acts_as_the_same_settings_do() {
    let d = directory();
    let file = foreign(d.path(), "mm2");
    let by_file = simulated(d.path(), "a", &["--parameters", text(&file), "--set", GEOMETRY]);
    let set =
        ["--set", "material.permeability=1e-8mm^2", "--set", "geometry.sample_height=8mm", "--set", GEOMETRY];
    assert_eq!(by_file, simulated(d.path(), "b", &set));
    // What stands on the command line wins.
    let set = [&["--parameters", text(&file)], set.as_slice(), &["--set", "material.permeability=1e-9mm^2"]]
        .concat();
    assert_ne!(by_file, simulated(d.path(), "c", &set));
    // The job file that is kept repeats it, with the file's hash.
    let kept = std::fs::read_to_string(d.path().join("a.toml")).unwrap();
    assert!(kept.contains("foreign.ssv") && kept.contains("blake3"), "{kept}");
}

#[test]
fn complaints_name_file_parameter_unit_and_remedy() {
    let d = directory();
    let file = foreign(d.path(), "mm");
    let said =
        refuse(2, &["simulate", "P2", "--parameters", text(&file), "--out", text(&d.path().join("x"))]);
    for part in ["foreign.ssv", "line 4", "material.permeability", "`mm` is not a unit of Area", "known: m^2"]
    {
        assert!(said.contains(part), "no {part} in {said}");
    }
    // What was left out, and what was taken without a unit, is told before.
    for part in ["left out: engine.speed", "geometry.sample_height = 0.008 m"] {
        assert!(said.contains(part), "no {part} in {said}");
    }
    let said = refuse(2, &["simulate", "P2", "--parameters", text(&d.path().join("none.ssv"))]);
    assert!(said.contains("cannot be read"), "{said}");
    assert!(!d.path().join("x.csv").exists());
}
