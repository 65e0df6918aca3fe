//! Each kind of bad file gives its own error at the right place; good ones in odd dress are read.

use super::*;

const GOOD: &str = "time_s,displacement_mm,force_mN\n0,-0.1,0\n0.1,0,0\n0.2,0.1,2\n0.3,0.2,3\n0.4,0.3,4\n";

fn parse(text: &str) -> Result<Measurement, DataError> {
    read_str(text, Path::new("dir/P9.csv"), Wanted::MotionAndForce)
}

fn failure(text: &str) -> DataError {
    parse(text).expect_err("the file is bad")
}

#[test]
fn plain_file_is_read_in_si() {
    let m = parse(GOOD).unwrap();
    assert_eq!(m.name, "P9");
    assert_eq!(m.time_s[4], 0.4);
    assert_eq!(m.displacement_m[4], 0.3 * 1e-3);
    assert_eq!(m.force_n[4], 4.0 * 1e-3);
    assert!(m.spread_n.is_none() && m.specimens_n.is_empty() && m.notes.is_empty());
}

#[test]
fn bom_crlf_comments_blanks_and_semicolons_do_not_matter() {
    let plain = parse(GOOD).unwrap();
    let crlf = parse(&format!("\u{feff}# synthetic\n{GOOD}").replace('\n', "\r\n")).unwrap();
    assert_eq!((&crlf.time_s, &crlf.force_n), (&plain.time_s, &plain.force_n));
    assert!(crlf.is_synthetic());
    let semicolons = parse(&GOOD.replace(',', " ; ")).unwrap();
    assert_eq!(semicolons.force_n, plain.force_n);
    assert_eq!(semicolons.notes.len(), 1);
}

#[test]
fn columns_that_are_not_needed_are_told() {
    let text: String = GOOD
        .lines()
        .map(|l| if l.starts_with('t') { format!("{l},mood\n") } else { format!("{l},fine\n") })
        .collect();
    let m = parse(&text).unwrap();
    assert_eq!(m.force_n, parse(GOOD).unwrap().force_n);
    assert_eq!(m.notes, ["columns that are not used: mood"]);
}

#[test]
fn units_are_converted() {
    let text = GOOD.replace("time_s,displacement_mm,force_mN", "Time [ms],Depth (um),Load_N");
    let m = parse(&text).unwrap();
    assert_eq!((m.time_s[4], m.displacement_m[4], m.force_n[4]), (0.4 * 1e-3, 0.3 * 1e-6, 4.0));
    assert_eq!(m.notes.len(), 3);
}

#[test]
fn specimen_columns_give_median_and_spread() {
    let text = GOOD.replace("force_mN", "s01,s02,s03");
    let text: String = text
        .lines()
        .map(|l| if l.starts_with('t') { format!("{l}\n") } else { format!("{l},1,5\n") })
        .collect();
    let m = parse(&text).unwrap();
    assert_eq!(m.specimens_n.len(), 3);
    assert_eq!(m.force_n, [1.0, 1.0, 2.0, 3.0, 4.0].map(|f| f * 1e-3));
    assert!((m.spread_n.unwrap()[2] - 2.081_665_999_466_13e-3).abs() < 1e-15);
}

#[test]
fn a_specimen_column_groups_the_rows() {
    let rows = GOOD.lines().skip(1);
    let body: String = ["a", "b"]
        .iter()
        .flat_map(|s| rows.clone().map(move |r| format!("{s},{r}{}\n", if *s == "b" { ".5" } else { "" })))
        .collect();
    let m = parse(&format!("specimen,time_s,displacement_mm,force_mN\n{body}")).unwrap();
    assert_eq!((m.len(), m.specimens_n.len()), (5, 2));
    let shifted = body.replace("b,0.4", "b,0.5");
    let error = failure(&format!("specimen,time_s,displacement_mm,force_mN\n{shifted}"));
    assert!(matches!(error.problem, Problem::SpecimensDiffer { .. }));
}

