//! Where fits of the plain model start.

use crate::engine::Engine;
use crate::inference::Requests;
use crate::inference::requests::Defaults;
use crate::inference::start::{Mentioned, Start};
use crate::noise::Observation;
use crate::setting::SettingError;

/// Viscous branches of the plain model, as in the paper: a third one is an effect.
const BRANCHES: usize = 2;

/// Where fits of the plain model start.
pub struct PlainStarts {
    /// Where the data say.
    pub told: Defaults,
    /// With a branch that they hide in the place of the fastest, and a contact that drains in the time of the test.
    pub hidden: Defaults,
    /// The same in the place of the slowest, which may follow a drift of the force; and where the data say, with that contact.
    pub further: [Defaults; 2],
}

impl PlainStarts {
    /// All of them.
    pub fn all(self) -> impl Iterator<Item = Defaults> {
        [self.told, self.hidden].into_iter().chain(self.further)
    }
}

/// Where fits of the plain model start; none for another FMU than poropunch's.
///
/// # Errors
/// A setting that cannot be used.
pub fn plain_starts(
    engine: &Engine,
    observations: &[Observation],
    requests: &Requests,
) -> Result<Option<PlainStarts>, SettingError> {
    let told = Start::told_by(engine, observations, requests, BRANCHES..=BRANCHES)?;
    Ok(told.map(|(told, mentioned)| {
        // A weak skeleton is an effect that is asked about, too.
        let mentioned = Mentioned { lambda_star: true, ..mentioned };
        let hidden = |dropped: usize| told.clone().with_hidden_branch(dropped).slowly_draining();
        let all = [told.clone(), hidden(0), hidden(BRANCHES - 1), told.clone().slowly_draining()];
        let [told, hidden, slowest_dropped, slowly_draining] = all.map(|start| start.defaults(mentioned));
        PlainStarts { told, hidden, further: [slowest_dropped, slowly_draining] }
    }))
}
