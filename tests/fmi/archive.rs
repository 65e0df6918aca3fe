//! A. The archive: valid, complete, reproducible, and the lint that finds what validators miss.

use super::support::{archive, fmu, python};
use poropunch::model_description::{guid, xml};
use runner::fmi::builtin_library;
use runner::package::{lint, lint_description, write_archive};
use std::io::Read;
use std::process::Command;

#[test]
fn fmpy_finds_no_problem() {
    assert_eq!(python(&["validate", archive().to_str().unwrap()]).trim(), "");
}

#[test]
fn our_lint_finds_no_problem() {
    assert_eq!(lint(archive()).unwrap(), Vec::<String>::new());
}

#[test]
fn our_lint_finds_each_planted_problem() {
    let good = xml();
    let swapped = {
        let section = good.find("<InitialUnknowns>").unwrap();
        let (head, tail) = good.split_at(section);
        head.to_owned()
            + &tail
                .replacen("index=\"3\"", "index=\"999\"", 1)
                .replacen("index=\"4\"", "index=\"3\"", 1)
                .replacen("index=\"999\"", "index=\"4\"", 1)
    };
    let planted = [
        (swapped, "InitialUnknowns are not in ascending order"),
        (good.replacen("valueReference=\"1\"", "valueReference=\"0\"", 1), "value reference 0 is used twice"),
        (good.replacen("start=\"0.032\"", "start=\"-1.0\"", 1), "outside its own range"),
        (good.replacen("start=\"0.032\"", "start=\"NaN\"", 1), "is not finite"),
        (good.replacen(" start=\"0.032\"", "", 1), "no start value"),
        (
            good.replacen("canGetAndSetFMUstate=\"true\"", "canGetAndSetFMUstate=\"false\"", 1),
            "canSerializeFMUstate without canGetAndSetFMUstate",
        ),
        (
            good.replacen("modelIdentifier=\"poropunch\"", "modelIdentifier=\"poro-punch\"", 1),
            "not a C identifier",
        ),
        (good.replacen("name=\"force_solid\"", "name=\"force\"", 1), "the name is used twice"),
        (good.replacen("<BaseUnit m=\"1\"/>", "", 1), "no BaseUnit"),
        (good.replacen("Unit name=\"N\"", "Unit name=\"kN\"", 1), "its unit is not defined"),
        (good.replacen(guid(), " ", 1), "the GUID is empty"),
    ];
    for (xml, expected) in planted {
        assert_ne!(xml, good, "nothing planted for: {expected}");
        let problems = lint_description(&xml).unwrap();
        assert!(problems.iter().any(|p| p.contains(expected)), "not found: {expected}; found {problems:?}");
    }
}

#[test]
fn the_lint_compares_starts_with_the_binary() {
    let folder = tempfile::TempDir::new().unwrap();
    let file = std::fs::File::open(archive()).unwrap();
    zip::ZipArchive::new(file).unwrap().extract(folder.path()).unwrap();
    let other = xml().replacen("start=\"0.032\"", "start=\"0.033\"", 1);
    std::fs::write(folder.path().join("modelDescription.xml"), other).unwrap();
    let problems = lint(folder.path()).unwrap();
    assert_eq!(problems, ["material.n0s: start is 0.033 in the description and 0.032 in the binary"]);
}

#[test]
fn has_everything_and_is_the_same_byte_for_byte() {
    let bytes = std::fs::read(archive()).unwrap();
    let again = tempfile::TempDir::new().unwrap();
    let path = again.path().join("again.fmu");
    write_archive(&path, &builtin_library().unwrap()).unwrap();
    assert!(std::fs::read(&path).unwrap() == bytes, "two archives of the same contents differ");

    let mut zip = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
    let names: Vec<_> = zip.file_names().map(|name| name.unwrap().into_owned()).collect();
    for expected in [
        "modelDescription.xml",
        "model.png",
        "documentation/index.html",
        "documentation/licenses/license.txt",
        "binaries/linux64/poropunch.so",
    ] {
        assert!(names.iter().any(|name| name == expected), "{expected} is missing in {names:?}");
    }
    let mut page = String::new();
    zip.by_name("documentation/index.html").unwrap().read_to_string(&mut page).unwrap();
    for variable in &fmu().description().variables {
        assert!(page.contains(&format!("<code>{}</code>", variable.name)), "{} undocumented", variable.name);
    }
}

#[test]
fn the_binary_exports_the_34_functions_and_nothing_else() {
    let output = Command::new("nm").args(["-D", "--defined-only"]).arg(fmu().library()).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let exports: Vec<_> = text.lines().filter_map(|line| line.split_whitespace().nth(2)).collect();
    assert_eq!(exports.len(), 34, "{exports:?}");
    assert!(exports.iter().all(|name| name.starts_with("fmi2")), "{exports:?}");
}
