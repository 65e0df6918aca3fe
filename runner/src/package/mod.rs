//! `poropunch.fmu`: binary, description, documentation, icon and licences in one archive, and its lint.

mod archive;
mod documentation;
mod documentation3;
mod lint;
mod lint3;

pub use archive::{PackageError, write_archive, write_archive_of};
pub use documentation::documentation;
pub use documentation3::documentation3;
pub use lint::{lint, lint_description};
