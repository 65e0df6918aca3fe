//! What the linkers of Windows and macOS have to be told about the library.

use std::{
    collections::BTreeSet,
    env, fs,
    path::{Path, PathBuf},
};

fn main() {
    println!("cargo::rerun-if-changed=src");
    match env::var("CARGO_CFG_TARGET_OS").unwrap_or_default().as_str() {
        // Hosts that link the library find it beside themselves, not where it was built. `lld` is the linker itself, others are
        // compilers that pass words on to theirs.
        "macos" if env::var("RUSTC_LINKER").is_ok_and(|linker| linker.ends_with("lld")) => {
            println!("cargo::rustc-cdylib-link-arg=-install_name");
            println!("cargo::rustc-cdylib-link-arg=@rpath/poropunch.dylib");
        }
        "macos" => println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/poropunch.dylib"),
        // zig does not get rustc's list of exports, and would export every function of the C library, too.
        "windows" if env::var("CARGO_CFG_TARGET_ENV").is_ok_and(|environment| environment == "gnu") => {
            let definition = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it")).join("fmi.def");
            let exports: String =
                functions(Path::new("src")).iter().map(|name| format!("    {name}\n")).collect();
            fs::write(&definition, format!("EXPORTS\n{exports}")).expect("the folder is cargo's");
            println!("cargo::rustc-cdylib-link-arg={}", definition.display());
        }
        _ => {}
    }
}

/// Names of the C functions: what is called `fmi` and a number in the sources, outside of comments and texts.
fn functions(folder: &Path) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for entry in
        fs::read_dir(folder).expect("this crate's sources").map(|entry| entry.expect("a file").path())
    {
        if entry.is_dir() {
            names.extend(functions(&entry));
            continue;
        }
        let source = fs::read_to_string(entry).expect("a source file");
        for code in source.lines().filter_map(|line| line.split("//").next()) {
            let outside_texts = code.split('"').step_by(2);
            let words = outside_texts.flat_map(|part| part.split(|c: char| !c.is_ascii_alphanumeric()));
            let is_name = |w: &&str| {
                ["fmi2", "fmi3"]
                    .iter()
                    .any(|v| w.strip_prefix(v).is_some_and(|rest| rest.starts_with(char::is_uppercase)))
            };
            names.extend(words.filter(is_name).map(str::to_owned));
        }
    }
    names
}
