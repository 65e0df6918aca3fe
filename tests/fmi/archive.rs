//! A. The archive: valid, complete, reproducible, and the lint that finds what validators miss.

use super::support::{archive, check_contents, check_lint, fmu, get, initialise, python};
use poropunch::model_description::{guid, xml};
use runner::fmi::{Version, builtin_library};
use runner::package::lint;
use std::io::Read;
use std::path::Path;
use std::process::Command;

#[test]
fn fmpy_finds_no_problem() {
    assert_eq!(python(&["validate", archive().to_str().unwrap()]).trim(), "");
}

#[test]
fn our_lint_finds_no_problem() {
    assert_eq!(lint(archive()).unwrap().own, Vec::<String>::new());
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
        (good.replacen("start=\"0.032\"", "start=\"NaN\"", 1), "is not finite"),
        (
            good.replacen("canGetAndSetFMUstate=\"true\"", "canGetAndSetFMUstate=\"false\"", 1),
            "canSerializeFMUstate without canGetAndSetFMUstate",
        ),
        (
            good.replacen("modelIdentifier=\"poropunch\"", "modelIdentifier=\"poro-punch\"", 1),
            "not a C identifier",
        ),
        (good.replacen("<BaseUnit m=\"1\"/>", "", 1), "no BaseUnit"),
        (good.replacen(guid(), " ", 1), "the GUID is empty"),
        (good.replacen(" nominal=\"1e-15\"", "", 1).replacen(" nominal=\"0.01\"", "", 1), "no nominal value"),
        (good.replacen("rad=\"1\"", "", 1), "unit rad"),
        (good.replace("the fluid part", "the solid part"), "the description of another"),
    ];
    check_lint(&good, planted);
}

#[test]
fn the_lint_compares_starts_with_the_binary() {
    let folder = tempfile::TempDir::new().unwrap();
    let file = std::fs::File::open(archive()).unwrap();
    zip::ZipArchive::new(file).unwrap().extract(folder.path()).unwrap();
    let other = xml().replacen("start=\"0.032\"", "start=\"0.033\"", 1);
    std::fs::write(folder.path().join("modelDescription.xml"), other).unwrap();
    let problems = lint(folder.path()).unwrap().own;
    assert_eq!(problems, ["material.n0s: start is 0.033 in the description and 0.032 in the binary"]);
}

/// The archive's files after `spoil`, in an archive again, and all that the checks say of it.
fn checked(spoil: impl FnOnce(&Path)) -> Vec<String> {
    let folder = tempfile::TempDir::new().unwrap();
    let root = folder.path().join("files");
    zip::ZipArchive::new(std::fs::File::open(archive()).unwrap()).unwrap().extract(&root).unwrap();
    spoil(&root);
    let path = folder.path().join("spoilt.fmu");
    let mut writer = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    let mut folders = vec![root.clone()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                folders.push(entry);
                continue;
            }
            let name = entry.strip_prefix(&root).unwrap().to_str().unwrap();
            writer.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
            std::io::Write::write_all(&mut writer, &std::fs::read(&entry).unwrap()).unwrap();
        }
    }
    writer.finish().unwrap();
    let found = lint(&path).unwrap();
    [found.own, found.elsewhere].concat()
}

fn edited(root: &Path, from: &str, to: &str) {
    let file = root.join("modelDescription.xml");
    let xml = std::fs::read_to_string(&file).unwrap();
    assert!(xml.contains(from), "nothing planted: {from}");
    std::fs::write(file, xml.replacen(from, to, 1)).unwrap();
}

/// A library of C in the folder of a platform.
fn compiled(root: &Path, platform: &str, source: &str, arguments: &[&str]) {
    let folder = root.join("binaries").join(platform);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("source.c"), source).unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-o", "poropunch.so", "source.c"]).args(arguments);
    assert!(compiler.current_dir(&folder).status().unwrap().success());
    std::fs::remove_file(folder.join("source.c")).unwrap();
}

