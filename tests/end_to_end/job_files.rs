//! Job files: what a command line says, in a file.
//!
//! Goal: each command keeps the file that repeats it, a file is read as the command line is, and what is wrong in it is told with
//! file, line, field and remedy.

use super::program::{column, directory, fail, json, refuse, repository, runner, succeed, text};
use super::third_party::{WIRING, bench, build, measurement, wired};
use std::path::Path;

/// A file with the data of the third-party solid, and a job that fits it.
fn job(folder: &Path, more: &str) -> std::path::PathBuf {
    let fmu = build(folder);
    measurement(&folder.join("m.csv"), 3.0, 8.0, 1.2);
    let file = folder.join("poropunch.toml");
    let said = format!(
        "measurements = [\"m.csv\"]\n\n[model]\nfmu = \"{}\"\ninput = \"{}\"\noutput = \"{}\"\n\n[parameters]\n\
         free = [\"k_slow\", \"k_fast\", \"tau\"]\n\n[parameters.bounds]\nk_slow = \"0.1:100\"\nk_fast = \"0.1:100\"\n\
         tau = \"0.05:50s\"\n{more}",
        text(&fmu),
        WIRING[1],
        WIRING[3]
    );
    std::fs::write(&file, said).unwrap();
    file
}

/// What must not depend on the way a fit was asked for.
fn values(out: &Path) -> serde_json::Value {
    json(&out.join("result.json"))["parameters"].clone()
}

#[test]
fn a_job_is_read_from_its_own_directory_and_keeps_the_one_that_repeats_it() {
    let d = directory();
    let file = job(d.path(), "\n[identify]\nout = \"found\"\n\n[diagnose]\nquick = true\n");
    // From another directory, where there is no m.csv.
    let elsewhere = directory();
    let status = runner()
        .args(["identify", "--job", text(&file), "--jobs", "2"])
        .current_dir(elsewhere.path())
        .status()
        .unwrap();
    assert!(status.success());
    let (first, second) = (d.path().join("found"), d.path().join("again"));
    let kept = first.join("poropunch.toml");
    let said = std::fs::read_to_string(&kept).unwrap();
    for part in
        ["written by poropunch", "blake3", "k_slow = \"0.1:100\"", "[parameters.bounds]", "out = \".\""]
    {
        assert!(said.contains(part), "no {part} in {said}");
    }
    // What was kept gives the same elsewhere, and in its own place; then nothing is left to be simulated.
    succeed(&["identify", "--job", text(&kept), "--out", text(&second), "--jobs", "2"]);
    assert_eq!(values(&first), values(&second));
    succeed(&["identify", "--job", text(&kept), "--jobs", "2"]);
    assert_eq!(values(&first), values(&second));
    assert_eq!(json(&first.join("result.json"))["runs"]["runs"], 0);
    assert_eq!(std::fs::read_to_string(&kept).unwrap(), said);
    // Another question does not overwrite it.
    let error = fail(&["identify", "--job", text(&kept), "--robust"]);
    assert!(error.contains("is an input of this command") && error.contains("--out"), "{error}");
    // Data that are no longer what they were are refused.
    measurement(&d.path().join("m.csv"), 3.1, 8.0, 1.2);
    let error = refuse(4, &["identify", "--job", text(&kept)]);
    assert!(error.contains("m.csv has changed since"), "{error}");
}

#[test]
fn the_command_line_wins_name_by_name() {
    let d = directory();
    let more = "\n[parameters.start]\nk_slow = 2\ntau = \"1 s\"\n\n[fit]\nmax_evaluations = 1\n";
    let file = job(d.path(), more);
    let out = d.path().join("out");
    let args = ["--max-evaluations", "50", "--start", "tau=2s", "--out", text(&out)];
    succeed(&[&["identify", "--job", text(&file)][..], &args].concat());
    let said = std::fs::read_to_string(out.join("poropunch.toml")).unwrap();
    for part in ["k_slow = 2\n", "tau = \"2s\"", "max_evaluations = 50"] {
        assert!(said.contains(part), "no {part} in {said}");
    }
    assert!(!said.contains("1 s"), "{said}");
}