#[test]
fn quartiles_become_a_deviation() {
    let text: String = GOOD
        .lines()
        .map(|l| {
            if l.starts_with('t') { format!("{l},force_q25_mN,force_q75_mN\n") } else { format!("{l},1,3\n") }
        })
        .collect();
    assert!((parse(&text).unwrap().spread_n.unwrap()[0] - 1.482_602e-3).abs() < 1e-8);
    let error = failure(&text.replace(",1,3", ",3,1"));
    assert!(matches!(error.problem, Problem::NegativeSpread(_)));
}

/// (what, replacement in the good file, line, column, text of the message)
#[test]
fn every_bad_file_is_named_with_place_and_remedy() {
    type Case = (&'static str, &'static str, &'static str, Option<u64>, Option<&'static str>, &'static str);
    let cases: &[Case] = &[
        ("unknown column", "force_mN", "mood", Some(1), Some("mood"), "unknown column"),
        ("missing column", "force_mN", "force_std_mN", Some(1), None, "no column for the force"),
        ("no unit", "force_mN", "force", Some(1), Some("force"), "has no unit"),
        ("wrong unit", "displacement_mm", "displacement_s", Some(1), Some("displacement_s"), "not a unit"),
        ("twice", "force_mN", "force_mN,force_N", Some(1), Some("force_N"), "second column"),
        ("no header", "time_s,displacement_mm,force_mN\n", "", Some(1), None, "not a header"),
        ("not monotonic", "0.3,0.2", "0.1,0.2", Some(5), Some("time"), "does not come after"),
        ("nan", "0.2,0.1,2", "0.2,0.1,NaN", Some(4), Some("force_mN"), "not a finite number"),
        ("word", "0.2,0.1,2", "0.2,low,2", Some(4), Some("displacement_mm"), "not a number"),
        ("empty field", "0.2,0.1,2", "0.2,,2", Some(4), Some("displacement_mm"), "field is empty"),
        ("ragged", "0.2,0.1,2", "0.2,0.1", Some(4), None, "has 2 fields"),
        ("too few", "0.3,0.2,3\n0.4,0.3,4\n", "", None, None, "too few"),
    ];
    for (what, from, to, line, column, message) in cases {
        let error = failure(&GOOD.replacen(from, to, 1));
        assert_eq!(error.line, *line, "{what}: {error}");
        assert_eq!(error.column.as_deref(), *column, "{what}: {error}");
        let text = error.to_string();
        assert!(
            text.contains(message) && text.contains("remedy: ") && text.contains("P9.csv"),
            "{what}: {text}"
        );
    }
}

#[test]
fn a_punch_that_never_touches_is_an_error() {
    let text: String = GOOD.replace("0.1,2", "-0.1,2").replace("0.2,3", "-0.2,3").replace("0.3,4", "-0.3,4");
    assert!(matches!(failure(&text).problem, Problem::NeverTouches { .. }));
}

#[test]
fn empty_and_missing_files() {
    assert_eq!(failure("").problem, Problem::Empty);
    assert_eq!(failure("# only a comment\n\n").problem, Problem::Empty);
    let error = failure("time_s,displacement_mm,force_mN\n");
    assert_eq!(error.problem, Problem::TooFewPoints { found: 0, needed: 5 });
    let error = read(Path::new("/nonexistent/x.csv"), Wanted::Motion).expect_err("no such file");
    assert!(matches!(error.problem, Problem::Unreadable(_)));
}

#[test]
fn motion_alone_needs_no_force() {
    let text: String = GOOD.lines().map(|l| format!("{}\n", l.rsplit_once(',').unwrap().0)).collect();
    assert!(parse(&text).is_err());
    let m = read_str(&text, Path::new("x.csv"), Wanted::Motion).unwrap();
    assert_eq!((m.len(), m.force_n.len()), (5, 0));
}
