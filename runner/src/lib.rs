//! The parts of poropunch's command line that can be used, and tested, without it.

pub mod fit;
pub mod report;
