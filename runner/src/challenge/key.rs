//! The sealed answers.

use super::draw::Drawn;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Name of the file with the key's hash, in the folder of the cases.
pub const SEAL: &str = "key.blake3";

/// What is behind the cases.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Key {
    /// `poropunch.challenge/1`.
    pub schema: String,
    /// Seed of the draws.
    pub seed: u64,
    /// Cycles of each test.
    pub cycles: i32,
    /// All cases.
    pub cases: Vec<Solution>,
}

/// What is behind one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Solution {
    /// What was drawn.
    pub drawn: Drawn,
    /// Names of its causes in the catalogue; none for those outside.
    pub effects: Vec<String>,
    /// Score that each cause has for somebody who knows the forms of all and the true parameters: what a refit, of a pair with the
    /// other cause in any size, leaves of it, in units of the noise.
    pub visibility: Vec<f64>,
    /// Reading without noise, test by test (mN).
    pub truth_mn: Vec<Vec<f64>>,
}

/// A cause of a smaller score is taken as not to be seen.
pub const VISIBLE: f64 = 6.0;

impl Solution {
    /// Whether each cause, of at least one, can be seen.
    pub fn is_visible(&self) -> bool {
        !self.visibility.is_empty() && self.visibility.iter().all(|z| *z >= VISIBLE)
    }
}

/// A key that cannot be used.
#[derive(Debug, Error)]
pub enum KeyError {
    /// A file cannot be read.
    #[error("cannot read {path}: {source}")]
    Io {
        /// File.
        path: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// Not a key.
    #[error("{path} is no key of a challenge: {source}; it is the file that `challenge make --key` wrote")]
    Json {
        /// File.
        path: PathBuf,
        /// Reason.
        source: serde_json::Error,
    },
    /// The key is another one than the one that was sealed.
    #[error(
        "{path} is not the key that was sealed with these cases: its hash is {found}, {seal} says {sealed}"
    )]
    Seal {
        /// The key.
        path: PathBuf,
        /// File of the hash.
        seal: PathBuf,
        /// Hash of the key.
        found: String,
        /// Hash in the seal.
        sealed: String,
    },
}

/// Hash of a key's bytes.
pub fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// Opens a key and compares it with the seal in the folder of the cases.
///
/// # Errors
/// When a file cannot be read, is no key, or is not the sealed one.
pub fn open(path: &Path, cases: &Path) -> Result<Key, KeyError> {
    let read =
        |path: &Path| std::fs::read(path).map_err(|source| KeyError::Io { path: path.to_owned(), source });
    let bytes = read(path)?;
    let seal = cases.join(SEAL);
    let sealed = read(&seal)?;
    let sealed = String::from_utf8_lossy(&sealed);
    let sealed = sealed.lines().rfind(|line| !line.starts_with('#')).unwrap_or("").trim().to_owned();
    let found = hash(&bytes);
    if found != sealed {
        return Err(KeyError::Seal { path: path.to_owned(), seal, found, sealed });
    }
    serde_json::from_slice(&bytes).map_err(|source| KeyError::Json { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_key_than_the_sealed_one_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let key = Key { schema: "poropunch.challenge/1".into(), seed: 3, cycles: 1, cases: vec![] };
        let bytes = serde_json::to_vec(&key).unwrap();
        let path = folder.path().join("key.json");
        std::fs::write(&path, &bytes).unwrap();
        std::fs::write(folder.path().join(SEAL), format!("{}\n", hash(&bytes))).unwrap();
        assert_eq!(open(&path, folder.path()).unwrap(), key);
        let other = Key { seed: 4, ..key };
        std::fs::write(&path, serde_json::to_vec(&other).unwrap()).unwrap();
        let error = open(&path, folder.path()).unwrap_err();
        assert!(matches!(error, KeyError::Seal { .. }) && error.to_string().contains("key.json"), "{error}");
    }
}
