//! One diagnosis that several tests look at, run once: it takes half a minute.

use super::program::{repository, run, text};
use std::path::PathBuf;
use std::sync::OnceLock;

/// Where its files are.
pub struct Diagnosed {
    /// `--out`.
    pub folder: PathBuf,
    /// Standard output: one JSON.
    pub json: Vec<u8>,
    /// Standard error: what people read.
    pub said: String,
}

/// Practice data with a load-cell lag, one cycle of both protocols, `--mesh coarse --quick --json`.
pub fn diagnosed() -> &'static Diagnosed {
    static ONCE: OnceLock<Diagnosed> = OnceLock::new();
    ONCE.get_or_init(|| {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("lag");
        // What an earlier run left.
        let _ = std::fs::remove_dir_all(&folder);
        let [p1, p2] = ["P1.csv", "P2.csv"].map(|f| repository(&format!("data/practice/lag/{f}")));
        let files = ["diagnose", text(&p1), text(&p2), "--out", text(&folder)];
        let output = run(&[&files[..], &["--mesh", "coarse", "--quick", "--json"]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        Diagnosed { folder, json: output.stdout, said }
    })
}
