//! `simulate --fields`: where the FMU writes its fields, and how often.

use crate::output::{OutputError, check_replaceable};
use clap::Args;
use poropunch::interface::recording::Frames;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Options of the fields.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Fields")]
pub struct FieldArguments {
    /// Write the fields of the sample for ParaView: a .pvd file, or the directory of one that is called as the
    /// protocol. Frames: along the ramps every twentieth of the punch's radius, at the corners, and in the rests
    /// ever wider apart; some thirty for P2
    #[arg(long = "fields", value_name = "DIR|FILE.pvd")]
    path: Option<PathBuf>,
    /// Instead of these frames, every output time that comes at least that long after the last frame (s); 0: all
    #[arg(long = "fields-interval", value_name = "S", requires = "path")]
    interval: Option<f64>,
}

impl FieldArguments {
    /// The .pvd file of a motion called `name`.
    pub fn pvd(&self, name: &str) -> Option<PathBuf> {
        let path = self.path.as_ref()?;
        let is_pvd = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("pvd"));
        // A measurement's name may be anything; as a file's it must not lead elsewhere.
        let name: String = name.chars().map(|c| if std::path::is_separator(c) { '_' } else { c }).collect();
        Some(if is_pvd { path.clone() } else { path.join(format!("{name}.pvd")) })
    }

    /// Checks that the FMU, which replaces what is there, will replace a series of its own only.
    ///
    /// # Errors
    /// When there are files that poropunch did not write.
    pub fn check_place(&self, pvd: Option<&Path>) -> Result<(), OutputError> {
        let Some(pvd) = pvd else { return Ok(()) };
        let frames = pvd.with_extension("");
        let is_frame = |e: std::fs::DirEntry| e.path().extension().is_some_and(|x| x == "vtu");
        let has_frames = || std::fs::read_dir(&frames).is_ok_and(|all| all.flatten().any(is_frame));
        check_replaceable(pvd)?;
        if !pvd.exists() && has_frames() {
            let reason =
                "frames are there already without their series; choose another with --fields".to_owned();
            return Err(OutputError { file: frames, reason });
        }
        Ok(())
    }

    /// Texts for the FMU.
    ///
    /// # Errors
    /// When the path cannot be given to the FMU.
    pub fn texts(pvd: Option<&Path>) -> Result<Vec<(String, String)>, String> {
        let Some(pvd) = pvd else { return Ok(Vec::new()) };
        let text = pvd.to_str().ok_or_else(|| {
            format!("--fields {}: FMI takes UTF-8 paths only; choose another", pvd.display())
        })?;
        Ok(vec![("fields.path".to_owned(), text.to_owned())])
    }

    /// Numbers for the FMU.
    pub fn parameters(&self) -> BTreeMap<String, f64> {
        let every_step = f64::from(Frames::EveryStep as i32 + 1);
        let both =
            |interval| [("fields.frames".to_owned(), every_step), ("fields.interval".to_owned(), interval)];
        self.interval.into_iter().flat_map(both).collect()
    }
}
