//! How the program ends: its exit codes, and which error has which.

use super::job::JobError;
use crate::data::DataError;
use crate::exit_code::OTHER;
pub use crate::exit_code::{DATA_REFUSED, NOT_CONVERGED, STOPPED, USAGE};
use crate::identification::SettingsError;
use crate::inference::ParameterError;
use crate::noise::ObservationError;
use crate::parameter_set::ParameterSetError;
use crate::setting::SettingError;
use crate::study::StudyError;
use std::error::Error;
use thiserror::Error;

/// The exit codes, for `--help`.
pub const HELP: &str = "Exit codes: 0 done, 2 wrong use, 3 the fit did not converge (its results are written), 4 the data \
                        are refused, 130 stopped (what is done is kept), 1 anything else: a file that cannot be \
                        written, a model that fails.";

/// Wrong use that clap does not see.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct UsageError(pub String);

/// Data that cannot be used, for a reason that is not in one file.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct RefusedData(pub String);

/// The exit code of an error.
pub fn code_of(error: &(dyn Error + 'static)) -> u8 {
    if error.is::<DataError>() || error.is::<RefusedData>() {
        return DATA_REFUSED;
    }
    if error.is::<UsageError>()
        || error.is::<SettingError>()
        || error.is::<ParameterSetError>()
        || error.is::<ParameterError>()
    {
        return USAGE;
    }
    if let Some(error) = error.downcast_ref::<ObservationError>() {
        return match error {
            ObservationError::Noise(_) => USAGE,
            _ => DATA_REFUSED,
        };
    }
    match error.downcast_ref::<StudyError>() {
        Some(StudyError::Data(_) | StudyError::Changed { .. }) => return DATA_REFUSED,
        Some(StudyError::Io { .. } | StudyError::Output(_) | StudyError::Engine { .. }) => return OTHER,
        Some(_) => return USAGE,
        None => {}
    }
    match error.downcast_ref::<JobError>() {
        Some(JobError::Data(_) | JobError::Changed { .. }) => DATA_REFUSED,
        Some(JobError::Output(_)) => OTHER,
        Some(_) => USAGE,
        None if error.is::<SettingsError>() => USAGE,
        None => OTHER,
    }
}
