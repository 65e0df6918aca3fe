//! The server for samplers, through the protocol's own client.

use super::program::{one_line, refuse, repository, runner};
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

/// Goal: Python's `umbridge` gets the command line's force and derivatives that agree with it; Ctrl-C ends the server.
#[test]
fn a_sampler_evaluates_and_differentiates() {
    let mut server = runner()
        .args(["um-bridge", "P2", "--points", "40", "--mesh", "coarse", "--port", "0", "--jobs", "2"])
        .args(["--parameter", "material.equilibrium.mu", "--parameter", "material.branch[2].eta"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    let mut said = BufReader::new(server.stdout.take().unwrap());
    while !line.contains("material.branch[2].eta") {
        assert!(said.read_line(&mut line).unwrap() > 0, "{line}");
    }
    let line = one_line(&line);
    let address = line.split_whitespace().find(|word| word.starts_with("http://127.0.0.1:")).expect(&line);
    let python = std::env::var_os("POROPUNCH_PYTHON");
    let python = python.map_or_else(|| repository(".venv/bin/python"), Into::into);
    let client = Command::new(&python)
        .arg(repository("tests/end_to_end/python/um_bridge.py"))
        .args([address.trim_end_matches(':'), env!("CARGO_BIN_EXE_runner")])
        .output();
    let interrupted = Command::new("kill").args(["-INT", &server.id().to_string()]).status().unwrap();
    let ended = server.wait().unwrap();
    let client = client.unwrap_or_else(|e| panic!("{}: {e}; tests/run installs it", python.display()));
    assert!(client.status.success(), "{}", String::from_utf8_lossy(&client.stderr));
    assert!(interrupted.success());
    assert_eq!(ended.code(), Some(130));
}

#[test]
fn what_cannot_be_served_is_refused() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    assert!(refuse(1, &["um-bridge", "--port", &port]).contains("choose another with --port"));
    assert!(refuse(2, &["um-bridge", "--parameter", "material.permeabilty"]).contains("did you mean"));
    let twice = ["um-bridge", "--parameter", "material.n0s", "--parameter", "material.n0s"];
    assert!(refuse(2, &twice).contains("given twice"));
    // A parameter set is a file, no name of an input.
    let error = refuse(2, &["um-bridge", "--parameters", "none.ssv"]);
    assert!(error.contains("none.ssv") && !error.contains("no parameter"), "{error}");
}
