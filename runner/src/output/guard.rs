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
/// When it cannot be read.
pub fn read_input(file: &Path) -> std::io::Result<Vec<u8>> {
    protect(file);
    std::fs::read(file)
}

/// Whether a file is one of the inputs, under this or another name.
pub(super) fn is_input(file: &Path) -> bool {
    let file = file.canonicalize();
    file.is_ok_and(|f| INPUTS.lock().unwrap_or_else(PoisonError::into_inner).contains(&f))
}
