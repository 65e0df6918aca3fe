//! What can be seen of macOS' library on another system: not that it runs, which nobody here has a Mac for.
//!
//! Goal: a Mac's loader finds in it what it wants, for both processors. Reference: the names that Linux' library exports; Apple's
//! description of a signature ("TN3126"), of which `signature.py` computes the hashes anew.

use super::library;
use crate::fmi::support::script;
use object::macho::{CPU_TYPE_ARM64, CPU_TYPE_X86_64};
use object::read::macho::{FatArch, MachOFatFile32};
use object::{File, Object};
use std::collections::BTreeSet;

/// Names of the exported functions, without the underscore of Apple's linker.
fn exports(file: &File) -> BTreeSet<String> {
    let names = file.exports().unwrap();
    let text = |name: &[u8]| String::from_utf8(name.to_vec()).unwrap().trim_start_matches('_').to_owned();
    names.iter().map(|export| text(export.name())).collect()
}

#[test]
#[ignore = "long: builds the libraries of all platforms"]
fn for_macos_the_library_is_whole() {
    let linux = std::fs::read(library("linux64", ".so")).unwrap();
    let expected = exports(&File::parse(&*linux).unwrap());
    assert_eq!(expected.len(), 34 + 75);
    let path = library("darwin64", ".dylib");
    let bytes = std::fs::read(&path).unwrap();
    let universal = MachOFatFile32::parse(&*bytes).unwrap();
    let machines: Vec<u32> = universal.arches().iter().map(FatArch::cputype).collect();
    assert_eq!(machines, [CPU_TYPE_X86_64, CPU_TYPE_ARM64]);
    for slice in universal.arches() {
        let file = File::parse(slice.data(&*bytes).unwrap()).unwrap();
        assert_eq!(exports(&file), expected);
        let imports = file.imports().unwrap();
        let libraries: BTreeSet<&[u8]> = imports.iter().map(|import| import.library()).collect();
        assert_eq!(libraries, [&b"/usr/lib/libSystem.B.dylib"[..]].into());
    }
    let signed = script("signature.py", &[path.to_str().unwrap()]);
    println!("{signed}");
    assert!(signed.lines().any(|line| line.starts_with("arm64: ")), "{signed}");
}
