//! Where fits of the plain model start.

use crate::engine::Engine;
use crate::inference::Requests;
use crate::inference::requests::Defaults;
use crate::inference::start::{Mentioned, Start};
use crate::noise::Observation;
use crate::setting::SettingError;

/// Viscous branches of the plain model, as in the paper: a third one is an effect.
const BRANCHES: usize = 2;

/// Where the data say that the plain model's fit starts, and the same with a branch that they hide; none for another FMU than poropunch's.
///
/// # Errors
/// A setting that cannot be used.
pub fn plain_starts(
    engine: &Engine,
    observations: &[Observation],
    requests: &Requests,
) -> Result<Option<[Defaults; 2]>, SettingError> {
    let told = Start::told_by(engine, observations, requests, BRANCHES..=BRANCHES)?;
    Ok(told.map(|(start, mentioned)| {
        // A weak skeleton is an effect that is asked about, too.
        let mentioned = Mentioned { lambda_star: true, ..mentioned };
        let hidden = start.clone().with_hidden_branch();
        [start, hidden].map(|start| start.defaults(mentioned))
    }))
}
