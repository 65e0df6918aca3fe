//! The built program from outside: files in, files and messages out.
//!
//! Goal: every command does what its help says, on good input and on bad, also when it is killed.
//! Set-up: the binary that cargo built, temporary directories, poropunch's own FMU on a crude mesh, and a
//! third-party FMU that is compiled here from C (`third_party/`), where a test needs many or slow runs.
//! Reference: the shipped data's known parameters; closed-form curves; an uninterrupted run.

mod bad_input;
mod challenge;
mod diagnose;
mod fields;
mod identify;
mod inspect;
mod interrupted;
mod job_files;
mod lab_files;
mod lag;
mod led;
mod mutated;
mod nothing_silent;
mod oracle;
mod own_fmu;
mod parameter_sets;
pub(crate) mod program;
mod recovery;
mod speech;
mod study;
mod third_party;
mod um_bridge;
