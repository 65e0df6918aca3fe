//! Measurements: reading them, checking them, and the punch's motion in them.
//!
//! ```text
//! CSV -> header (which column is what, in which unit) -> reader -> Measurement -> history -> Protocol
//! one file per specimen -> specimen_files -> synchronise -> Measurement
//! displacement -> motion (strokes, rests) -> cycle -> phase
//! ```

pub mod cycle;
pub mod error;
pub mod estimate;
pub mod header;
pub mod history;
pub mod measurement;
pub mod motion;
pub mod noise;
pub mod phase;
pub(crate) mod random;
pub mod reader;
pub mod specimen_files;
pub mod synchronise;

pub use cycle::{Cycle, cycles};
pub use error::{DataError, Problem};
pub use estimate::{Estimate, Quartiles};
pub use history::protocol_of;
pub use measurement::Measurement;
pub use noise::NoiseModel;
pub use phase::Phase;
pub use reader::{Wanted, read, read_str};
pub use specimen_files::{SpecimenFiles, read_test};
pub use synchronise::{Synchronised, synchronise};
