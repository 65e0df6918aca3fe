//! The program's exit codes: 0 is success.

/// A file that cannot be written, a model that fails, anything that has no code of its own.
pub const OTHER: u8 = 1;
/// Wrong use.
pub const USAGE: u8 = 2;
/// The fit ended before it converged.
pub const NOT_CONVERGED: u8 = 3;
/// The data are refused.
pub const DATA_REFUSED: u8 = 4;
/// Stopped by the user.
pub const STOPPED: u8 = 130;
