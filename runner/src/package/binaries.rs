//! What keeps an archive's libraries from other machines than the one they were built on.

use super::platform::Platform;
use object::macho::{CPU_TYPE_ARM64, CPU_TYPE_X86_64, LC_CODE_SIGNATURE, MachHeader64};
use object::read::macho::{FatArch, LoadCommandVariant, MachHeader, MachOFatFile32};
use object::{Architecture, BinaryFormat, Endianness, File, FileKind, Object, ObjectSection};
use std::path::Path;

/// Newest glibc that a library may need: that of manylinux2014 and of the oldest clusters in use.
const NEWEST_GLIBC: (u32, u32) = (2, 17);

/// Folders below which users' files lie; a path of them in a library is one of the machine that built it.
const USERS_FOLDERS: [&str; 5] = ["/home/", "/root/", "/Users/", "\\Users\\", "/.cargo/registry/"];

/// What FMI 2.0.5 demands of a co-simulation FMU.
const FUNCTIONS: [&str; 34] = [
    "fmi2CancelStep",
    "fmi2DeSerializeFMUstate",
    "fmi2DoStep",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2FreeFMUstate",
    "fmi2FreeInstance",
    "fmi2GetBoolean",
    "fmi2GetBooleanStatus",
    "fmi2GetDirectionalDerivative",
    "fmi2GetFMUstate",
    "fmi2GetInteger",
    "fmi2GetIntegerStatus",
    "fmi2GetReal",
    "fmi2GetRealOutputDerivatives",
    "fmi2GetRealStatus",
    "fmi2GetStatus",
    "fmi2GetString",
    "fmi2GetStringStatus",
    "fmi2GetTypesPlatform",
    "fmi2GetVersion",
    "fmi2Instantiate",
    "fmi2Reset",
    "fmi2SerializeFMUstate",
    "fmi2SerializedFMUstateSize",
    "fmi2SetBoolean",
    "fmi2SetDebugLogging",
    "fmi2SetFMUstate",
    "fmi2SetInteger",
    "fmi2SetReal",
    "fmi2SetRealInputDerivatives",
    "fmi2SetString",
    "fmi2SetupExperiment",
    "fmi2Terminate",
];

/// Problems of the libraries in `root/binaries` for machines other than the one they were built on.
pub fn lint_binaries(root: &Path, identifier: &str) -> std::io::Result<Vec<String>> {
    let mut problems = Vec::new();
    let mut folders: Vec<_> =
        std::fs::read_dir(root.join("binaries"))?.collect::<Result<Vec<_>, _>>()?.into_iter().collect();
    folders.sort_by_key(std::fs::DirEntry::file_name);
    for folder in folders {
        let name = folder.file_name().to_string_lossy().into_owned();
        let Some(platform) = Platform::of(&name) else {
            problems.push(format!("binaries/{name}: no platform that an importer looks for"));
            continue;
        };
        let file = format!("binaries/{name}/{identifier}{}", platform.suffix);
        match std::fs::read(root.join(&file)) {
            Err(error) => problems.push(format!("{file}: {error}")),
            Ok(bytes) => {
                let found = lint_library(&bytes, platform, identifier)
                    .unwrap_or_else(|error| vec![format!("not a library: {error}")]);
                problems.extend(found.into_iter().map(|problem| format!("{file}: {problem}")));
            }
        }
    }
    Ok(problems)
}

fn lint_library(bytes: &[u8], platform: &Platform, identifier: &str) -> object::Result<Vec<String>> {
    let parts = parts(bytes)?;
    let mut problems = Vec::new();
    for &machine in platform.machines {
        if !parts.iter().any(|(file, _)| file.architecture() == machine && file.format() == platform.format) {
            problems.push(format!("is not for {machine:?} and {:?}", platform.format));
        }
    }
    for (file, bytes) in &parts {
        lint_exports(file, &mut problems)?;
        lint_origin(file, bytes, &mut problems);
        match file.format() {
            BinaryFormat::Elf => lint_glibc(file, &mut problems)?,
            BinaryFormat::MachO => lint_macos(file, bytes, identifier, &mut problems)?,
            _ => {}
        }
    }
    Ok(problems)
}

