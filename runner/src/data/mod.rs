//! Measurements: reading them, checking them, and the punch's motion in them.
//!
//! ```text
//! bytes -> encoding -> layout (preamble, header, units) -> columns (names, header) -> rows (number, table) -> Measurement
//!       -> coordinate (sign, surface, tare) -> plausibility -> history -> Protocol
//! one file per specimen -> specimen_files -> synchronise -> Measurement
//! displacement -> motion (strokes, rests) -> cycle -> phase; neighbours: what its noise, and that of a force, is told from
//! ```

pub mod columns;
pub mod coordinate;
pub mod cycle;
pub mod encoding;
pub mod error;
pub mod estimate;
pub mod header;
pub mod history;
pub mod layout;
pub mod measurement;
pub mod motion;
pub mod names;
pub mod neighbours;
pub mod number;
pub mod phase;
pub mod plausibility;
pub(crate) mod random;
pub mod reader;
pub mod reading;
pub mod source;
pub mod specimen_files;
pub mod synchronise;
pub mod table;

pub use cycle::{Cycle, CycleTimes, cycles};
pub use error::{DataError, Problem, Question};
pub use estimate::{Estimate, Quartiles};
pub use history::{protocol_of, straight_pieces};
pub use measurement::Measurement;
pub use phase::Phase;
pub use reader::{Wanted, read, read_as, read_str, read_text};
pub use reading::Reading;
pub use specimen_files::{SpecimenFiles, read_tests};
pub use synchronise::{Synchronised, synchronise};
