//! What can go wrong with fields.

use crate::StepError;
use thiserror::Error;

/// Fields that could not be computed or written.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FieldsError {
    /// The three-dimensional model.
    #[error(
        "fields are not available with mesh.kind = paper-3d: use the axisymmetric model, or leave fields.path empty"
    )]
    NotIn3d,
    /// A path that is not that of a series.
    #[error("fields.path = `{0}` must be the path of a .pvd file, e.g. fields/P2.pvd")]
    NotPvd(String),
    /// A file or folder that cannot be written.
    #[error(
        "cannot write {path}: {reason}; set fields.path to a place that can be written and has space, or leave it \
         empty (frames written before stay readable)"
    )]
    Unwritable {
        /// The file or folder.
        path: String,
        /// Why.
        reason: String,
    },
    /// The state at the time of a frame cannot be computed.
    #[error("the fields: {0}")]
    Step(#[from] StepError),
    /// An element whose fields cannot be evaluated.
    #[error("the fields of element {0} cannot be evaluated: it is turned inside out or compacted")]
    Inadmissible(usize),
}
