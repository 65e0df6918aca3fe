//! What the linkers of Windows and macOS have to be told about the library.

use std::{collections::BTreeSet, env, fs, path::PathBuf};

fn main() {
    println!("cargo::rerun-if-changed=src");
    match env::var("CARGO_CFG_TARGET_OS").unwrap_or_default().as_str() {
        // Hosts that link the library find it beside themselves, not where it was built.
        "macos" => println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/poropunch.dylib"),
        // zig does not get rustc's list of exports, and would export every function of the C library, too.
        "windows" if env::var("CARGO_CFG_TARGET_ENV").is_ok_and(|environment| environment == "gnu") => {
            let definition = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it")).join("fmi.def");
            let exports: String = functions().iter().map(|name| format!("    {name}\n")).collect();
            fs::write(&definition, format!("EXPORTS\n{exports}")).expect("the folder is cargo's");
            println!("cargo::rustc-cdylib-link-arg={}", definition.display());
        }
        _ => {}
    }
}

/// Names of the C functions: what is called `fmi` and a number in the sources, outside of comments and texts.
fn functions() -> BTreeSet<String> {
    let files = fs::read_dir("src").expect("this crate's sources").map(|file| file.expect("a file").path());
    let mut names = BTreeSet::new();
    for file in files.filter(|file| file.extension().is_some_and(|extension| extension == "rs")) {
        let source = fs::read_to_string(file).expect("a source file");
        for code in source.lines().filter_map(|line| line.split("//").next()) {
            let outside_texts = code.split('"').step_by(2);
            let words = outside_texts.flat_map(|part| part.split(|c: char| !c.is_ascii_alphanumeric()));
            names.extend(words.filter(|w| w.starts_with("fmi2") || w.starts_with("fmi3")).map(str::to_owned));
        }
    }
    names
}
