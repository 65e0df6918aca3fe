//! The FMU from outside: the acceptance list A-F of the project's FMI page, as far as it needs the
//! packaged archive or the loader. B, the state machine, is tested in `cdylib/tests`.

mod archive;
mod fmi3;
mod importers;
mod loader;
mod parallel;
mod platforms;
mod state;
mod steps;
mod support;
