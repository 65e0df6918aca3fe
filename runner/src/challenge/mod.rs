//! The check of the diagnosis on cases whose cause it does not know.
//!
//! ```text
//! make:  draw.rs (from ground.rs: materials, noise; near.rs, wide.rs: causes and their sizes)
//!        -> simulate.rs: the near ground by_engine.rs (other mesh and time steps; form.rs, motion.rs, reading.rs: its causes),
//!           the wide one by_maker.rs (the independent solver of poropunch-maker and its forms of all causes)
//!        -> noise.rs -> cases/ID/P1.csv, P2.csv
//!        the key goes elsewhere, its hash to cases
//!        oracle.rs: could anybody see it
//! score: answers/ID.json + key.rs -> score.rs (description.rs: what is told of a cause outside) -> table with exact binomial intervals
//! ```
//! What is drawn, and the causes that the catalogue does not have, are known to this folder only: the diagnosis sees
//! nothing but the CSV files.

pub mod binomial;
pub mod by_engine;
pub mod by_maker;
pub mod calibration;
pub mod cause;
pub mod description;
pub mod draw;
pub mod form;
pub mod ground;
pub mod key;
pub mod make;
mod motion;
mod near;
pub mod noise;
pub mod oracle;
mod reading;
pub mod score;
pub mod simulate;
pub mod table;
mod wide;
