//! `poropunch.fmu`: binaries, description, documentation, icon and licences in one archive, and its lint.

mod archive;
mod binaries;
mod documentation;
mod documentation3;
mod lint;
mod lint3;
mod platform;
mod reference;

pub use archive::{PackageError, write_archive};
pub use documentation::documentation;
pub use documentation3::documentation3;
pub use lint::{Problems, lint, lint_description};
pub use platform::{BadBinary, Binary, PLATFORMS, Platform};
