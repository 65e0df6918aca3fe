//! Files as laboratories' machines write them: each shape is read, or asks for what it leaves open, all at once.
//!
//! Set-up: one indentation test of known depth and force, in the dress of six programs. Reference: what went in.

use super::program::{directory, json, one_line, refuse, repository, succeed, text};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Depth (mm) and force (mN) of the test at a time (s): rest 0.2 mm above the surface, ramp to 0.5 mm at 0.5 mm/s, hold.
pub fn truth(time_s: f64) -> (f64, f64) {
    let depth = |t: f64| (0.5 * (t - 1.0)).clamp(0.0, 0.7) - 0.2;
    let peak_s = 2.4;
    let press = 20.0 * depth(time_s).max(0.0);
    let relaxed = if time_s > peak_s { 0.4 + 0.6 * (-(time_s - peak_s) / 1.5).exp() } else { 1.0 };
    // A small wobble in place of noise, the same every time.
    (depth(time_s), press * relaxed + 0.02 * (97.0 * time_s).sin())
}

/// Sampling times (s).
pub fn times() -> Vec<f64> {
    (0..400).map(|i| 0.02 * f64::from(i)).collect()
}

/// Rows of a table; `row` gets time (s), depth (mm) and force (mN).
fn table(row: impl Fn(f64, f64, f64) -> String) -> String {
    let mut rows = String::new();
    for t in times() {
        let (depth, force) = truth(t);
        let _ = writeln!(rows, "{}", row(t, depth, force));
    }
    rows
}

/// A file as a program writes it.
pub struct Shape {
    /// The program.
    pub name: &'static str,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// What must be answered, with the answers.
    pub answers: &'static [&'static str],
}

fn comma(value: f64, digits: usize) -> String {
    format!("{value:.digits$}").replace('.', ",")
}

/// Instron Bluehill: quoted fields, a row of units, tension positive, extension zeroed at the start above the sample.
fn instron() -> Shape {
    let head = "\"Specimen label\",\"gel 1\"\n\"Rate 1\",\"30,00000\",\"mm/min\"\n\n\"Time\",\"Extension\",\"Load\"\n\"(s)\",\"(mm)\",\"(N)\"\n";
    let rows = table(|t, d, f| format!("\"{t:.5}\",\"{:.5}\",\"{:.7}\"", d + 0.2, -f * 1e-3));
    Shape { name: "instron", bytes: format!("{head}{rows}").into_bytes(), answers: &["--zero", "contact"] }
}

/// ZwickRoell testXpert: Latin-1, semicolons, decimal commas, a row of units, a load cell that was not tared.
fn zwick() -> Shape {
    let head =
        "Prüfprotokoll\nPrüfer;Müller\nVorkraft;0,01;N\n\nPrüfzeit;Standardweg;Standardkraft\ns;mm;N\n";
    let row = |t: f64, d: f64, f: f64| {
        format!("{};{};{}", comma(t, 3), comma(d + 0.2, 5), comma(f * 1e-3 + 0.0047, 7))
    };
    let latin = format!("{head}{}", table(row));
    let bytes = latin.chars().map(|c| u8::try_from(u32::from(c)).expect("Latin-1")).collect();
    Shape { name: "zwick", bytes, answers: &["--zero", "contact", "--tare", "off-contact"] }
}

