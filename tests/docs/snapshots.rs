//! Help of every command and the short reports, as they were when somebody last looked at them.
//!
//! After a change that is meant: `INSTA_UPDATE=always cargo test --release -p runner --test all docs::snapshots`, and look at the difference.

use crate::end_to_end::program::{directory, repository, sharing_runner, text};
use std::path::Path;

fn same(name: &str, said: &str) {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("snapshots");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, said));
}

/// What a command prints, in a directory of its own.
fn said(folder: &Path, words: &[&str]) -> String {
    let output = sharing_runner().args(words).current_dir(folder).env("COLUMNS", "80").output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words:?}: {error}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Names under `Commands:`.
fn commands(help: &str) -> Vec<String> {
    let lines = help.lines().skip_while(|l| *l != "Commands:").skip(1).take_while(|l| !l.is_empty());
    let names = lines.filter(|l| l.starts_with("  ") && !l.starts_with("   "));
    names.filter_map(|l| l.split_whitespace().next()).filter(|n| *n != "help").map(str::to_owned).collect()
}

#[test]
fn help() {
    let d = directory();
    let mut left = vec![vec![]];
    let mut seen = 0;
    while let Some(words) = left.pop() {
        let line: Vec<&str> = words.iter().map(String::as_str).chain(["-h"]).collect();
        let help = said(d.path(), &line);
        for inner in commands(&help) {
            left.push([words.as_slice(), &[inner]].concat());
        }
        assert!(help.lines().all(|l| l.chars().count() <= 80), "{help}");
        same(&["help".to_owned()].into_iter().chain(words).collect::<Vec<_>>().join("-"), &help);
        seen += 1;
    }
    assert!(seen > 20, "{seen}");
}

/// Numbers may differ in their last digit from one processor to another, and lines break elsewhere then; what is said of them must not.
fn without_numbers(said: &str) -> String {
    let word = |w: &str| {
        let number =
            w.rsplit('^').next().unwrap_or(w).trim_matches(['[', ']', ',', ';', '(', ')', '%', ':', '.']);
        let is_number = number.contains(|c: char| c.is_ascii_digit()) && number.parse::<f64>().is_ok();
        if is_number { w.replace(number, "#") } else { w.to_owned() }
    };
    let paragraph = |p: &str| p.split_whitespace().map(word).collect::<Vec<_>>().join(" ");
    said.split("\n\n").map(paragraph).collect::<Vec<_>>().join("\n\n")
}

#[test]
fn short_reports() {
    let d = directory();
    for folder in ["data", "runner"] {
        std::os::unix::fs::symlink(repository(folder), d.path().join(folder)).unwrap();
    }
    let p2 = "data/measurement/table1-one-cycle/P2.csv";
    let plug = "data/measured/cartilage_unconfined_ramp1.csv";
    let geometry = ["--set", "geometry.punch_radius=2mm"];
    same("inspect", &said(d.path(), &["inspect", p2, "--out", "inspected"]));
    same(
        "inspect-plug",
        &said(d.path(), &["inspect", plug, "--zero", "first", "--tare", "first", "--out", "plug"]),
    );
    same(
        "published",
        &said(d.path(), &["diagnose", "--published", "data/published/measured.csv", "--out", "published"]),
    );
    let simulate = [["simulate", "P2", "--mesh", "coarse"].as_slice(), &geometry].concat();
    same("simulate", &without_numbers(&said(d.path(), &simulate)));
    let validate = [["validate", p2, "--mesh", "coarse"].as_slice(), &geometry].concat();
    same("validate", &without_numbers(&said(d.path(), &validate)));
    let identify = [["identify", p2, "--mesh", "coarse", "--out", "found"].as_slice(), &geometry].concat();
    same("identify", &without_numbers(&said(d.path(), &identify)));
    same("package", &said(d.path(), &["package", "--out", "poropunch.fmu"]));
    assert!(Path::new(text(d.path())).join("poropunch.fmu").exists());
}
