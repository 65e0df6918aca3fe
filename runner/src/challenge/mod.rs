//! The check of the diagnosis on cases whose cause it does not know.
//!
//! ```text
//! make:  draw.rs (from a ground: materials, sizes) -> simulate.rs (other mesh, other time steps; cause.rs: other forms than the
//!        catalogue's, which act on the motion or the reading) -> noise.rs -> cases/ID/P1.csv, P2.csv
//!        the key goes elsewhere, its hash to cases
//!        oracle.rs: could anybody see it
//! score: answers/ID.json + key.rs -> score.rs -> table with exact binomial intervals
//! ```
//! What is drawn, and the causes that the catalogue does not have, are known to this folder only: the diagnosis sees
//! nothing but the CSV files.

pub mod binomial;
pub mod calibration;
pub mod cause;
pub mod draw;
pub mod ground;
pub mod key;
pub mod make;
mod motion;
pub mod noise;
mod oracle;
mod reading;
pub mod score;
mod simulate;
pub mod table;
