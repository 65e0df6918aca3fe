//! Which effects could explain the gap, told from how each would look after a refit.
//!
//! ```text
//! run with the effect - run without -> d -> inv(L) -> projector -> signature s
//! s against the residual: score, expected magnitude, gain; s against each other: groups
//! ```

mod family;
mod groups;
mod projection;
#[cfg(test)]
mod tests;

pub use family::{DRAWS, Family};
pub use groups::{CONFUSABLE, groups};
pub use projection::{Linearised, Signature, normal_cdf};

use super::effect::Candidate;
use super::problem::Setup;
use crate::fit::{EvaluationFailure, Whitening};
use crate::pool::Priority;
use nalgebra::DVector;

/// An effect as screening sees it.
#[derive(Debug, Clone)]
pub struct Screened {
    /// Index of the candidate.
    pub candidate: usize,
    /// Change of the force at magnitude `probe` divided by it (mN); empty where the run failed.
    pub change_mn: DVector<f64>,
    /// What of it no refit absorbs.
    pub signature: Signature,
}

/// An effect that could not be computed.
#[derive(Debug, Clone, PartialEq)]
pub struct Failed {
    /// Index of the candidate.
    pub candidate: usize,
    /// Why.
    pub reason: String,
}

/// Signatures of all candidates at the parameters `x` of a fit.
///
/// # Errors
/// When the plain model fails, or the user asked to stop.
pub fn screen<W: Whitening>(
    setup: Setup,
    candidates: &[Candidate],
    x: &[f64],
    fit: &Linearised,
    whitening: &W,
) -> Result<(Vec<Screened>, Vec<Failed>), EvaluationFailure> {
    let plain = setup.submit(x, &[], false, Priority::Urgent);
    let runs: Vec<_> =
        candidates.iter().map(|c| setup.submit(x, &[(c, 1.0)], false, Priority::Speculative)).collect();
    let plain = Setup::forces_mn(&plain)?;
    let (mut screened, mut failed) = (Vec::new(), Vec::new());
    for (candidate, runs) in runs.iter().enumerate() {
        match Setup::forces_mn(runs) {
            Ok(forces) => {
                let change = forces.iter().zip(&plain).map(|(f, p)| f - p);
                let change_mn = DVector::from_iterator(plain.len(), change);
                let signature = fit.signature(whitening, &change_mn);
                screened.push(Screened { candidate, change_mn, signature });
            }
            Err(EvaluationFailure::Interrupted) => return Err(EvaluationFailure::Interrupted),
            Err(EvaluationFailure::Failed(reason)) => failed.push(Failed { candidate, reason }),
        }
    }
    Ok((screened, failed))
}
