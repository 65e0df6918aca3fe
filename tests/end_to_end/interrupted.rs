//! Stopping and killing: nothing is lost, and resuming gives the very same result.

use super::program::{directory, fail, json, repository, runner, succeed, text};
use super::third_party::{WIRING, bench, measurement};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

/// A fit of three parameters, slowed down to some 0.3 s per run.
fn slow_fit<'a>(data: &'a str, fmu: &'a str, out: &'a str) -> Vec<&'a str> {
    let mut arguments = vec!["identify", data, "--fmu", fmu, "--out", out, "--jobs", "2"];
    arguments.extend(["--free", "k_slow,k_fast,tau", "--set", "delay_ms=1"]);
    arguments.extend([
        "--bounds",
        "k_slow=0.1:100",
        "--bounds",
        "k_fast=0.1:100",
        "--bounds",
        "tau=0.05:50s",
    ]);
    arguments.extend(WIRING);
    arguments
}

/// Starts the program and waits until it has kept some runs.
fn start_until(runs: usize, arguments: &[&str], cache: &Path) -> Child {
    let mut command = runner();
    let child = command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = child.expect("the program starts");
    let start = Instant::now();
    while kept(cache) < runs {
        assert!(start.elapsed() < Duration::from_secs(60), "no runs are made");
        assert!(child.try_wait().expect("its state").is_none(), "it ended before it could be stopped");
        std::thread::sleep(Duration::from_millis(5));
    }
    child
}

/// Runs in a cache.
fn kept(cache: &Path) -> usize {
    let files = std::fs::read_dir(cache).into_iter().flatten().flatten();
    files.filter(|f| f.path().extension().is_some_and(|e| e == "run")).count()
}

/// What must not depend on interruptions: all but times and costs.
fn essence(out: &Path) -> serde_json::Value {
    let mut result = json(&out.join("result.json"));
    let object = result.as_object_mut().expect("an object");
    for cost in ["created", "command", "runs"] {
        object.remove(cost).unwrap_or_else(|| panic!("no {cost} in the result"));
    }
    result
}

#[test]
fn a_killed_fit_resumes_to_the_same_result() {
    let (d, fmu, data) = bench(3.0, 8.0, 1.2);
    let (whole, killed) = (d.path().join("whole"), d.path().join("killed"));
    succeed(&slow_fit(text(&data), text(&fmu), text(&whole)));
    let expected = essence(&whole);

    let arguments = slow_fit(text(&data), text(&fmu), text(&killed));
    let resume = ["identify", "--resume", "--out", text(&killed), "--jobs", "2"];
    // Killed early and late, and once with a damaged entry.
    for runs in [1, 9] {
        let mut child =
            start_until(runs, if runs == 1 { &arguments } else { &resume }, &killed.join("cache"));
        child.kill().expect("SIGKILL");
        child.wait().expect("its end");
        assert!(!killed.join("result.json").exists());
    }
    let entry = std::fs::read_dir(killed.join("cache")).expect("the cache").flatten().next().expect("a run");
    std::fs::write(entry.path(), b"damaged").expect("a write");
    let before = kept(&killed.join("cache"));
    succeed(&resume);
    assert_eq!(essence(&killed), expected);
    let runs = json(&killed.join("result.json"))["runs"].clone();
    let hits = runs["cache_hits"].as_u64().expect("a count");
    assert!(hits >= before as u64 - 1, "{before} runs were kept, {hits} used");
}

/// Goal: wherever a fit is killed, it ends as if it had not been. Set-up: a hundred fits, killed at times that go through all of it.
#[test]
#[ignore = "long: a hundred fits, each killed and resumed"]
fn a_hundred_kills_end_equal() {
    let d = directory();
    let (data, whole) = (repository("data/measurement/table1-one-cycle/P2.csv"), d.path().join("whole"));
    let fit =
        |out: &Path| ["identify", text(&data), "--mesh", "coarse", "--out", text(out)].map(str::to_owned);
    let words = |words: &[String]| succeed(&words.iter().map(String::as_str).collect::<Vec<_>>());
    let start = Instant::now();
    words(&fit(&whole));
    let (length, expected) = (start.elapsed(), essence(&whole));
    let mut killed = 0;
    for k in 0..100 {
        let out = d.path().join(format!("{k}"));
        let child = runner().args(fit(&out)).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        let mut child = child.expect("the program starts");
        std::thread::sleep(length * k / 100);
        killed += u32::from(child.try_wait().expect("its state").is_none());
        child.kill().expect("SIGKILL");
        child.wait().expect("its end");
        if out.join("poropunch.toml").exists() {
            succeed(&["identify", "--resume", "--out", text(&out)]);
        } else {
            words(&fit(&out));
        }
        assert_eq!(essence(&out), expected, "killed after {k} of 100 parts");
        std::fs::remove_dir_all(&out).expect("removed");
    }
    assert!(killed > 50, "{killed} of 100 were killed before their end");
}

#[test]
#[cfg(unix)]
fn ctrl_c_stops_cleanly_and_keeps_the_best_point() {
    let (d, fmu, data) = bench(3.0, 8.0, 1.2);
    let out = d.path().join("out");
    let arguments = slow_fit(text(&data), text(&fmu), text(&out));
    let child = start_until(10, &arguments, &out.join("cache"));
    let status = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(status.expect("kill").success());
    let output = child.wait_with_output().expect("its end");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{error}");
    let result = json(&out.join("result.json"));
    assert_eq!(result["fit"]["stop"], "stop_requested", "{error}");
    succeed(&["identify", "--resume", "--out", text(&out), "--jobs", "2"]);
    assert!(
        json(&out.join("result.json"))["fit"]["stop_text"].as_str().expect("text").starts_with("converged")
    );
}

#[test]
fn resume_refuses_what_does_not_fit() {
    let (d, fmu, data) = bench(3.0, 8.0, 1.2);
    let out = d.path().join("out");
    let error = fail(&["identify", "--resume", "--out", text(&out)]);
    assert!(error.contains("nothing to resume"), "{error}");
    let mut quick = slow_fit(text(&data), text(&fmu), text(&out));
    quick.retain(|a| *a != "delay_ms=1" && *a != "--set");
    succeed(&quick);
    let error = fail(&[&quick[..], &["--resume", "--seed", "7"]].concat());
    assert!(error.contains("differs in `fit.seed`"), "{error}");
    succeed(&[&quick[..], &["--resume"]].concat());
    measurement(&data, 3.1, 8.0, 1.2);
    let error = fail(&["identify", "--resume", "--out", text(&out)]);
    assert!(error.contains("has changed"), "{error}");
    std::fs::write(out.join("poropunch.toml"), "{").expect("a write");
    let error = fail(&["identify", "--resume", "--out", text(&out)]);
    assert!(error.contains("poropunch.toml") && error.contains("begin anew"), "{error}");
}
