//! The check of the diagnosis on cases whose cause it does not know.
//!
//! ```text
//! make:  draw.rs -> simulate.rs (other mesh, other time steps, cause.rs: other forms than the catalogue's)
//!        -> specimens.rs (noise, scatter) -> cases/ID/P1.csv, P2.csv      the key goes elsewhere, its hash to cases
//!        oracle.rs: could anybody see it
//! score: answers/ID.json + key.rs -> score.rs -> table with exact binomial intervals
//! ```
//! What is drawn, and the causes that the catalogue does not have, are known to this folder only: the diagnosis sees
//! nothing but the CSV files.

pub mod binomial;
pub mod cause;
pub mod draw;
pub mod key;
pub mod make;
mod oracle;
pub mod score;
mod simulate;
mod specimens;
pub mod table;
