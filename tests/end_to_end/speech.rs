//! What the program says to programs and to people: JSON on standard output, JSON lines of progress, schemas, lines of 80
//! characters, completions and manual pages.

use super::lag;
use super::program::{self, directory, json, repository, run, shared_runs, sharing_runner, succeed, text};
use super::third_party::{bench, wired};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

const P2: &str = "data/measurement/table1-one-cycle/P2.csv";
const SCHEMAS: [&str; 11] = [
    "job",
    "result",
    "diagnosis",
    "inspection",
    "simulation",
    "validation",
    "batch",
    "study-unit",
    "study-result",
    "study-status",
    "study-population",
];

pub fn committed(name: &str) -> std::path::PathBuf {
    repository(&format!("runner/schemas/{name}.schema.json"))
}

/// A JSON against a schema, by the reference implementation of Python.
pub fn validate(instance: &Path, schema: &Path) {
    let python = std::env::var_os("POROPUNCH_PYTHON");
    let python = python.map_or_else(|| repository(".venv/bin/python"), Into::into);
    let code = "import json, sys, jsonschema\n\
                schema = json.load(open(sys.argv[2]))\n\
                jsonschema.Draft202012Validator.check_schema(schema)\n\
                text = open(sys.argv[1]).read()\n\
                import tomllib\n\
                data = tomllib.loads(text) if sys.argv[1].endswith('.toml') else json.loads(text)\n\
                jsonschema.validate(data, schema)\n";
    let output = Command::new(&python).args(["-c", code]).arg(instance).arg(schema).output();
    let output = output.unwrap_or_else(|e| panic!("{}: {e}; tests/run installs it", python.display()));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn schemas_are_current() {
    for name in SCHEMAS {
        let printed = succeed(&["schema", name]);
        let file = committed(name);
        let kept = std::fs::read_to_string(&file).unwrap_or_default();
        let remedy = format!("stale: target/release/runner schema {name} > {}", file.display());
        assert!(printed == kept, "{remedy}");
    }
}

/// Goal: what is written is what the schemas say, and `--json` prints the same.
#[test]
fn results_follow_their_schemas() {
    let (d, fmu, data) = bench(3.0, 8.0, 1.2);
    let wired = wired(&fmu);
    let bounds = ["k_slow=0.1:100", "k_fast=0.1:100", "tau=0.05:50s"].map(|b| ["--bounds", b]).concat();
    let follows = |name: &str, file: Option<&Path>, stdout: &[u8]| {
        let printed: Value = serde_json::from_slice(stdout).expect("one JSON");
        let kept = d.path().join(format!("{name}.json"));
        std::fs::write(&kept, stdout).unwrap();
        validate(&kept, &committed(name));
        if let Some(file) = file {
            let mut written = json(file);
            assert!(written.as_object_mut().unwrap().remove("written_by").is_some());
            assert_eq!(written, printed, "{name}");
            validate(file, &committed(name));
        }
    };
    let check = |name: &str, file: &str, arguments: &[&str]| {
        let output = run(&[arguments, &["--json"]].concat());
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {error}");
        let file = (!file.is_empty()).then(|| d.path().join(file));
        follows(name, file.as_deref(), &output.stdout);
    };
    let out = |name: &str| text(&d.path().join(name)).to_owned();
    let (fit, seen, sets, table) = (out("fit"), out("seen"), out("sets.csv"), out("table"));
    let free = ["--free", "k_slow,k_fast,tau", "--out", &fit];
    check("result", "fit/result.json", &[&["identify", text(&data)], &free[..], &bounds, &wired].concat());
    check("inspection", "seen/inspection.json", &["inspect", text(&data), "--out", &seen]);
    check("simulation", "", &[&["simulate", text(&data), "--out", &out("curve")], &wired[..]].concat());
    check("validation", "", &[&["validate", text(&data)], &wired[..]].concat());
    std::fs::write(&sets, "k_slow\n3\n4\n").unwrap();
    let batch = ["batch", &sets, "--protocol", text(&data), "--out", &table];
    check("batch", "", &[&batch[..], &wired].concat());
    let lag = lag::diagnosed();
    follows("diagnosis", Some(&lag.folder.join("diagnosis.json")), &lag.json);
    for kept in [d.path().join("fit"), d.path().join("seen"), d.path().join("table"), lag.folder.clone()] {
        validate(&kept.join("poropunch.toml"), &committed("job"));
    }
}

#[test]
fn progress_is_one_json_per_line() {
    let (d, fmu, data) = bench(3.0, 8.0, 1.2);
    let wired = wired(&fmu);
    let out = d.path().join("fit");
    let asked =
        ["identify", text(&data), "--free", "k_slow", "--bounds", "k_slow=0.1:100", "--out", text(&out)];
    let output = run(&[&asked[..], &["--json", "--progress", "json"], &wired].concat());
    assert!(output.status.success());
    let lines = String::from_utf8_lossy(&output.stderr).into_owned();
    let events: Vec<Value> =
        lines.lines().map(|l| serde_json::from_str(l).unwrap_or_else(|e| panic!("{e}: {l}"))).collect();
    let steps: Vec<&Value> = events.iter().filter(|e| e["event"] == "iteration").collect();
    assert!(steps.len() > 1 && steps.iter().all(|s| s["chi_square"].is_number() && s["runs"].is_number()));
    assert!(events.iter().any(|e| e["event"] == "text"), "{lines}");
    assert!(serde_json::from_slice::<Value>(&output.stdout).is_ok());
}

/// Goal: no line is wider than a terminal, but for words that are, and nothing stands for a number that is not known.
#[test]
fn lines_fit_into_eighty_columns() {
    let d = directory();
    let p2 = repository(P2);
    let lag = repository("data/practice/lag/P2.csv");
    let lag1 = repository("data/practice/lag/P1.csv");
    let six = repository("data/measurement/table1-six-cycles/P1.csv");
    let out = |name: &str| text(&d.path().join(name)).to_owned();
    let sets = out("sets.csv");
    std::fs::write(&sets, "material.branch[2].eta [Pa.s]\n4000\n5000\n").unwrap();
    let coarse = ["--mesh", "coarse"];
    let commands: Vec<Vec<String>> = [
        &["inspect", text(&six), text(&lag), text(&lag1)][..],
        &[&["simulate", "P2", "--out", &out("a")], &coarse[..]].concat(),
        &[&["identify", text(&p2), "--out", &out("b")], &coarse[..]].concat(),
        &[&["validate", text(&p2)], &coarse[..]].concat(),
        &[&["batch", &sets, "--out", &out("c")], &coarse[..]].concat(),
        &["identify", "nowhere.csv"],
        &["simulate", "P2", "--set", "material.n0x=1"],
        &["--help"],
        &["identify", "--help"],
        &["diagnose", "-h"],
    ]
    .iter()
    .map(|words| words.iter().map(|w| (*w).to_owned()).collect())
    .collect();
    let said = |words: Vec<String>| {
        let output = sharing_runner().args(&words).output().expect("the program starts");
        let said = [output.stdout, output.stderr].map(|t| String::from_utf8_lossy(&t).into_owned()).concat();
        (words, said)
    };
    let diagnosed = (vec!["diagnose".to_owned()], lag::diagnosed().said.clone());
    for (words, said) in commands.into_iter().map(said).chain([diagnosed]) {
        assert!(!said.is_empty());
        for line in said.lines() {
            let is_word = !line.trim().contains(' ');
            assert!(line.chars().count() <= 80 || is_word, "{words:?}: {} characters: {line}", line.len());
        }
        for sentinel in ["999.00", "NaN", "inf", "-9999"] {
            let is_there =
                said.split_whitespace().any(|word| word.trim_end_matches([',', ';', '.']) == sentinel);
            assert!(!is_there, "{words:?}: {sentinel} in {said}");
        }
    }
}

/// Goal: the warning about geometry comes first, what was assumed after the answer, briefly.
#[test]
fn what_is_assumed_stands_after_the_answer() {
    let d = directory();
    let out = d.path().join("out");
    let p2 = repository(P2);
    let kept = text(shared_runs());
    let printed = succeed(&["identify", text(&p2), "--mesh", "coarse", "--out", text(&out), "--cache", kept]);
    assert!(printed.starts_with("warning: punch radius 2 mm, sample height 10 mm"), "{printed}");
    let at = |part: &str| printed.find(part).unwrap_or_else(|| panic!("no {part} in {printed}"));
    assert!(at("Parameters identified from P2") < at("assumed: bonded bottom"));
    assert!(at("Parameters identified") < 600, "{printed}");
}

#[test]
fn completions_and_manual_pages_are_made() {
    let d = directory();
    for (shell, part) in
        [("bash", "complete -F _runner"), ("zsh", "#compdef runner"), ("fish", "complete -c runner")]
    {
        let script = succeed(&["completions", shell]);
        assert!(script.contains(part) && script.contains("max-evaluations"), "{shell}");
    }
    let pages = d.path().join("man");
    succeed(&["man", text(&pages)]);
    let page = std::fs::read_to_string(pages.join("runner-identify.1")).unwrap();
    assert!(
        page.starts_with(".\\\" written by poropunch") && page.contains("max\\-evaluations"),
        "{page:.200}"
    );
    assert!(pages.join("runner.1").exists() && pages.join("runner-challenge-make.1").exists());
}

/// Goal: what is to be typed again has the name by which the program was called. Set-up: called as the Python package calls it.
#[test]
#[cfg(unix)]
fn the_package_s_command_is_completed_and_repeated_by_its_own_name() {
    use std::os::unix::process::CommandExt;
    let d = directory();
    let said = |arguments: &[&str]| {
        let output = program::runner()
            .arg0("/usr/bin/poropunch")
            .args(arguments)
            .output()
            .expect("the program starts");
        assert!(output.status.success(), "{arguments:?}");
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let script = said(&["completions", "bash"]);
    assert!(
        script.contains("complete -F _poropunch") && script.contains("default poropunch"),
        "{script:.200}"
    );
    said(&["man", text(&d.path().join("man"))]);
    assert!(d.path().join("man/poropunch-identify.1").exists());
    let out = d.path().join("P2");
    let coarse = ["simulate", "P2", "--mesh", "coarse", "--points", "5", "--out", text(&out), "--json"];
    assert!(said(&coarse).contains("\"command\": \"poropunch simulate P2"));
    let job = std::fs::read_to_string(out.with_extension("toml")).expect("a job file");
    assert!(job.contains("# repeat: poropunch simulate --job P2.toml"), "{job}");
}
