//! poropunch's command line as a library: simulate, inspect, identify, diagnose, package.
//!
//! ```text
//! simulate: CSV -> Protocol -> FMU instance -> step, step, ... -> ForceCurve -> CSV, SVG
//! inspect:  Measurement -> cycles, readings, noise -> table, JSON, CSV, page
//! identify: Measurement -> noise -> inference (unknowns -> residuals -> fit -> intervals) -> report
//! diagnose: Measurement -> noise -> inference: plain fit, screening, refits with effects -> verdict, report
//! study:    table of specimens -> units -> one result each, by any engine -> gathered table, population
//! ```
//! The model is evaluated through the FMU only; the model's library is linked for names, units and protocols.

pub mod assumption;
pub mod cache;
pub mod challenge;
pub mod cli;
pub mod data;
pub mod diagnosis;
pub mod engine;
pub mod exit_code;
pub mod fit;
pub mod fmi;
pub mod identification;
pub mod inference;
pub mod inspection;
pub mod noise;
pub mod output;
pub mod package;
pub mod pool;
pub mod processor;
pub mod report;
pub mod score;
pub mod setting;
pub mod study;
pub mod text;
pub mod um_bridge;
pub mod units;
