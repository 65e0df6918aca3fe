//! `poropunch.fmu`: binary, description, documentation, icon and licences in one archive, and its lint.

mod archive;
mod documentation;
mod lint;
mod reference;

pub use archive::{PackageError, write_archive};
pub use documentation::documentation;
pub use lint::{lint, lint_description};
