//! `inspect` on the shipped six-cycle data, on specimens in files of their own, and on files that are no test.

use super::program::{column, directory, fail, json, one_line, repository, run, succeed, text};
use serde_json::Value;
use std::path::Path;

const DATA: [&str; 2] =
    ["data/measurement/table1-six-cycles/P1.csv", "data/measurement/table1-six-cycles/P2.csv"];

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number at {path}"))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    0.5 * (values[(n - 1) / 2] + values[n / 2])
}

/// Median over the specimens of what is read from each between two times.
fn over_specimens(file: &Path, from_s: f64, to_s: f64, read: fn(&[f64]) -> f64) -> f64 {
    let time = column(file, "time_s");
    let one = |k: usize| {
        let force = column(file, &format!("s{k:02}"));
        let part: Vec<f64> =
            time.iter().zip(force).filter(|(t, _)| (from_s..=to_s).contains(*t)).map(|(_, f)| f).collect();
        read(&part)
    };
    median((1..=10).map(one).collect())
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Goal: a specimen that is none of its kind is told and drawn in its own colour. Set-up: one of ten is 2.2 times as stiff.
#[test]
fn a_specimen_that_differs_from_all_others_is_marked() {
    let d = directory();
    let (file, out) = (d.path().join("m.csv"), d.path().join("out"));
    let source = std::fs::read_to_string(repository("data/measurement/table1-one-cycle/P2.csv")).unwrap();
    let header = source.lines().find(|l| l.starts_with("time_s")).unwrap();
    let third = header.split(',').position(|name| name == "s03").unwrap();
    let changed = source.lines().map(|line| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let Some(force) = fields.get(third).and_then(|f| f.parse::<f64>().ok()) {
            fields[third] = format!("{:.4}", 2.2 * force);
        }
        fields.join(",") + "\n"
    });
    std::fs::write(&file, changed.collect::<String>()).unwrap();
    let printed = one_line(&succeed(&["inspect", text(&file), "--out", text(&out)]));
    assert!(printed.contains("warning: specimen s03: its force differs in height"), "{printed}");
    let odd = json(&out.join("inspection.json"))["tests"][0]["odd_specimens"].clone();
    assert!(odd.as_array().unwrap().len() == 1 && odd[0]["name"] == "s03" && odd[0]["left_out"] == false);
    let page = std::fs::read_to_string(out.join("inspection.html")).unwrap();
    assert!(page.contains("specimen s03: its force differs in height"));
    assert!(!page.contains("Autocorrelation"), "a caption without its figure");
    let plain = succeed(&["inspect", text(&repository("data/measurement/table1-one-cycle/P2.csv"))]);
    assert!(!plain.contains("differs in"), "{plain}");
}

#[test]
fn six_cycles_are_read_as_the_protocol_made_them() {
    let d = directory();
    let files = DATA.map(repository);
    let arguments = ["inspect", text(&files[0]), text(&files[1]), "--water-fraction", "0.968+-0.002"];
    let printed = one_line(&succeed(&[&arguments[..], &["--out", text(d.path())]].concat()));
    assert!(printed.contains("SYNTHETIC") && printed.contains("n0S = 0.0320 +- 0.0020"), "{printed}");
    let found = json(&d.path().join("inspection.json"));
    assert_eq!(found["schema"], "poropunch.inspection/1");
    let mut peaks = vec![];
    // Protocol: rate (mm/s), hold from and to (s), time from cycle to cycle (s).
    for (i, (rate, from, to, period)) in
        [(1.0, 1.1, 91.1, 219.6), (1.6, 0.6875, 90.6875, 217.5875)].into_iter().enumerate()
    {
        let test = &found["tests"][i];
        let cycles = test["cycles"].as_array().expect("cycles");
        assert_eq!(cycles.len(), 6);
        for (k, cycle) in cycles.iter().enumerate() {
            let begin = period * k as f64;
            assert!((number(cycle, "/rate_mm_per_s/value") / rate - 1.0).abs() < 2e-3, "{cycle}");
            assert!((number(cycle, "/depth_mm") - 1.0).abs() < 1e-4, "{cycle}");
            assert!((number(cycle, "/ramp_end_s") - begin - from).abs() < 1e-3, "{cycle}");
            assert!((number(cycle, "/hold_end_s") - begin - to).abs() < 1e-3, "{cycle}");
            let peak = over_specimens(&files[i], begin, begin + to, largest);
            assert!((number(cycle, "/peak_mn/median") - peak).abs() < 1e-3, "{peak} {cycle}");
            // Mean of the last ten samples: the force falls by 0.02 mN meanwhile.
            let end = over_specimens(&files[i], begin + to - 9.5, begin + to, mean);
            assert!((number(cycle, "/hold_end_mn/median") - end).abs() < 0.06, "{end} {cycle}");
            let relaxation = 100.0 * (1.0 - end / peak);
            assert!((number(cycle, "/relaxation_percent/median") - relaxation).abs() < 1.5, "{cycle}");
            // There is no adhesion and no drift in these data.
            assert_eq!(cycle.pointer("/retraction/adhesion"), Some(&Value::Bool(false)), "{cycle}");
            assert!(
                number(cycle, "/drift_mn/value").abs() < 4.0 * number(cycle, "/drift_mn/sigma"),
                "{cycle}"
            );
            if k == 0 {
                peaks.push((peak, end));
                // The sample's surface is at 0.
                let onset = number(cycle, "/contact/onset_mm/median");
                assert!(onset.abs() < 2.5 * number(cycle, "/contact/onset_sigma_mm"), "{cycle}");
            }
        }
        // 0.07 mN white, nothing else; specimens that differ by 12 %.
        let noise = &test["noise"];
        let off = |path: &str, truth: f64| {
            (number(noise, &format!("{path}/value")) - truth) / number(noise, &format!("{path}/sigma"))
        };
        assert!(off("/white_mn", 0.07).abs() < 3.0 && noise["correlated_mn"].is_null(), "{noise}");
        assert!(off("/specimen_log_deviation", 0.12).abs() < 2.5, "{noise}");
    }
    let ratio = &found["ratios"][0];
    assert_eq!((&ratio["test"], &ratio["reference"]), (&"P2".into(), &"P1".into()));
    let (peak, end) = (peaks[1].0 / peaks[0].0, peaks[1].1 / peaks[0].1);
    assert!((number(ratio, "/peak/value") - peak).abs() < 1e-3, "{peak} {ratio}");
    assert!((number(ratio, "/hold_end/value") - end).abs() < 0.015, "{end} {ratio}");
    // What two sets of specimens do not share drops out of the rate effect: two independent solvers give 1.06.
    let effect = number(ratio, "/rate_effect/value");
    assert!((effect - 1.06).abs() < 0.03, "{ratio}");

    let page = std::fs::read_to_string(d.path().join("inspection.html")).expect("a page");
    assert!(page.contains("<svg") && !page.contains("src=\"http") && !page.contains("<link"));
    assert!(page.contains("Synthetic data") && !page.contains("NaN"));
    assert_eq!(column(&d.path().join("cycles.csv"), "cycle").len(), 12);
    assert_eq!(column(&d.path().join("phases.csv"), "time_s").len(), 3283 + 2923);
}

