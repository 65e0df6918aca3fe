//! The runner's parts: the FMI loader, the packager.

pub mod fmi;
pub mod package;
