//! The sealed answers: encrypted, so that nobody reads them by chance, and with a hash beside the cases, so that nobody changes them.

use super::draw::Drawn;
use super::ground::Ground;
use crate::output::read_input;
use chacha20poly1305::aead::{Aead, Generate as _, KeyInit};
use chacha20poly1305::{Key as CipherKey, XChaCha20Poly1305, XNonce};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Folder of the cases in that of a challenge.
pub const CASES: &str = "cases";
/// Name of the file with the key's hash, in the folder of the cases.
pub const SEAL: &str = "key.blake3";

/// What is behind the cases.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Key {
    /// [`CONTENT`].
    pub schema: String,
    /// Seed of the draws.
    pub seed: u64,
    /// Where they were drawn from.
    pub ground: Ground,
    /// Cycles of each test.
    pub cycles: i32,
    /// All cases.
    pub cases: Vec<Solution>,
    /// Draws that others of their kind replace, because they could not be computed, or depend on the time steps, however short: a bias,
    /// where they are many.
    pub replaced: Vec<Replaced>,
}

/// What a key holds.
pub const CONTENT: &str = "poropunch.challenge/2";

/// A draw that another one replaces.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Replaced {
    /// What was drawn.
    pub drawn: Drawn,
    /// Why.
    pub reason: String,
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
    /// The same as the largest mean over half a decade of time, as part of the test's largest force (%).
    pub gap_percent: Vec<f64>,
    /// Reading without noise, test by test (mN).
    pub truth_mn: Vec<Vec<f64>>,
}

/// A cause of a smaller score is taken as not to be seen.
pub const VISIBLE: f64 = 6.0;

impl Solution {
    /// Of a draw, what can be seen of its causes, and the reading without noise, test by test (N).
    pub fn new(drawn: Drawn, visibility: Vec<f64>, gap_percent: Vec<f64>, readings_n: &[Vec<f64>]) -> Self {
        let effects = drawn.causes.iter().filter_map(|c| c.effect().map(str::to_owned)).collect();
        let truth_mn = readings_n.iter().map(|r| r.iter().map(|f| f * 1e3).collect()).collect();
        Self { drawn, effects, visibility, gap_percent, truth_mn }
    }

    /// Reading without noise, test by test (N).
    pub fn truth_n(&self) -> Vec<Vec<f64>> {
        self.truth_mn.iter().map(|test| test.iter().map(|f| f * 1e-3).collect()).collect()
    }

    /// Whether each cause, of at least one, can be seen.
    pub fn is_visible(&self) -> bool {
        !self.visibility.is_empty() && self.visibility.iter().all(|z| *z >= VISIBLE)
    }

    /// Whether each cause can be seen and leaves a gap of at least this part of the largest force (%).
    pub fn matters(&self, percent: f64) -> bool {
        self.is_visible() && self.gap_percent.iter().all(|gap| *gap >= percent)
    }
}

/// What opens a key: 32 bytes, written as hexadecimal digits.
#[derive(Clone)]
pub struct Secret(CipherKey);

impl Secret {
    /// One that nobody knows.
    #[must_use]
    pub fn random() -> Self {
        Self(CipherKey::generate())
    }

    /// For people to keep.
    pub fn text(&self) -> String {
        hex(&self.0)
    }

    /// As it was told, or `None`: its digits are the last line that is no comment.
    pub fn of(text: &str) -> Option<Self> {
        let digits = text.lines().rfind(|line| !line.starts_with('#'))?;
        let bytes: [u8; 32] = bytes(digits.trim())?.try_into().ok()?;
        Some(Self(bytes.into()))
    }
}

/// The key's file.
#[derive(Debug, Serialize, Deserialize)]
struct Sealed {
    /// `poropunch.sealed/1`: JSON of the key under XChaCha20-Poly1305, hexadecimal.
    schema: String,
    nonce: String,
    sealed: String,
}

