//! Why an FMU could not be loaded or a call failed.

use std::path::PathBuf;
use thiserror::Error;

/// An error of the loader or of the FMU, for a person to read.
#[derive(Debug, Error)]
pub enum FmiError {
    /// A file that cannot be read.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// File.
        path: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// Not an archive.
    #[error("{path}: not an FMU: {reason}; an .fmu file is a zip archive", path = path.display())]
    NotAnArchive {
        /// File.
        path: PathBuf,
        /// Reason.
        reason: String,
    },
    /// A description that cannot be read.
    #[error("modelDescription.xml, line {line}: {reason}")]
    BadDescription {
        /// Line, from 1.
        line: u32,
        /// Reason.
        reason: String,
    },
    /// Another version of FMI.
    #[error("the FMU is for FMI {found}; this program runs FMI 2.0 and 3.0 co-simulation")]
    Version {
        /// Version found.
        found: String,
    },
    /// Model exchange only.
    #[error("the FMU offers no co-simulation; export it as a co-simulation FMU")]
    NoCoSimulation,
    /// No binary for this machine.
    #[error("the FMU has no binary for {wanted} ({file}); it has binaries for: {offered}")]
    Platform {
        /// This platform.
        wanted: &'static str,
        /// File looked for.
        file: String,
        /// Platforms of the archive.
        offered: String,
    },
    /// A binary that the system refuses to load.
    #[error("{path}: cannot be loaded: {reason}", path = path.display())]
    Load {
        /// Library.
        path: PathBuf,
        /// The loader's words.
        reason: String,
    },
    /// A function that the standard demands.
    #[error("the FMU's binary lacks the function {0}")]
    MissingSymbol(String),
    /// The binary of this project is not beside the program.
    #[error("{file} is not beside this program (looked in {looked}); build it with `cargo build --release`")]
    NoBuiltin {
        /// File name.
        file: String,
        /// Folders.
        looked: String,
    },
    /// The instantiation returned NULL.
    #[error("the FMU refused to be instantiated: {0}")]
    Refused(String),
    /// A function returned an error.
    #[error("{function} failed ({status}): {messages}")]
    Call {
        /// Function.
        function: &'static str,
        /// What the status means.
        status: String,
        /// What the FMU logged.
        messages: String,
    },
    /// A variable that the description does not name.
    #[error("the FMU has no variable `{0}`")]
    UnknownVariable(String),
    /// A capability that the FMU does not have.
    #[error("the FMU cannot {0}")]
    NotSupported(&'static str),
}

impl FmiError {
    /// Whether the model itself refused, as it would every time: not a fatal error, and not one of the loader.
    pub fn is_verdict(&self) -> bool {
        matches!(self, Self::Call { status, .. } if status == "discarded" || status == "error")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_models_own_refusal_is_a_verdict() {
        let call = |status: &str| FmiError::Call {
            function: "fmi2DoStep",
            status: status.to_owned(),
            messages: String::new(),
        };
        assert!(call("discarded").is_verdict() && call("error").is_verdict());
        assert!(!call("fatal error").is_verdict() && !call("status 7").is_verdict());
        assert!(!FmiError::NotSupported("x").is_verdict());
    }
}
