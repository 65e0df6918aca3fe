//! The platforms an archive can have binaries for.

use crate::fmi::{PLATFORM, Version};
use object::{Architecture, BinaryFormat};
use std::path::PathBuf;
use std::str::FromStr;
use thiserror::Error;

/// A folder of `binaries/`, and what its library has to be.
#[derive(Debug, PartialEq, Eq)]
pub struct Platform {
    /// Name of the folder.
    pub folder: &'static str,
    /// End of the library's name.
    pub suffix: &'static str,
    pub(super) format: BinaryFormat,
    /// A library for several machines at once (universal) has to be for all of these.
    pub(super) machines: &'static [Architecture],
}

const fn platform(
    folder: &'static str,
    suffix: &'static str,
    format: BinaryFormat,
    machines: &'static [Architecture],
) -> Platform {
    Platform { folder, suffix, format, machines }
}

use Architecture::{Aarch64, X86_64};
use BinaryFormat::{Elf, MachO, Pe};

/// FMI 2.0.5 (section 2.3) has names for x86 only, and sends everybody else to FMI 3.0's tuples. Macs with arm look into
/// `aarch64-darwin` and, all importers that we know, into `darwin64`: a universal library there serves both.
pub static PLATFORMS: [Platform; 8] = [
    platform("linux64", ".so", Elf, &[X86_64]),
    platform("win64", ".dll", Pe, &[X86_64]),
    platform("darwin64", ".dylib", MachO, &[X86_64, Aarch64]),
    platform("aarch64-linux", ".so", Elf, &[Aarch64]),
    platform("aarch64-darwin", ".dylib", MachO, &[Aarch64]),
    platform("x86_64-linux", ".so", Elf, &[X86_64]),
    platform("x86_64-windows", ".dll", Pe, &[X86_64]),
    platform("x86_64-darwin", ".dylib", MachO, &[X86_64]),
];

/// No such platform.
#[derive(Debug, Error)]
pub enum BadBinary {
    /// Not of the form PLATFORM=FILE.
    #[error("`{0}` is not of the form PLATFORM=FILE, such as win64=poropunch.dll")]
    Form(String),
    /// A folder that no importer looks into.
    #[error("there is no platform `{found}`; there are {known}", known = known())]
    Platform {
        /// What was asked for.
        found: String,
    },
}

fn known() -> String {
    PLATFORMS.each_ref().map(|p| p.folder).join(", ")
}

impl Platform {
    /// The platform of a folder's name.
    pub fn of(folder: &str) -> Option<&'static Self> {
        PLATFORMS.iter().find(|platform| platform.folder == folder)
    }
}

impl Platform {
    /// Folders of an archive in which its library lies: FMI 3.0 has other names, and one for each machine of a universal library.
    pub fn folders(&'static self, version: Version) -> Vec<&'static str> {
        match (version, self.folder) {
            (Version::Three, "linux64") => vec!["x86_64-linux"],
            (Version::Three, "win64") => vec!["x86_64-windows"],
            (Version::Three, "darwin64") => vec!["x86_64-darwin", "aarch64-darwin"],
            (_, folder) => vec![folder],
        }
    }
}

/// A library for the archive, written `PLATFORM=FILE`.
#[derive(Debug, Clone)]
pub struct Binary {
    /// What it is for.
    pub platform: &'static Platform,
    /// Where it lies.
    pub library: PathBuf,
}

impl Binary {
    /// A library for the machine this program runs on.
    #[must_use]
    pub fn of_this_machine(library: PathBuf) -> Self {
        let platform =
            Platform::of(PLATFORM).expect("every platform this program is built for is in the table");
        Self { platform, library }
    }
}

impl FromStr for Binary {
    type Err = BadBinary;

    fn from_str(text: &str) -> Result<Self, BadBinary> {
        let (folder, library) = text.split_once('=').ok_or_else(|| BadBinary::Form(text.to_owned()))?;
        let platform =
            Platform::of(folder).ok_or_else(|| BadBinary::Platform { found: folder.to_owned() })?;
        Ok(Self { platform, library: library.into() })
    }
}
