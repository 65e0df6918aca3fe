//! Many units of work: planned once, done anywhere, any number of times, gathered into one table (see README.md beside).
//!
//! ```text
//! table + question -> Plan (plan.json, units.jsonl) -> work, one result per unit, in any order, by any engine
//!                  -> Results (by the hash of what was asked) -> gather -> table, population, page
//! ```

mod digest;
pub mod error;
mod frame;
pub mod gather;
mod hyperqueue;
mod page;
pub mod plan;
pub mod population;
pub mod question;
pub mod ranges;
pub mod report;
pub mod results;
pub mod status;
pub mod submit;
pub mod table;
pub mod unit;
pub mod work;

pub use error::StudyError;
pub use plan::Plan;
pub use question::Question;
pub use results::{Failure, Results, UnitResult};
pub use unit::Unit;
