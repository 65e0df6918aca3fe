//! The files of a series: `P2.pvd`, and the frames `P2/P2_0000.vtu`, `P2/P2_0001.vtu`, ... beside it.

use super::vtu;
use crate::fields::{Fields, FieldsError};
use crate::interface::hash::hash_128;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A frame that was written.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Its time (s).
    pub time: f64,
    /// Hash of its file.
    content: [u8; 16],
}

/// A series under way.
#[derive(Debug)]
pub struct Series {
    pvd: PathBuf,
    folder: PathBuf,
    stem: String,
    frames: Vec<Frame>,
}

impl Series {
    /// A new series; frames of an earlier one at the same place are removed.
    ///
    /// # Errors
    /// When the path is not that of a .pvd file or the place cannot be written.
    pub fn begin(path: &str) -> Result<Self, FieldsError> {
        let mut series = Self::at(path)?;
        fs::create_dir_all(&series.folder).map_err(|e| unwritable(&series.folder, &e))?;
        series.replace(Vec::new())?;
        Ok(series)
    }

    /// The series of a saved state: the frames that are still as they were written; later ones are removed.
    ///
    /// # Errors
    /// As [`Series::begin`].
    pub fn resume(path: &str, saved: &[Frame]) -> Result<Self, FieldsError> {
        let mut series = Self::at(path)?;
        fs::create_dir_all(&series.folder).map_err(|e| unwritable(&series.folder, &e))?;
        let is_there = |(index, frame): (usize, &Frame)| {
            fs::read(series.file(index)).is_ok_and(|bytes| hash_128(&bytes) == frame.content)
        };
        let kept = saved.iter().enumerate().take_while(|&pair| is_there(pair)).count();
        series.replace(saved[..kept].to_vec())?;
        Ok(series)
    }

    /// Back to the frames of a saved state, as far as the present series begins with them.
    ///
    /// # Errors
    /// When the files cannot be changed.
    pub fn return_to(&mut self, saved: &[Frame]) -> Result<(), FieldsError> {
        let kept = self.frames.iter().zip(saved).take_while(|(mine, theirs)| mine == theirs).count();
        if kept < self.frames.len() {
            self.replace(saved[..kept].to_vec())?;
        }
        Ok(())
    }

    /// Adds a frame at `time` (s).
    ///
    /// # Errors
    /// When it cannot be written; the series is then as it was.
    pub fn add(&mut self, time: f64, fields: &Fields) -> Result<(), FieldsError> {
        let text = vtu::frame(fields, time);
        write(&self.file(self.frames.len()), &text)?;
        self.frames.push(Frame { time, content: hash_128(text.as_bytes()) });
        self.write_collection().inspect_err(|_| self.frames.truncate(self.frames.len() - 1))
    }

    /// The frames so far.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Whether it lies at `path`.
    pub fn is_at(&self, path: &str) -> bool {
        self.pvd == Path::new(path)
    }

    fn at(path: &str) -> Result<Self, FieldsError> {
        let pvd = PathBuf::from(path);
        let is_pvd = pvd.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("pvd"));
        let stem = pvd.file_stem().and_then(|stem| stem.to_str()).filter(|_| is_pvd);
        let stem = stem.ok_or_else(|| FieldsError::NotPvd(path.to_owned()))?.to_owned();
        Ok(Self { folder: pvd.with_extension(""), pvd, stem, frames: Vec::new() })
    }

    /// Name of a frame's file.
    fn name(&self, index: usize) -> String {
        format!("{}_{index:04}.vtu", self.stem)
    }

    fn file(&self, index: usize) -> PathBuf {
        self.folder.join(self.name(index))
    }

    /// Takes other frames and removes the files beyond them: first from the list, so that it never names a file
    /// that is not there.
    fn replace(&mut self, frames: Vec<Frame>) -> Result<(), FieldsError> {
        self.frames = frames;
        self.write_collection()?;
        for index in self.frames.len().. {
            let file = self.file(index);
            match fs::remove_file(&file) {
                Ok(()) => {}
                Err(error) if error.kind() == ErrorKind::NotFound => break,
                Err(error) => return Err(unwritable(&file, &error)),
            }
        }
        Ok(())
    }

    fn write_collection(&self) -> Result<(), FieldsError> {
        let names: Vec<_> =
            (0..self.frames.len()).map(|index| format!("{}/{}", self.stem, self.name(index))).collect();
        let times = self.frames.iter().map(|frame| frame.time);
        write(&self.pvd, &vtu::collection(times.zip(names.iter().map(String::as_str))))
    }
}

/// Writes a file whole or not at all: ParaView may read along.
fn write(file: &Path, text: &str) -> Result<(), FieldsError> {
    let mut name = file.as_os_str().to_owned();
    name.push(".part");
    let part = PathBuf::from(name);
    let written = fs::write(&part, text).and_then(|()| fs::rename(&part, file));
    written.map_err(|error| {
        // What is left of it, if anything, is of no use.
        let _ = fs::remove_file(&part);
        unwritable(file, &error)
    })
}

fn unwritable(path: &Path, error: &std::io::Error) -> FieldsError {
    FieldsError::Unwritable { path: path.display().to_string(), reason: error.to_string() }
}
