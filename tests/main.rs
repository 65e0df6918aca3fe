//! The one test program of the workspace beside the unit tests: linked once, run on all cores at once.
//!
//! It belongs to the package `runner`, so that cargo builds the command line and the FMU's library before it.

mod docs;
mod end_to_end;
mod fmi;
mod verification;
mod wheel;
