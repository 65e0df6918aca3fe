//! `poropunch.fmu`: binaries, description, documentation, icon and licences in one archive, and its lint.

mod archive;
mod binaries;
mod documentation;
mod lint;
mod platform;
mod reference;

pub use archive::{PackageError, write_archive};
pub use documentation::documentation;
pub use lint::{lint, lint_description, lint_portable};
pub use platform::{BadBinary, Binary, PLATFORMS, Platform};