/// One archive for each thing that keeps an FMU from other people's machines or importers; each is named.
#[test]
fn a_spoilt_archive_is_refused_for_each_reason() {
    type Spoil = fn(&Path);
    let cases: [(Spoil, &str); 9] = [
        (|root| edited(root, " dependencies=\"\"", ""), "no dependencies"),
        (|root| edited(root, " nominal=\"0.01\"", ""), "no nominal value"),
        (
            |root| std::fs::remove_file(root.join("documentation/licenses/third-party.txt")).unwrap(),
            "third-party.txt is missing",
        ),
        (
            |root| compiled(root, "x86_64-linux", "int helper(void) { return 1; }", &["-s"]),
            "poropunch.so: exports `helper` and 0 more names that are not FMI's",
        ),
        (
            |root| compiled(root, "x86_64-linux", "int fmi2Reset(void) { return 1; }", &["-s"]),
            "poropunch.so: does not export fmi2DoStep",
        ),
        (
            |root| compiled(root, "x86_64-linux", "int fmi2Reset(void) { return 1; }", &["-g"]),
            "poropunch.so: is not stripped of its debug information",
        ),
        (
            |root| {
                let source = "const char *fmi2Reset = \"/home/somebody/poropunch/lib.rs\";";
                compiled(root, "x86_64-linux", source, &["-s"]);
            },
            "names a path of the machine that built it: /home/somebody/poropunch/lib.rs",
        ),
        (
            |root| {
                // The only function that every machine has and that is as young as this: of glibc 2.25.
                let source = "#include <sys/random.h>\nint fmi2Reset(void) { return getentropy(0, 0); }";
                compiled(root, "x86_64-linux", source, &["-s"]);
            },
            "needs glibc 2.25, newer than 2.17",
        ),
        (
            |root| compiled(root, "aarch64-linux", "int fmi2Reset(void) { return 1; }", &["-s"]),
            "aarch64-linux/poropunch.so: is not for Aarch64",
        ),
    ];
    for (spoil, expected) in cases {
        let problems = checked(spoil);
        assert!(problems.iter().any(|p| p.contains(expected)), "not found: {expected}; found {problems:?}");
    }
}

/// What cargo builds for this machine is packaged for it; to be given away it must not name this machine.
#[test]
fn the_command_demands_of_archives_for_others_what_it_does_not_demand_of_its_own() {
    let folder = tempfile::TempDir::new().unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_runner"));
        let output = command.arg("package").args(arguments).current_dir(folder.path()).output().unwrap();
        let said = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
        (output.status.success(), said)
    };
    let (good, said) = run(&["--out", "own.fmu"]);
    assert!(good && said.contains("cdylib/build-all makes one for all"), "{said}");
    let (good, said) = run(&["--check", "own.fmu"]);
    assert!(!good && said.contains("names a path of the machine that built it"), "{said}");

    let library = builtin_library().unwrap();
    let (good, said) = run(&["--binary", &format!("win64={}", library.display())]);
    assert!(!good && said.contains("binaries/win64/poropunch.dll: is not for X86_64 and Pe"), "{said}");
    let (good, said) = run(&["--binary", "amiga=poropunch.library"]);
    assert!(!good && said.contains("there is no platform `amiga`; there are linux64, win64"), "{said}");
}