/// The library, or those of a universal one that are for machines we know.
fn parts(bytes: &[u8]) -> object::Result<Vec<(File<'_>, &[u8])>> {
    if FileKind::parse(bytes)? != FileKind::MachOFat32 {
        return Ok(vec![(File::parse(bytes)?, bytes)]);
    }
    let machines = [CPU_TYPE_X86_64, CPU_TYPE_ARM64];
    let arches =
        MachOFatFile32::parse(bytes)?.arches().iter().filter(|arch| machines.contains(&arch.cputype()));
    arches
        .map(|arch| {
            let part = arch.data(bytes)?;
            Ok((File::parse(part)?, part))
        })
        .collect()
}

fn lint_exports(file: &File, problems: &mut Vec<String>) -> object::Result<()> {
    // Apple's linker puts an underscore before C's names.
    let prefix = if file.format() == BinaryFormat::MachO { "_" } else { "" };
    let exports = file.exports()?;
    let names: Vec<_> = exports.iter().map(|export| String::from_utf8_lossy(export.name())).collect();
    let names: Vec<_> = names.iter().map(|name| name.strip_prefix(prefix).unwrap_or(name)).collect();
    let foreign: Vec<_> =
        names.iter().filter(|n| !n.starts_with("fmi2") && !n.starts_with("fmi3")).copied().collect();
    if let [first, rest @ ..] = &foreign[..] {
        problems.push(format!("exports `{first}` and {} more names that are not FMI's", rest.len()));
    }
    for missing in FUNCTIONS.iter().filter(|function| !names.contains(function)) {
        problems.push(format!("does not export {missing}"));
    }
    Ok(())
}

/// Debug information, and paths of the machine that built it.
fn lint_origin(file: &File, bytes: &[u8], problems: &mut Vec<String>) {
    let mut sections = file.sections().filter_map(|section| Some(section.name().ok()?.to_owned()));
    if let Some(name) =
        sections.find(|name| [".debug", ".zdebug", "__debug"].iter().any(|d| name.starts_with(d)))
    {
        problems.push(format!("is not stripped of its debug information ({name})"));
    }
    let found = USERS_FOLDERS.iter().filter_map(|folder| {
        Some((bytes.windows(folder.len()).position(|window| window == folder.as_bytes())?, folder.len()))
    });
    if let Some((start, length)) = found.min() {
        let printable = |byte: &u8| byte.is_ascii_graphic();
        let before = bytes[..start].iter().rev().take(40).take_while(|b| printable(b)).count();
        let after = bytes[start + length..].iter().take(80).take_while(|b| printable(b)).count();
        let path = String::from_utf8_lossy(&bytes[start - before..start + length + after]);
        problems.push(format!("names a path of the machine that built it: {path}"));
    }
}

/// Versions of symbols stand among the names of the dynamic symbols, as `GLIBC_2.17`.
fn lint_glibc(file: &File, problems: &mut Vec<String>) -> object::Result<()> {
    let Some(names) = file.section_by_name(".dynstr") else { return Ok(()) };
    let needed = names.data()?.split(|&byte| byte == 0).filter_map(|name| {
        let mut numbers = std::str::from_utf8(name).ok()?.strip_prefix("GLIBC_")?.split('.');
        Some((numbers.next()?.parse().ok()?, numbers.next()?.parse().ok()?))
    });
    match needed.max() {
        Some((major, minor)) if (major, minor) > NEWEST_GLIBC => problems
            .push(format!("needs glibc {major}.{minor}, newer than {}.{}", NEWEST_GLIBC.0, NEWEST_GLIBC.1)),
        _ => {}
    }
    Ok(())
}

/// Without its install name the loader of a host that links the library looks where it was built; without a signature, if only one of
/// nobody, macOS on arm does not run it.
fn lint_macos(file: &File, bytes: &[u8], identifier: &str, problems: &mut Vec<String>) -> object::Result<()> {
    let header = MachHeader64::<Endianness>::parse(bytes, 0)?;
    let endian = header.endian()?;
    let mut commands = header.load_commands(endian, bytes, 0)?;
    let expected = format!("@rpath/{identifier}.dylib");
    let (mut name, mut is_signed) = (None, file.architecture() != Architecture::Aarch64);
    while let Some(command) = commands.next()? {
        is_signed |= command.cmd() == LC_CODE_SIGNATURE;
        if let LoadCommandVariant::IdDylib(id) = command.variant()? {
            name = Some(String::from_utf8_lossy(command.string(endian, id.dylib.name)?).into_owned());
        }
    }
    match name {
        Some(name) if name == expected => {}
        Some(name) => problems.push(format!("its install name is {name}, not {expected}")),
        None => problems.push("has no install name".to_owned()),
    }
    if !is_signed {
        problems.push("is not signed for arm".to_owned());
    }
    Ok(())
}
