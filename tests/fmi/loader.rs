//! What the loader says about FMUs that cannot be used.

use super::support::{archive, coarse, reference};
use poropunch::model_description::{fmi3, guid, xml};
use runner::fmi::{FmiError, Fmu};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// An unpacked FMU with the given description, and a binary in the folder of a platform.
fn folder(description: &str, platform: &str, binary: &[u8]) -> TempDir {
    let folder = TempDir::new().unwrap();
    let binaries = folder.path().join("binaries").join(platform);
    fs::create_dir_all(&binaries).unwrap();
    fs::write(folder.path().join("modelDescription.xml"), description).unwrap();
    fs::write(binaries.join("poropunch.so"), binary).unwrap();
    folder
}

fn refusal(path: &Path) -> String {
    Fmu::open(path).err().expect("the FMU must be refused").to_string()
}

#[test]
fn names_what_is_wrong_with_an_fmu() {
    let file = TempDir::new().unwrap();
    let text = file.path().join("text.fmu");
    fs::write(&text, "no zip").unwrap();
    assert!(refusal(&text).contains("an .fmu file is a zip archive"));
    assert!(refusal(&file.path().join("absent.fmu")).contains("absent.fmu"));

    let windows = refusal(folder(&xml(), "win64", b"").path());
    assert!(windows.contains("no binary for linux64") && windows.contains("win64"), "{windows}");
    let fmi1 = xml().replacen("fmiVersion=\"2.0\"", "fmiVersion=\"1.0\"", 1);
    assert!(refusal(folder(&fmi1, "linux64", b"").path()).contains("the FMU is for FMI 1.0"));
    let fmi3 = refusal(folder(&fmi3::xml(), "linux64", b"").path());
    assert!(fmi3.contains("no binary for x86_64-linux") && fmi3.contains("linux64"), "{fmi3}");
    let model_exchange = xml().replacen("<CoSimulation", "<ModelExchange", 1);
    assert!(refusal(folder(&model_exchange, "linux64", b"").path()).contains("no co-simulation"));
    let broken = refusal(folder("<fmiModelDescription>\n<a></b>", "linux64", b"").path());
    assert!(broken.starts_with("modelDescription.xml, line 2"), "{broken}");
    assert!(refusal(folder(&xml(), "linux64", b"garbage").path()).contains("cannot be loaded"));
}

#[test]
fn a_guid_of_another_build_is_refused_with_the_reason() {
    let other = xml().replacen(guid(), "{00000000-0000-0000-0000-000000000000}", 1);
    let binary = fs::read(runner::fmi::builtin_library().unwrap()).unwrap();
    let fmu = Fmu::open(folder(&other, "linux64", &binary).path()).unwrap();
    let Err(FmiError::Refused(reason)) = fmu.instantiate("test") else { panic!("must be refused") };
    assert!(reason.contains("GUID") && reason.contains(guid()), "{reason}");
}

#[test]
fn errors_carry_what_the_fmu_logged() {
    let mut instance = coarse();
    let error = instance.set_real(&[reference("material.n0s")], &[2.0]).unwrap_err().to_string();
    assert!(error.contains("material.n0s = 2 is outside [0.000001, 0.999]"), "{error}");
    assert!(Fmu::open(archive()).unwrap().description().variable("force").is_ok());
    let error = Fmu::builtin().unwrap().description().variable("forse").unwrap_err().to_string();
    assert_eq!(error, "the FMU has no variable `forse`");
}
