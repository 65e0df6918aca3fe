//! The archive, the same byte for byte whenever its contents are the same.

use super::documentation::documentation;
use super::documentation3::documentation3;
use super::platform::Binary;
use super::reference::reference_files;
use crate::fmi::{FmiError, Version};
use crate::output::mark::words;
use crate::output::{OutputError, write_file};
use poropunch::model_description::{MODEL_IDENTIFIER, fmi3, xml};
use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Why the archive could not be written.
#[derive(Debug, Error)]
pub enum PackageError {
    /// A file that cannot be read or written.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// File.
        path: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// The place of the archive.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The description of the model.
    #[error(transparent)]
    Description(#[from] FmiError),
    /// Two libraries for one place.
    #[error("two binaries for {0}")]
    Twice(&'static str),
    /// The archive itself.
    #[error("the archive cannot be formed: {0}")]
    Zip(#[from] zip::result::ZipError),
}

/// The licences of the crates that are linked into the binary.
pub(super) const LICENSES: &str = "documentation/licenses/third-party.txt";
const ICON: &[u8] = include_bytes!("../../../cdylib/resources/model.png");
const LICENSE_MIT: &[u8] = include_bytes!("../../../LICENSE-MIT");
const LICENSE_APACHE: &[u8] = include_bytes!("../../../LICENSE-APACHE");
/// Written by licenses.py beside it.
const LICENSES_LINKED: &[u8] = include_bytes!("../../../cdylib/resources/licenses.txt");
const LICENSE_NOTE: &[u8] = b"poropunch is licensed under MIT OR Apache-2.0, at your choice: \
    see LICENSE-MIT.txt and LICENSE-APACHE.txt in this folder. What is linked into it: third-party.txt.\n";

/// Writes `poropunch.fmu` with one library for each of its platforms to `path`.
///
/// The file appears complete or not at all.
///
/// # Errors
/// When a library cannot be read, is one of two for a platform, or the archive cannot be written.
pub fn write_archive(version: Version, path: &Path, binaries: &[Binary]) -> Result<(), PackageError> {
    let io = |path: &Path| {
        let path = path.to_path_buf();
        move |source| PackageError::Io { path, source }
    };
    let mut libraries = BTreeMap::new();
    for Binary { platform, library } in binaries {
        let contents = std::fs::read(library).map_err(io(library))?;
        for folder in platform.folders(version) {
            let name = format!("binaries/{folder}/{MODEL_IDENTIFIER}{}", platform.suffix);
            if libraries.insert(name, contents.clone()).is_some() {
                return Err(PackageError::Twice(platform.folder));
            }
        }
    }
    let (description, documentation, icon, own) = match version {
        // The reference run's parameters have the names of FMI 2.0.
        Version::Two => (xml(), documentation(), "model.png", reference_files()?),
        Version::Three => {
            let terminals =
                ("terminalsAndIcons/terminalsAndIcons.xml".to_owned(), fmi3::terminals().into_bytes());
            (fmi3::xml(), documentation3(), "terminalsAndIcons/icon.png", vec![terminals])
        }
    };
    let mut entries: Vec<(&str, &[u8])> = vec![
        ("modelDescription.xml", description.as_bytes()),
        (icon, ICON),
        ("documentation/index.html", documentation.as_bytes()),
        ("documentation/licenses/license.txt", LICENSE_NOTE),
        ("documentation/licenses/LICENSE-MIT.txt", LICENSE_MIT),
        ("documentation/licenses/LICENSE-APACHE.txt", LICENSE_APACHE),
        (LICENSES, LICENSES_LINKED),
    ];
    entries.extend(libraries.iter().map(|(name, contents)| (name.as_str(), contents.as_slice())));
    entries.extend(own.iter().map(|(name, contents)| (name.as_str(), contents.as_slice())));
    // No clock and no user in the archive: equal contents give equal bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, contents) in entries {
        let mode = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        writer.start_file(name, options.unix_permissions(mode))?;
        writer.write_all(contents).map_err(io(path))?;
    }
    writer.set_comment(words())?;
    Ok(write_file(path, &writer.finish()?.into_inner())?)
}
