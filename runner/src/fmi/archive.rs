//! The files of an FMU: an archive unpacked for as long as it is used, or a folder.

use super::{FmiError, Version};
use std::fs::File;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// FMI 2.0 name of the platform this program runs on; FMI 3.0's tuple where 2.0 has none (2.0.5, section 2.3).
pub const PLATFORM: &str =
    match (cfg!(target_os = "windows"), cfg!(target_os = "macos"), cfg!(target_arch = "aarch64")) {
        (true, ..) => "win64",
        (_, true, _) => "darwin64",
        (.., true) => "aarch64-linux",
        _ => "linux64",
    };

/// FMI 3.0 name of the platform this program runs on.
pub const PLATFORM_TUPLE: &str =
    match (cfg!(target_os = "windows"), cfg!(target_os = "macos"), cfg!(target_arch = "aarch64")) {
        (true, _, true) => "aarch64-windows",
        (true, ..) => "x86_64-windows",
        (_, true, true) => "aarch64-darwin",
        (_, true, _) => "x86_64-darwin",
        (.., true) => "aarch64-linux",
        _ => "x86_64-linux",
    };

/// A folder with an FMU's files; removed with the last user where it was unpacked for the purpose.
#[derive(Debug)]
pub struct Files {
    root: PathBuf,
    _temporary: Option<TempDir>,
}

impl Files {
    /// An unpacked archive, or a folder as it is.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn open(path: &Path) -> Result<Self, FmiError> {
        if path.is_dir() {
            let root = std::path::absolute(path).map_err(|source| io(path, source))?;
            return Ok(Self { root, _temporary: None });
        }
        let file = File::open(path).map_err(|source| io(path, source))?;
        let not_an_archive = |reason: String| FmiError::NotAnArchive { path: path.to_path_buf(), reason };
        let mut archive = zip::ZipArchive::new(file).map_err(|e| not_an_archive(e.to_string()))?;
        let folder = tempfile::Builder::new().prefix("poropunch-").tempdir().map_err(|e| io(path, e))?;
        archive.extract(folder.path()).map_err(|e| not_an_archive(e.to_string()))?;
        Ok(Self { root: folder.path().to_path_buf(), _temporary: Some(folder) })
    }

    /// The folder with the FMU's files.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Text of `modelDescription.xml`.
    ///
    /// # Errors
    /// When there is none.
    pub fn description(&self) -> Result<String, FmiError> {
        let path = self.root.join("modelDescription.xml");
        std::fs::read_to_string(&path).map_err(|source| io(&path, source))
    }

    /// The binary of this platform.
    ///
    /// # Errors
    /// When there is none.
    pub fn binary(&self, version: Version, model_identifier: &str) -> Result<PathBuf, FmiError> {
        let wanted = match version {
            // Exporters on 64-bit arm, OpenModelica for one, write the name of x86.
            Version::Two => [PLATFORM, "linux64"],
            Version::Three => [PLATFORM_TUPLE; 2],
        };
        let file = format!("{model_identifier}{}", std::env::consts::DLL_SUFFIX);
        let paths = wanted.map(|folder| self.root.join("binaries").join(folder).join(&file));
        if let Some(path) = paths.into_iter().find(|path| path.is_file()) {
            return Ok(path);
        }
        let folders = std::fs::read_dir(self.root.join("binaries")).into_iter().flatten().flatten();
        let mut offered: Vec<_> = folders.map(|f| f.file_name().to_string_lossy().into_owned()).collect();
        offered.sort();
        let offered = if offered.is_empty() { "no platform".to_owned() } else { offered.join(", ") };
        Err(FmiError::Platform { wanted: wanted[0], file, offered })
    }

    /// `resources` as the path that FMI 3.0 passes.
    pub fn resource_path(&self) -> String {
        format!("{}{}", self.root.join("resources").display(), std::path::MAIN_SEPARATOR)
    }

    /// `resources` as the URI that `fmi2Instantiate` gets.
    pub fn resource_uri(&self) -> String {
        let path = self.root.join("resources");
        let mut uri = String::from("file://");
        if cfg!(windows) {
            uri.push('/');
        }
        for byte in path.to_string_lossy().replace('\\', "/").bytes() {
            match byte {
                b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'-' | b'_' | b'.' | b'~' | b':' => {
                    uri.push(byte as char);
                }
                _ => uri += &format!("%{byte:02X}"),
            }
        }
        uri
    }
}

fn io(path: &Path, source: std::io::Error) -> FmiError {
    FmiError::Io { path: path.to_path_buf(), source }
}
