//! Bad input of every kind ends in a message with place and remedy, and in no output.

use super::program::{directory, fail, text};

const GOOD: &str =
    "time_s,displacement_mm,force_mN\n0,-0.1,0\n0.1,0,0\n0.2,0.1,2\n0.3,0.2,3\n0.4,0.3,4\n0.5,0.3,3\n";

/// (what, text of the file, parts of the message)
#[test]
fn bad_measurements() {
    let cases: &[(&str, String, &[&str])] = &[
        (
            "missing column",
            GOOD.replace(",force_mN", ",force_std_mN"),
            &["no column for the force", "force_mN"],
        ),
        ("unknown column", GOOD.replace(",force_mN", ",mood"), &["line 1", "`mood`", "rename or remove"]),
        (
            "wrong unit",
            GOOD.replace("force_mN", "force_mm"),
            &["line 1", "`mm` is not a unit of force", "mN"],
        ),
        ("no unit", GOOD.replace("time_s", "time"), &["line 1", "`time`", "time_s"]),
        ("time", GOOD.replace("0.3,0.2", "0.2,0.2"), &["line 5", "`time`", "does not come after", "sort"]),
        ("nan", GOOD.replace("0.1,2", "0.1,nan"), &["line 4", "`force_mN`", "not a finite number"]),
        ("comma", GOOD.replace("0.1,2", "0.1,\"2,5\""), &["line 4", "decimal points"]),
        ("ragged", GOOD.replace("0.1,2", "0.1"), &["line 4", "2 fields"]),
        ("empty", String::new(), &["empty", "header"]),
        ("header only", GOOD.lines().next().unwrap_or("").to_owned(), &["0 points are too few"]),
        (
            "never touches",
            GOOD.replace("0.1,2", "-0.1,2").replace(",0.2,", ",-0.2,").replace(",0.3,", ",-0.3,"),
            &["never touches", "sign"],
        ),
        ("starts inside", GOOD.replace("-0.1,0", "0.05,0"), &["starts inside", "before first touch"]),
        ("too deep", GOOD.replace("_mm,", "_m,"), &["10 mm high", "unit of the displacement column"]),
    ];
    let d = directory();
    let (file, out) = (d.path().join("bad file.csv"), d.path().join("out"));
    for (what, contents, parts) in cases {
        std::fs::write(&file, contents).expect("a file");
        let error = fail(&["identify", text(&file), "--out", text(&out)]);
        for part in parts.iter().chain(&["bad file.csv", "remedy"]) {
            assert!(error.contains(part), "{what}: `{part}` is not in\n{error}");
        }
        assert!(!out.join("result.json").exists() && !out.join("poropunch.toml").exists(), "{what}");
    }
}

/// (arguments after `identify FILE`, parts of the message)
#[test]
fn bad_options() {
    let cases: &[(&[&str], &[&str])] = &[
        (
            &["--set", "material.permeabilty=1"],
            &["no parameter `material.permeabilty`", "did you mean material.permeability"],
        ),
        (&["--set", "material.permeability"], &["NAME=VALUE"]),
        (&["--set", "material.n0s=2"], &["material.n0s", "outside its bounds"]),
        (&["--set", "material.lambda_star=2mm"], &["`mm` is not a unit of Pressure"]),
        (&["--set", "geometry.punch_radius=1"], &["`1` has no unit", "geometry.punch_radius=1mm"]),
        (
            &["--bounds", "material.lambda_star=1:10Pa"],
            &["material.lambda_star is not fitted", "acts on nothing"],
        ),
        (
            &["--start", "material.lambda_star=1Pa"],
            &["material.lambda_star is not fitted", "acts on nothing"],
        ),
        (&["--weight", "recovery=2"], &["no fitted measurement has a point", "recovery"]),
        (&["--specimens", "9"], &["--specimens 9", "acts on nothing"]),
        (&["--set", "boundary.drained_top=maybe"], &["neither true nor false"]),
        (&["--mesh", "gigantic"], &["not one of coarse, standard, fine"]),
        (&["--set", "material.permeability=1e-15m^2"], &["both set and free", "--start"]),
        (&["--fix", "material.permeability", "--free", "material.permeability"], &["both free and fixed"]),
        (&["--start", "material.branch[1].mu=5Pa"], &["material.branch[1].mu", "outside its bounds"]),
        (&["--bounds", "material.branch[1].mu=-1:-10Pa"], &["not below upper bound"]),
        (&["--bounds", "material.branch[1].mu=-1"], &["NAME=LOWER:UPPER"]),
        (&["--tie", "material.branch[1].mu=material.branch[2].mu+1"], &["no parameter"]),
        (&["--weight", "holiday=2"], &["PHASE=WEIGHT"]),
        (&["--noise", "specimens"], &["at least three specimen columns"]),
        (&["--noise", "spread"], &["force_std_mN"]),
        (&["--fd-step", "2"], &["between 1e-6 and 0.2"]),
        (&["--weight", "hold=0", "--weight", "ramp=0"], &["points cannot determine 6 parameters"]),
    ];
    let d = directory();
    let (file, out) = (d.path().join("m.csv"), d.path().join("out"));
    std::fs::write(&file, GOOD).expect("a file");
    for (options, parts) in cases {
        let base = ["identify", text(&file), "--out", text(&out)];
        let error = fail(&[&base[..], options].concat());
        for part in *parts {
            assert!(error.contains(part), "{options:?}: `{part}` is not in\n{error}");
        }
    }
}

#[test]
fn bad_files_of_other_kinds() {
    let d = directory();
    let (file, fmu) = (d.path().join("m.csv"), d.path().join("not.fmu"));
    std::fs::write(&file, GOOD).expect("a file");
    std::fs::write(&fmu, "not a zip").expect("a file");
    let out = d.path().join("out");
    let error = fail(&["identify", "nowhere.csv", "--out", text(&out)]);
    assert!(error.contains("nowhere.csv") && error.contains("check the path"), "{error}");
    assert!(!out.exists(), "nothing was run, and a folder is left");
    let error = fail(&["simulate", "P3"]);
    assert!(error.contains("P3") && error.contains("P1"), "{error}");
    let error = fail(&["simulate", "P2", "--fmu", text(&fmu)]);
    assert!(error.contains("not.fmu"), "{error}");
    let error = fail(&["simulate", text(&file), "--out", text(&file.join("below"))]);
    assert!(error.contains("cannot write"), "{error}");
    let error = fail(&["report", text(&file)]);
    assert!(error.contains("poropunch.fit-report/1"), "{error}");
}
