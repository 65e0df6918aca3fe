//! What is never written: files that this program has read as a user's input.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

static INPUTS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Keeps a user's file from being written by this process, whatever is asked of it later.
pub fn protect(file: &Path) {
    if let Ok(file) = file.canonicalize() {
        INPUTS.lock().unwrap_or_else(PoisonError::into_inner).insert(file);
    }
}

/// Reads a user's file, and protects it.
///
/// # Errors
/// When it cannot be read, or is a device.
pub fn read_input(file: &Path) -> std::io::Result<Vec<u8>> {
    protect(file);
    check_no_device(file)?;
    std::fs::read(file)
}

/// Refuses a device, which may have no end; a pipe has one.
///
/// # Errors
/// When it is one.
pub fn check_no_device(file: &Path) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        let is_device = |t: std::fs::FileType| t.is_char_device() || t.is_block_device();
        if file.metadata().is_ok_and(|m| is_device(m.file_type())) {
            return Err(std::io::Error::other("it is a device"));
        }
    }
    Ok(())
}

/// Whether a file is one of the inputs, under this or another name.
pub(super) fn is_input(file: &Path) -> bool {
    let file = file.canonicalize();
    file.is_ok_and(|f| INPUTS.lock().unwrap_or_else(PoisonError::into_inner).contains(&f))
}
