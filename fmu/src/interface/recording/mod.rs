//! Fields along a run: which frames are due, and the series of VTU files that they become.
//!
//! ```text
//! Recorder: when a frame is due -> Instance::fields -> Series: frames and their .pvd
//! ```

mod pace;
mod recorder;
mod series;
#[cfg(test)]
mod series_tests;
mod vtu;

pub use pace::{FieldSettings, Frames, Pace};
pub use recorder::{Recorder, RecorderState};