/// Linked crates and their licences, as cargo knows them: the file is made by hand after a change.
#[test]
fn the_licences_are_those_of_the_linked_crates() {
    // Those of cdylib/build-all, as far as cargo has seen their packages.
    let targets = ["x86_64-unknown-linux-gnu", "x86_64-pc-windows-gnullvm", "aarch64-apple-darwin"];
    let trees = targets.map(|target| {
        let tree = Command::new("cargo")
            .args(["tree", "--offline", "-p", "poropunch-cdylib", "-e", "normal,no-proc-macro"])
            .args(["--prefix", "none", "--format", "{p}: {l}", "--target", target])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        String::from_utf8(tree.stdout).unwrap()
    });
    assert!(trees[0].lines().count() > 20, "{trees:?}");
    let licences = include_str!("../../cdylib/resources/licenses.txt");
    let stale = "licenses.txt is stale: run `python3 cdylib/resources/licenses.py`";
    let lines = trees.iter().flat_map(|tree| tree.lines());
    for line in lines.filter(|line| !line.is_empty() && !line.starts_with("poropunch")) {
        let line = line.trim_end_matches(" (*)").replacen(" v", " ", 1);
        assert!(licences.lines().any(|l| l == line), "{line}: {stale}");
    }
}

#[test]
fn our_lint_finds_what_is_wrong_with_the_files() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::TempDir::new().unwrap();
    let copy = folder.path().join("copy.fmu");
    std::fs::copy(archive(), &copy).unwrap();
    std::fs::set_permissions(&copy, std::fs::Permissions::from_mode(0o600)).unwrap();
    assert_eq!(lint(&copy).unwrap().own, ["the archive has mode 600: others cannot read it"]);

    let unpacked = folder.path().join("unpacked");
    zip::ZipArchive::new(std::fs::File::open(archive()).unwrap()).unwrap().extract(&unpacked).unwrap();
    std::fs::remove_file(unpacked.join("documentation/licenses/third-party.txt")).unwrap();
    let problems = lint(&unpacked).unwrap().own;
    assert!(problems.iter().any(|p| p.contains("third-party.txt is missing")), "{problems:?}");
}

#[test]
fn has_everything_and_is_the_same_byte_for_byte() {
    let expected = [
        "modelDescription.xml",
        "model.png",
        "documentation/index.html",
        "documentation/licenses/license.txt",
        "documentation/licenses/third-party.txt",
        "binaries/linux64/poropunch.so",
        "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml",
    ];
    let mut zip = check_contents(Version::Two, archive(), &expected);
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

/// The default run as the archive's own reference has it. Tolerance: the reference has nine digits, processors differ in the last ones.
#[test]
fn the_reference_run_is_current_and_all_it_names_is_there() {
    let folder = "extra/org.fmi-standard.fmi-ls-ref";
    let mut zip = zip::ZipArchive::new(std::fs::File::open(archive()).unwrap()).unwrap();
    let mut read = |name: &str| {
        let mut text = String::new();
        zip.by_name(&format!("{folder}/{name}"))
            .unwrap_or_else(|e| panic!("{name}: {e}"))
            .read_to_string(&mut text)
            .unwrap();
        text
    };
    for document in ["fmi-ls-manifest.xml", "experiments.xml"] {
        let text = read(document);
        let xml = roxmltree::Document::parse(&text).unwrap();
        let sources: Vec<_> = xml.descendants().filter_map(|node| node.attribute("source")).collect();
        assert!(sources.len() >= 2, "{text}");
        sources.into_iter().for_each(|source| assert!(!read(source).is_empty(), "{source}"));
    }
    let stale = "stale: cdylib/resources/reference.py tells how to write it anew";
    let table = read("P2.csv");
    let rows = table.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect());
    let rows: Vec<Vec<f64>> = rows.collect();
    let mut instance = fmu().instantiate("reference").unwrap();
    initialise(&mut instance, None);
    let peak = rows.iter().map(|row| row[2]).fold(0.0, f64::max);
    for pair in rows.windows(2) {
        instance.do_step(pair[0][0], pair[1][0] - pair[0][0]).unwrap();
        let force = get(&mut instance, "force");
        assert!((force - pair[1][2]).abs() < 1e-6 * peak, "{force} at {pair:?}: {stale}");
    }
    assert_eq!(rows.last().unwrap()[0], fmu().description().default_experiment.stop_time.unwrap(), "{stale}");
}