const SCHEMA: &str = "poropunch.sealed/1";

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
    #[error("{path} is no key of a challenge: {reason}; it is the file that `challenge make --key` wrote")]
    NoKey {
        /// File.
        path: PathBuf,
        /// Reason.
        reason: String,
    },
    /// Another secret.
    #[error(
        "{path} does not open with this secret: give --secret the one that `challenge make` told when it wrote the key"
    )]
    Secret {
        /// The key.
        path: PathBuf,
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

/// The bytes of a key's file; `None` where its parts are no JSON.
pub fn sealed(key: &Key, secret: &Secret) -> Option<Vec<u8>> {
    let nonce = XNonce::generate();
    let text = serde_json::to_vec(key).ok()?;
    let hidden = XChaCha20Poly1305::new(&secret.0).encrypt(&nonce, text.as_slice()).ok()?;
    serde_json::to_vec(&Sealed { schema: SCHEMA.to_owned(), nonce: hex(&nonce), sealed: hex(&hidden) }).ok()
}

/// Opens a key and compares it with the seal in the folder of the cases.
///
/// # Errors
/// When a file cannot be read, is no key, is not the sealed one, or the secret is another one's.
pub fn open(path: &Path, cases: &Path, secret: &Secret) -> Result<Key, KeyError> {
    let read =
        |path: &Path| read_input(path).map_err(|source| KeyError::Io { path: path.to_owned(), source });
    let no_key = |reason: String| KeyError::NoKey { path: path.to_owned(), reason };
    let bytes_of_file = read(path)?;
    let seal = cases.join(SEAL);
    let told = read(&seal)?;
    let told = String::from_utf8_lossy(&told);
    let told = told.lines().rfind(|line| !line.starts_with('#')).unwrap_or("").trim().to_owned();
    let found = hash(&bytes_of_file);
    if found != told {
        return Err(KeyError::Seal { path: path.to_owned(), seal, found, sealed: told });
    }
    let file: Sealed = serde_json::from_slice(&bytes_of_file).map_err(|e| no_key(e.to_string()))?;
    let nonce: Option<[u8; 24]> = bytes(&file.nonce).and_then(|n| n.try_into().ok());
    let parts = nonce.map(XNonce::from).zip(bytes(&file.sealed));
    let (nonce, hidden) = parts.ok_or_else(|| no_key("it is not hexadecimal".to_owned()))?;
    let shown = XChaCha20Poly1305::new(&secret.0).decrypt(&nonce, hidden.as_slice());
    let shown = shown.map_err(|_| KeyError::Secret { path: path.to_owned() })?;
    serde_json::from_slice(&shown).map_err(|e| no_key(e.to_string()))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

fn bytes(hex: &str) -> Option<Vec<u8>> {
    let digits = hex.as_bytes().chunks(2);
    digits.map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_its_secret_opens_the_sealed_key() {
        let folder = tempfile::tempdir().unwrap();
        let (secret, ground) = (Secret::random(), Ground::Wide);
        let (schema, cases, replaced) = (CONTENT.to_owned(), vec![], vec![]);
        let key = Key { schema, seed: 3, ground, cycles: 1, cases, replaced };
        let path = folder.path().join("key.json");
        let write = |key: &Key| {
            let bytes = sealed(key, &secret).unwrap();
            std::fs::write(&path, &bytes).unwrap();
            bytes
        };
        let bytes = write(&key);
        assert!(!String::from_utf8(bytes.clone()).unwrap().contains("seed"));
        std::fs::write(folder.path().join(SEAL), format!("{}\n", hash(&bytes))).unwrap();
        let told = Secret::of(&format!("# kept apart\n{}\n", secret.text())).unwrap();
        assert_eq!(open(&path, folder.path(), &told).unwrap(), key);
        let error = open(&path, folder.path(), &Secret::random()).unwrap_err();
        assert!(matches!(error, KeyError::Secret { .. }), "{error}");
        write(&Key { seed: 4, ..key });
        let error = open(&path, folder.path(), &told).unwrap_err();
        assert!(matches!(error, KeyError::Seal { .. }) && error.to_string().contains("key.json"), "{error}");
        assert!(Secret::of("12").is_none() && Secret::of("zz").is_none());
    }
}