#[test]
fn specimens_in_files_of_their_own_are_put_onto_one_clock() {
    let d = directory();
    let file = repository(DATA[0]);
    let (time, depth) = (column(&file, "time_s"), column(&file, "displacement_mm"));
    let folder = d.path().join("P1");
    std::fs::create_dir(&folder).expect("a directory");
    let shift = |k: usize| 0.137 * (k as f64 - 1.0);
    for k in 1..=5 {
        let force = column(&file, &format!("s{k:02}"));
        let row = |i: usize| format!("{:.5},{},{}\n", time[i] - shift(k), depth[i], force[i]);
        let rows: String = (0..time.len()).map(row).collect();
        let name = folder.join(format!("s{k}.csv"));
        std::fs::write(name, format!("time_s,displacement_mm,force_mN\n{rows}")).expect("a file");
    }
    let out = d.path().join("out");
    succeed(&["inspect", text(&folder), "--out", text(&out)]);
    let test = &json(&out.join("inspection.json"))["tests"][0];
    assert_eq!((&test["name"], test["specimens"].as_array().map(Vec::len)), (&"P1".into(), Some(5)));
    for k in 1..=5 {
        assert!((number(test, &format!("/shifts_s/{}/value", k - 1)) - shift(k)).abs() < 1e-3, "{test}");
    }
    // The same as a list with a name; and a specimen of another protocol is refused by name.
    let list = format!("soft={}", folder.join("s*.csv").display());
    assert!(succeed(&["inspect", &list]).starts_with("soft: 6 cycles"));
    let other = format!("{list},{}", repository(DATA[1]).display());
    let error = fail(&["inspect", &other]);
    for part in ["P2.csv", "1.600 mm/s", "does not match", "s1.csv", "remedy"] {
        assert!(error.contains(part), "`{part}` is not in\n{error}");
    }
}

#[test]
fn files_that_are_no_test_are_named_with_a_remedy() {
    let d = directory();
    let file = d.path().join("bad.csv");
    let rows = |depth: fn(usize) -> f64| -> String {
        (0..200).map(|i| format!("{},{},{}\n", 0.1 * i as f64, depth(i), 0.01 * (i % 3) as f64)).collect()
    };
    let ramp = |i: usize| (-0.1 + 0.02 * i as f64).min(1.0);
    let jumps: fn(usize) -> f64 = |i| if i == 30 { 9.0 } else { (-0.1 + 0.02 * i as f64).min(1.0) };
    type Case = (&'static str, fn(usize) -> f64, &'static [&'static str]);
    let cases: [Case; 3] = [
        (
            "jump",
            jumps,
            &["line 32", "`displacement`", "jumps from 0.4800 to 9.0000 mm", "correct or remove"],
        ),
        ("above", |_| -0.5, &["never touches"]),
        ("resting", |_| 0.5, &["there is no ramp", "start the file before the loading"]),
    ];
    for (what, depth, parts) in cases {
        std::fs::write(&file, format!("time_s,displacement_mm,force_mN\n{}", rows(depth))).expect("a file");
        let error = fail(&["inspect", text(&file), "--out", text(&d.path().join("out"))]);
        for part in parts.iter().chain(&["bad.csv", "remedy"]) {
            assert!(error.contains(part), "{what}: `{part}` is not in\n{error}");
        }
        assert!(!d.path().join("out").exists(), "{what}");
    }
    // A force that never shows contact is no error: the rest can still be read.
    std::fs::write(&file, format!("time_s,displacement_mm,force_mN\n{}", rows(ramp))).expect("a file");
    assert!(succeed(&["inspect", text(&file)]).contains("the force never passes 1 mN"));
    let empty = d.path().join("empty");
    std::fs::create_dir(&empty).expect("a directory");
    assert!(fail(&["inspect", text(&empty)]).contains("no CSV file"));
    let error = fail(&["inspect", text(&file), "--water-fraction", "96.8"]);
    assert!(error.contains("between 0 and 1"), "{error}");
    assert_eq!(run(&["inspect", text(&file), "--wet-mass-g", "10"]).status.code(), Some(2));
}
