//! The load cell: what it reads of the force.

mod lag;
pub mod load_cell;

pub use load_cell::{LoadCell, LoadCellParameters};
