//! One problem for every question: unknowns -> residuals, derivatives -> fit -> what its values are worth.
//!
//! ```text
//! Measurements -> start -> Defaults
//! Requests (and what the data say: Defaults) -> Unknowns (variables <-> the FMU's parameters)
//! Setup (engine, observations, unknowns) + effects -> ForceProblem (mN)
//! ForceProblem + Covariance + Prior -> fit / search -> Fit
//! Fit -> statistics (intervals, correlations) -> identifiability (what the data do not determine, in words)
//!     -> derived (combinations that they do)  -> evidence
//!     -> resolution (which branches they tell apart)  -> valley (where it bends)  -> profile (intervals that are no parabola)  -> robust (outliers count less)  -> posterior (a sample, on request)
//! ```
//! `identify` asks it for the plain model, `diagnose` for models with effects.

#[cfg(test)]
pub(crate) mod cases;
pub mod derived;
pub mod effect;
pub mod fit;
pub mod identifiability;
mod jacobian_load;
pub mod linearised;
mod magnitude;
pub mod parameter;
pub mod posterior;
pub mod problem;
pub mod profile;
pub mod refinement;
pub mod requests;
pub mod resolution;
pub mod robust;
pub mod rough;
pub mod setup;
pub mod start;
pub mod statistics;
mod swift_profile;
pub mod unknowns;
pub mod valley;
pub mod wording;

pub use derived::{DerivedEstimate, DerivedQuantity, Values};
pub use effect::Candidate;
pub use fit::{Depth, Fit, FitFailure, FitPlan, Found, SearchPlan};
pub use identifiability::{Finding, FindingKind, Identifiability};
pub use jacobian_load::JacobianLoad;
pub use linearised::{Linearised, Signature};
pub use parameter::{FitParameter, Transform};
pub use problem::ForceProblem;
pub use refinement::{NoiseFailure, noise_at, noise_at_start};
pub use requests::{Defaults, ParameterError, Requests};
pub use resolution::Resolution;
pub use setup::Setup;
pub use statistics::{Interval, ParameterEstimate, Statistics, white_residual};
pub use unknowns::Unknowns;
