//! An FMU: its description and its library.

use super::archive::Files;
use super::binary2::Binary2;
use super::binary3::Binary3;
use super::instance::Face;
use super::instance2::Instance2;
use super::instance3::Instance3;
use super::{FmiError, FmuInstance, ModelDescription, Version};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The functions of a library, by the version of FMI.
#[derive(Clone)]
enum Binary {
    Two(Arc<Binary2>),
    Three(Arc<Binary3>),
}

impl Binary {
    fn load(version: Version, path: &Path) -> Result<Self, FmiError> {
        Ok(match version {
            Version::Two => Self::Two(Arc::new(Binary2::load(path)?)),
            Version::Three => Self::Three(Arc::new(Binary3::load(path)?)),
        })
    }
}

/// A loaded FMU; clones share it.
#[derive(Clone)]
pub struct Fmu {
    description: Arc<ModelDescription>,
    // Dropped before the files it was loaded from.
    binary: Binary,
    files: Option<Arc<Files>>,
    location: PathBuf,
}

impl Fmu {
    /// An `.fmu` archive, or the folder of an unpacked one.
    ///
    /// # Errors
    /// When it is no FMI 2.0 or 3.0 co-simulation FMU for this machine.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FmiError> {
        Self::of(Arc::new(Files::open(path.as_ref())?))
    }

    /// The same from files that are unpacked already.
    ///
    /// # Errors
    /// As [`Fmu::open`].
    pub fn of(files: Arc<Files>) -> Result<Self, FmiError> {
        let description = ModelDescription::parse(&files.description()?)?;
        let location = files.binary(description.version, &description.model_identifier)?;
        let binary = Binary::load(description.version, &location)?;
        Ok(Self { description: Arc::new(description), binary, files: Some(files), location })
    }

    /// This project's own FMU: the library that cargo built beside the running program.
    ///
    /// # Errors
    /// When it is not there.
    pub fn builtin() -> Result<Self, FmiError> {
        Self::own(builtin_library()?)
    }

    /// The same from a library that lies elsewhere, of this very version.
    ///
    /// # Errors
    /// When it cannot be loaded.
    pub fn own(location: PathBuf) -> Result<Self, FmiError> {
        let description = ModelDescription::parse(&poropunch::model_description::xml())?;
        let binary = Binary::load(description.version, &location)?;
        Ok(Self { description: Arc::new(description), binary, files: None, location })
    }

    /// What the FMU says about itself.
    pub fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// The shared library that is loaded.
    pub fn library(&self) -> &Path {
        &self.location
    }

    /// A new instance.
    ///
    /// # Errors
    /// When the FMU refuses, with its reason (a GUID that does not match, for one).
    pub fn instantiate(&self, name: &str) -> Result<FmuInstance, FmiError> {
        FmuInstance::new(self, name)
    }

    /// A new instance behind its version of FMI.
    pub(super) fn face(&self, name: &str) -> Result<Box<dyn Face>, FmiError> {
        let (description, files) = (&self.description, self.files.as_ref());
        Ok(match &self.binary {
            Binary::Two(binary) => Box::new(Instance2::new(binary, description, files, name)?),
            Binary::Three(binary) => Box::new(Instance3::new(binary, description, files, name)?),
        })
    }
}

/// The newest of the library's copies around this program: cargo keeps one in `deps` and links it one
/// folder up, and tests run from `deps`.
pub fn builtin_library() -> Result<PathBuf, FmiError> {
    let file = format!("{}poropunch_fmi{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let program = std::env::current_exe()
        .map_err(|source| FmiError::Io { path: PathBuf::from("the running program"), source })?;
    let folder = program.parent().unwrap_or(Path::new("."));
    let folders = [folder.to_path_buf(), folder.join("deps"), folder.join("..")];
    let modified = |path: &PathBuf| path.metadata().and_then(|m| m.modified()).ok();
    let found = folders.iter().map(|folder| folder.join(&file)).filter(|path| path.is_file());
    found.max_by_key(modified).ok_or_else(|| {
        let looked: Vec<_> = folders.iter().map(|folder| folder.display().to_string()).collect();
        FmiError::NoBuiltin { file, looked: looked.join(", ") }
    })
}