#[test]
fn what_is_wrong_is_told_with_file_line_field_and_remedy() {
    let d = directory();
    for (more, parts) in [
        ("[fitt]\nseed = 1\n", vec!["line 15: `fitt`", "there is no such field", "did you mean `fit"]),
        ("[fit]\nseedd = 1\n", vec!["line 16: `fit.seedd`", "did you mean `fit.seed`"]),
        ("[fit]\nstarts = 0\n", vec!["line 16: `fit.starts`", "must be between 1 and 10000"]),
        ("[fit]\nnoise = \"pink\"\n", vec!["line 16: `fit.noise`", "pink", "possible values"]),
        ("[fit]\nrobust = \"yes\"\n", vec!["line 16: `fit.robust`", "true or false"]),
        ("[fit]\nseed = [1, 2]\n", vec!["line 16: `fit.seed`", "one value"]),
        ("[parameters.set]\nk_quick = 1\n", vec!["line 16: `parameters.set.\"k_quick\"`", "no parameter"]),
        ("[reading]\nzero = 12.34\n", vec!["line 16: `reading.zero`", "has no unit"]),
        ("[fit\n", vec!["line 15", "toml.io"]),
        ("[identify]\nvalidate = [{ name = \"x\" }]\n", vec!["line 16: `identify.validate`", "blake3"]),
    ] {
        let folder = d.path().join(format!("{}", more.len()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = job(&folder, more);
        let error = refuse(2, &["identify", "--job", text(&file), "--out", text(&folder.join("out"))]);
        assert!(error.contains("poropunch.toml"), "{error}");
        for part in parts {
            assert!(error.contains(part), "no {part} for {more} in {error}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
    let error = refuse(2, &["identify", "--job", text(&d.path().join("none.toml"))]);
    assert!(error.contains("none.toml") && error.contains("check the path"), "{error}");
}

#[test]
fn one_job_describes_a_test_to_all_commands() {
    let d = directory();
    let file = job(d.path(), "\n[inspect]\nout = \"seen\"\n");
    let printed = refuse(0, &["inspect", "--job", text(&file)]);
    assert!(
        printed.contains("not used by this command: model.fmu, model.input, model.output, parameters.free"),
        "{printed}"
    );
    assert!(d.path().join("seen/inspection.json").exists() && d.path().join("seen/poropunch.toml").exists());
    let again = d.path().join("seen_again");
    succeed(&["inspect", "--job", text(&d.path().join("seen/poropunch.toml")), "--out", text(&again)]);
    let essence = |folder: &str| {
        let mut found = json(&d.path().join(folder).join("inspection.json"));
        found["command"] = serde_json::Value::Null;
        found
    };
    assert_eq!(essence("seen"), essence("seen_again"));
}

#[test]
fn a_simulation_a_table_and_a_validation_are_repeated() {
    let (d, fmu, data) = bench(4.0, 6.0, 2.0);
    let wired = wired(&fmu);
    let (one, two) = (d.path().join("one"), d.path().join("two"));
    succeed(&[&["simulate", text(&data), "--set", "k_slow=5", "--out", text(&one)], &wired[..]].concat());
    succeed(&["simulate", "--job", text(&one.with_extension("toml")), "--out", text(&two)]);
    let force = |base: &Path| column(&base.with_extension("csv"), "force_mN");
    assert_eq!(force(&one), force(&two));

    let sets = d.path().join("sets.csv");
    std::fs::write(&sets, "name,k_slow\na,3\nb,4\n").unwrap();
    let (one, two) = (d.path().join("batch"), d.path().join("batch_again"));
    let protocol = ["--protocol", text(&data), "--out", text(&one)];
    succeed(&[&["batch", text(&sets)], &protocol[..], &wired[..]].concat());
    succeed(&["batch", "--job", text(&one.join("poropunch.toml")), "--out", text(&two)]);
    let last = |folder: &Path| column(&folder.join("summary.csv"), "last_force_mN");
    assert_eq!(last(&one), last(&two));

    let (one, two) = (d.path().join("validated"), d.path().join("validated_again"));
    succeed(&[&["validate", text(&data), "--noise", "none", "--out", text(&one)], &wired[..]].concat());
    succeed(&["validate", "--job", text(&one.join("poropunch.toml")), "--out", text(&two)]);
    assert_eq!(column(&one.join("m.csv"), "force_mN"), column(&two.join("m.csv"), "force_mN"));
}

/// Goal: names, units and geometry in a job file mean what they mean on the command line. Set-up: the model's own FMU.
#[test]
fn geometry_and_units_are_understood() {
    let d = directory();
    let file = d.path().join("gel.toml");
    let motion = repository("data/measurement/table1-one-cycle/P2.csv");
    let said = format!(
        "[geometry]\npunch_radius = \"2 mm\"\n[parameters.set.material]\nn0s = 0.03\n[model]\nmesh = \"coarse\"\n[simulate]\n\
         motion = \"{}\"\nout = \"gel\"\n",
        text(&motion)
    );
    std::fs::write(&file, &said).unwrap();
    let printed = refuse(0, &["simulate", "--job", text(&file)]);
    assert!(printed.contains("given: geometry.punch_radius = 2 mm, material.n0s = 0.03"), "{printed}");
    assert!(std::fs::read_to_string(d.path().join("gel.toml")).unwrap() == said);
    // The job that would be kept has the name of the one that was read, which is an input and says something else.
    let error = fail(&["simulate", "--job", text(&file), "--set", "geometry.punch_radius=1mm"]);
    assert!(error.contains("gel.toml"), "{error}");
    std::fs::write(&file, said.replace("2 mm", "2")).unwrap();
    let error = refuse(2, &["simulate", "--job", text(&file)]);
    assert!(error.contains("line 2: `geometry.punch_radius`") || error.contains("has no unit"), "{error}");
}

/// Goal: a server and the steps of a challenge take a job file; the step that writes cases leaves one that makes the same cases.
#[test]
fn servers_and_challenges_are_told_by_a_job() {
    let d = directory();
    let file = d.path().join("poropunch.toml");
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let say = |more: &str| std::fs::write(&file, format!("[model]\nmesh = \"coarse\"\n{more}")).unwrap();
    say(&format!("[um_bridge]\nport = {port}\nparameter = [\"material.n0s\"]\n"));
    assert!(refuse(1, &["um-bridge", "--job", text(&file)]).contains("choose another with --port"));
    say("[um_bridge]\nport = \"none\"\n");
    let error = refuse(2, &["um-bridge", "--job", text(&file)]);
    assert!(error.contains("line 4: `um_bridge.port`"), "{error}");

    say(
        "[challenge.make]\nseed = 5\ncases = 1\nkinds = \"null\"\nground = \"near\"\nout = \"cases\"\nsecret = \"a.secret\"\n",
    );
    succeed(&["challenge", "make", "--job", text(&file)]);
    let kept = d.path().join("cases.key.toml");
    let cases = |folder: &str| {
        let case = std::fs::read_dir(d.path().join(folder).join("cases")).unwrap().next().unwrap().unwrap();
        std::fs::read_to_string(case.path().join("P1.csv")).unwrap()
    };
    let first = cases("cases");
    let again = d.path().join("again");
    let secret = d.path().join("again.secret");
    let elsewhere = ["--out", text(&again), "--secret", text(&secret)];
    succeed(&[&["challenge", "make", "--job", text(&kept)][..], &elsewhere].concat());
    assert_eq!(first, cases("again"));
    assert!(!d.path().join("cases/poropunch.toml").exists(), "the seed is not told beside the cases");
    say(&format!("[challenge.answer]\nfolder = \"{}\"\nquick = true\nfast = true\n", text(&again)));
    assert!(refuse(2, &["challenge", "answer", "--job", text(&file)]).contains("challenge.answer.fast"));
}

/// Goal: the documentation's example is understood. Set-up: its measurements are not there, which is told after the fields are checked.
#[test]
fn the_documented_job_is_understood() {
    let d = directory();
    let page = std::fs::read_to_string(repository("runner/docs/pages/own-data.md")).unwrap();
    let example = page.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let file = d.path().join("poropunch.toml");
    std::fs::write(&file, example).unwrap();
    for command in ["identify", "diagnose", "inspect"] {
        let error = refuse(4, &[command, "--job", text(&file)]);
        assert!(error.contains("P1") && error.contains("remedy"), "{command}: {error}");
    }
}
