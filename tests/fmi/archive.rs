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
        (good.replacen(" dependencies=\"\"", "", 1), "no dependencies"),
        (good.replacen(" nominal=\"1e-15\"", "", 1).replacen(" nominal=\"0.01\"", "", 1), "no nominal value"),
        (good.replacen("rad=\"1\"", "", 1), "unit rad"),
        (good.replacen(" tolerance=", " notTolerance=", 1), "DefaultExperiment: no tolerance"),
        (good.replace("the fluid part", "the solid part"), "the description of another"),
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

/// Linked crates and their licences, as cargo knows them: the file is made by hand after a change.
#[test]
fn the_licences_are_those_of_the_linked_crates() {
    let tree = Command::new("cargo")
        .args(["tree", "--offline", "-p", "poropunch-cdylib", "-e", "normal,no-proc-macro"])
        .args(["--prefix", "none", "--format", "{p}: {l}"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let tree = String::from_utf8(tree.stdout).unwrap();
    let licences = include_str!("../../cdylib/resources/licenses.txt");
    let stale = "licenses.txt is stale: run `python3 cdylib/resources/licenses.py`";
    let mut crates = 0;
    for line in tree.lines().filter(|line| !line.is_empty() && !line.starts_with("poropunch")) {
        let line = line.trim_end_matches(" (*)").replacen(" v", " ", 1);
        assert!(licences.lines().any(|l| l == line), "{line}: {stale}");
        crates += 1;
    }
    assert!(crates > 20, "{tree}");
}

#[test]
fn our_lint_finds_what_is_wrong_with_the_files() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::TempDir::new().unwrap();
    let copy = folder.path().join("copy.fmu");
    std::fs::copy(archive(), &copy).unwrap();
    std::fs::set_permissions(&copy, std::fs::Permissions::from_mode(0o600)).unwrap();
    assert_eq!(lint(&copy).unwrap(), ["the archive has mode 600: others cannot read it"]);

    let unpacked = folder.path().join("unpacked");
    zip::ZipArchive::new(std::fs::File::open(archive()).unwrap()).unwrap().extract(&unpacked).unwrap();
    std::fs::remove_file(unpacked.join("documentation/licenses/third-party.txt")).unwrap();
    let problems = lint(&unpacked).unwrap();
    assert!(problems.iter().any(|p| p.contains("third-party.txt is missing")), "{problems:?}");
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
        "documentation/licenses/third-party.txt",
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
fn the_binary_exports_the_functions_of_both_versions_and_nothing_else() {
    let output = Command::new("nm").args(["-D", "--defined-only"]).arg(fmu().library()).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let exports: Vec<_> = text.lines().filter_map(|line| line.split_whitespace().nth(2)).collect();
    let of = |version: &str| exports.iter().filter(|name| name.starts_with(version)).count();
    assert_eq!((of("fmi2"), of("fmi3"), exports.len()), (34, 75, 109), "{exports:?}");
}
