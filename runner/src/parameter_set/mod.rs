//! Parameter sets in files that other FMI tools read and write: System Structure Parameter Values (SSV 1.0), of the standard
//! System Structure and Parameterization.

mod read;
mod unit;
mod write;

pub use read::{ParameterSet, ParameterSetError};
pub use write::ssv;

/// Namespace of all SSV elements.
const SSV: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";
/// Namespace of what SSV shares with the other formats of the standard.
const SSC: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";