/// TA Instruments TRIOS: UTF-16, tabs, a gap that shrinks, time in minutes.
fn ta() -> Shape {
    let head = "Filename\tgel.tri\nInstrument name\tRSA-G2\n\n[step]\nStep name\tAxial - 1\nTime\tGap\tAxial force\tTemperature\nmin\tmm\tN\t°C\n";
    let rows = table(|t, d, f| format!("{:.7}\t{:.5}\t{:.7}\t22.1", t / 60.0, 10.0 - d, f * 1e-3));
    let bytes = format!("\u{feff}{head}{rows}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    Shape { name: "ta", bytes, answers: &["--zero", "contact"] }
}

/// Bose (TA ElectroForce) WinTest: two clocks, both signs reversed, zero of the machine.
fn bose() -> Shape {
    let head = "WinTest Data File\nSample,gel 1\n\nPoints,Elapsed Time,Scan Time,Disp,Load\n,Sec,Sec,mm,N\n";
    let rows =
        table(|t, d, f| format!("{:.0},{t:.4},{t:.4},{:.5},{:.7}", t * 50.0 + 1.0, -3.0 - d, -f * 1e-3));
    Shape { name: "bose", bytes: format!("{head}{rows}").into_bytes(), answers: &["--zero", "contact"] }
}

/// Biomomentum Mach-1: blocks, units behind a comma, several axes, a line behind the table.
fn biomomentum() -> Shape {
    let head = "<Mach-1 File>\n<INFO>\nTime:\t10:12:30\nLoad cell:\t1.5 N\n<END INFO>\n<DATA>\nTime, s\tPosition (z), mm\tPosition (x), mm\tFx, gf\tFy, gf\tFz, gf\n";
    let row = |t: f64, d: f64, f: f64| {
        format!("{t:.3}\t{:.5}\t25.0000\t0.001\t0.002\t{:.6}", 12.34 + d, f / 9.806_65)
    };
    let bytes = format!("{head}{}<END DATA>\n", table(row)).replace('\n', "\r\n").into_bytes();
    Shape { name: "biomomentum", bytes, answers: &["--zero", "contact"] }
}

/// Optics11 Piuma: a list of settings, then tabs with units in brackets; depth is zero at contact already.
fn optics11() -> Shape {
    let head = "Date\t01/02/2026\nTime\t10:12:30\nTip radius (um)\t50\nCantilever stiffness (N/m)\t0.5\n\nTime (s)\tLoad (uN)\tIndentation (nm)\tCantilever (nm)\tPiezo (nm)\tAuxiliary\n";
    let row = |t: f64, d: f64, f: f64| {
        format!("{t:.4}\t{:.4}\t{:.2}\t0.0\t{:.2}\t0", f * 1e3, d * 1e6, d * 1e6 + 5e3)
    };
    Shape { name: "optics11", bytes: format!("{head}{}", table(row)).into_bytes(), answers: &[] }
}

/// All shapes.
pub fn shapes() -> Vec<Shape> {
    vec![instron(), zwick(), ta(), bose(), biomomentum(), optics11()]
}

fn write(folder: &Path, shape: &Shape) -> PathBuf {
    let file = folder.join(format!("{}.csv", shape.name));
    std::fs::write(&file, &shape.bytes).expect("a file");
    file
}

/// Depth and peak that `inspect` finds are those that went in.
fn check(name: &str, out: &Path) {
    let cycle = &json(&out.join("inspection.json"))["tests"][0]["cycles"][0];
    let number = |path: &str| cycle.pointer(path).and_then(serde_json::Value::as_f64).expect("a number");
    assert!((number("/depth_mm") - 0.5).abs() < 0.012, "{name}: {cycle}");
    assert!((number("/peak_mn/median") - 10.0).abs() < 0.15, "{name}: {cycle}");
}

/// Numbered questions in a message.
fn questions(message: &str) -> usize {
    (1..20).take_while(|k| message.contains(&format!(" {k}. "))).count()
}

#[test]
fn every_shape_is_read_and_asks_for_what_it_leaves_open() {
    let d = directory();
    for shape in shapes() {
        let (file, out) = (write(d.path(), &shape), d.path().join(format!("{}.out", shape.name)));
        let base = ["inspect", text(&file), "--out", text(&out)];
        if !shape.answers.is_empty() {
            let error = refuse(4, &base);
            for pair in shape.answers.chunks(2) {
                assert!(error.contains(&pair.join(" ")), "{}: {error}", shape.name);
            }
            assert_eq!(
                questions(&error),
                shape.answers.len() / 2,
                "{}: all questions, once: {error}",
                shape.name
            );
        }
        succeed(&[&base[..], shape.answers].concat());
        check(shape.name, &out);
    }
}

#[test]
fn ten_files_ask_once() {
    let d = directory();
    let folder = d.path().join("gel");
    std::fs::create_dir(&folder).expect("a directory");
    for k in 0..10 {
        let file = folder.join(format!("s{k}.csv"));
        let scaled = |t: f64, d: f64, f: f64| {
            format!("{t:.3};{:.5};{:.5}", 12.34 - d, -f * (1.0 + 0.02 * f64::from(k)) - 1.5)
        };
        let head = "Messung\nBediener;Gläser\n\nZeit;Position;Kraft\ns;mm;mN\n";
        let latin: Vec<u8> =
            format!("{head}{}", table(scaled)).replace('.', ",").chars().map(|c| c as u8).collect();
        std::fs::write(&file, latin).expect("a file");
    }
    let out = d.path().join("out");
    let base = ["inspect", text(&folder), "--out", text(&out)];
    let error = refuse(4, &base);
    assert_eq!(questions(&error), 2, "{error}");
    let printed = succeed(&[&base[..], &["--zero", "contact", "--tare", "off-contact"]].concat());
    assert!(printed.contains("gel: 1 cycle"), "{printed}");
    let test = &json(&out.join("inspection.json"))["tests"][0];
    assert_eq!(test["specimens"].as_array().map(Vec::len), Some(10));
    assert!((test["cycles"][0]["peak_mn"]["median"].as_f64().expect("a peak") - 10.9).abs() < 0.2, "{test}");
}

#[test]
fn what_is_ambiguous_is_asked_together() {
    let d = directory();
    let file = d.path().join("odd.csv");
    // No unit of the force, two clocks of one rank, a comma that may be either, a machine's coordinate.
    let row = |t: f64, d: f64, f: f64| {
        let thousand = |v: f64| format!("{:.3}", v + 1.0).replace('.', ",");
        format!("{};{};{};{}", thousand(t), thousand(t), thousand(d + 3.0), thousand(f + 2.0))
    };
    std::fs::write(&file, format!("step time;scan time;position [mm];force\n{}", table(row)))
        .expect("a file");
    let error = refuse(4, &["inspect", text(&file)]);
    for part in [
        "--column 'time=step time:s'",
        "--column 'force=force:mN'",
        "--decimal comma",
        "--zero contact",
        "--tare off-contact",
    ] {
        assert!(error.contains(part), "`{part}` is not in\n{error}");
    }
}

#[test]
fn clocks_in_hours_minutes_and_seconds_are_read() {
    let d = directory();
    let (file, out) = (d.path().join("clock.csv"), d.path().join("out"));
    let row =
        |t: f64, d: f64, f: f64| format!("0:{:02}:{:05.2},{d:.5},{f:.5}", 59 + (t / 60.0) as u32, t % 60.0);
    std::fs::write(&file, format!("Clock,displacement_mm,force_mN\n{}", table(row))).expect("a file");
    assert!(refuse(4, &["inspect", text(&file)]).contains("--column"));
    succeed(&["inspect", text(&file), "--column", "time=Clock:h:m:s", "--out", text(&out)]);
    check("clock", &out);
}

#[test]
fn doubtful_data_are_told_in_the_first_lines() {
    let d = directory();
    let file = d.path().join("m.csv");
    let inspect = |rows: String, head: &str| {
        std::fs::write(&file, format!("{head}\n{rows}")).expect("a file");
        one_line(&succeed(&["inspect", text(&file)]))
    };
    let own = "time_s,displacement_mm,force_mN";
    let plain = inspect(table(|t, d, f| format!("{t:.3},{d},{f}")), own);
    assert!(!plain.contains("doubtful"), "{plain}");
    let doubts: [(&str, String); 5] = [
        ("--flip=force", table(|t, d, f| format!("{t:.3},{d},{}", -f))),
        ("--zero contact", table(|t, d, f| format!("{t:.3},{},{f}", d + 0.1))),
        ("--tare off-contact", table(|t, d, f| format!("{t:.3},{d},{}", f + 2.0))),
        ("at its limit", table(|t, d, f| format!("{t:.3},{d},{}", f.min(7.5)))),
        ("the clock jumps", table(|t, d, f| format!("{:.3},{d},{f}", if t > 4.0 { t + 9.0 } else { t }))),
    ];
    for (part, rows) in doubts {
        let printed = inspect(rows, own);
        assert!(
            printed.starts_with("warning: ") && printed.find(part).is_some_and(|at| at < 200),
            "{part}: {printed}"
        );
    }
    let refused: [(&str, String); 3] = [
        (
            "stands for a value that is missing",
            table(|t, d, f| if t == 3.0 { format!("{t},{d},-9999") } else { format!("{t:.3},{d},{f}") }),
        ),
        (
            "beyond everything",
            table(|t, d, f| if t == 3.0 { format!("{t},{d},1e30") } else { format!("{t:.3},{d},{f}") }),
        ),
        ("second column", table(|t, d, f| format!("{t:.3},{d},{f}"))),
    ];
    for (part, rows) in refused {
        let head = if part == "second column" { "time_s,displacement_mm,displacement_mm" } else { own };
        std::fs::write(&file, format!("{head}\n{rows}")).expect("a file");
        let error = refuse(4, &["inspect", text(&file)]);
        assert!(error.contains(part) && error.contains("remedy"), "{part}: {error}");
    }
    std::fs::write(&file, format!("{own}\n{}", table(|t, d, f| format!("{t:.3},{d},{f}")))).expect("a file");
    let copy = d.path().join("copy.csv");
    std::fs::copy(&file, &copy).expect("a copy");
    let error = refuse(4, &["inspect", text(&file), text(&copy)]);
    assert!(error.contains("are the same data") && error.contains("copy.csv"), "{error}");
}

#[test]
fn the_measured_files_of_this_repository_are_read() {
    let d = directory();
    for name in ["hayes_relax_1", "hayes_relax_2", "hayes_relax_3"] {
        let (file, out) = (repository(&format!("data/measured/{name}.csv")), d.path().join(name));
        let printed = succeed(&["inspect", text(&file), "--out", text(&out)]);
        assert!(!printed.contains("SYNTHETIC"), "{printed}");
        let cycles = json(&out.join("inspection.json"))["tests"][0]["cycles"].as_array().map(Vec::len);
        assert_eq!(cycles, Some(1), "{printed}");
    }
    // The position of the platen and the preload are told, not taken for granted.
    for (ramp, preload) in [("ramp1", "249."), ("ramp2", ""), ("ramp3", "")] {
        let file = repository(&format!("data/measured/cartilage_unconfined_{ramp}.csv"));
        let printed = one_line(&succeed(&["inspect", text(&file)]));
        assert!(printed.starts_with("warning: ") && printed.contains("--zero contact"), "{printed}");
        let preload = format!("the force is {preload}");
        assert!(printed.contains(&preload) && printed.contains("--tare none"), "{printed}");
    }
}
