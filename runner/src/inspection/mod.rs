//! Measurements as they are: what can be read from them without a model.
//!
//! ```text
//! Synchronised -> Trace per specimen (cycles, readings, off-contact records) -> Inspection -> table, JSON, CSV, page
//! ```

mod contact;
mod csv;
mod cycle_readings;
mod examine;
mod figures;
mod off_contact;
mod page;
mod ratios;
mod result;
mod table;
mod trace;
mod water;

pub use contact::{Contact, find_contact};
pub use csv::{cycles_csv, phases_csv};
pub use examine::{Options, examine};
pub use page::page;
pub use result::*;
pub use table::table;
pub use trace::Trace;
pub use water::{Uncertain, WaterContent, WaterError, WaterMeasurement, water_content};
