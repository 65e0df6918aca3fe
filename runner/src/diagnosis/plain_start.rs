//! Where fits of the plain model start.

use crate::engine::Engine;
use crate::inference::start::{Mentioned, Start};
use crate::inference::{ParameterError, Requests, Unknowns};
use crate::noise::Observation;

/// Viscous branches of the plain model, as in the paper: a third one is an effect.
const BRANCHES: usize = 2;

/// Where fits of the plain model start.
pub struct PlainStarts {
    /// What is fitted; it starts where the data say.
    pub unknowns: Unknowns,
    /// With a branch that they hide in the place of the fastest, and a contact that drains in the time of the test: nothing is missing there
    /// of what an effect hides. None for another FMU than poropunch's.
    pub hidden: Option<Vec<f64>>,
    /// The same in the place of the slowest, which may follow a drift of the force; and where the data say, with that contact.
    pub further: Vec<Vec<f64>>,
}

impl PlainStarts {
    /// For some tests and requests.
    ///
    /// # Errors
    /// A request that cannot be met.
    pub fn of(
        engine: &Engine,
        observations: &[Observation],
        requests: &Requests,
    ) -> Result<Self, ParameterError> {
        let of = |requests: &Requests| Unknowns::new(engine.wiring(), engine.is_own(), requests);
        let Some((told, mentioned)) = Start::told_by(engine, observations, requests, BRANCHES..=BRANCHES)?
        else {
            return Ok(Self { unknowns: of(requests)?, hidden: None, further: vec![] });
        };
        // A weak skeleton is an effect that is asked about, too.
        let mentioned = Mentioned { lambda_star: true, ..mentioned };
        let at = |start: Start| {
            let defaults = start.defaults(mentioned);
            of(&Requests { defaults, ..requests.clone() })
        };
        let unknowns = at(told.clone())?;
        // What a start tells of the values' bounds is another one's.
        let beginning = |start: Start| Ok::<_, ParameterError>(unknowns.within_bounds(at(start)?.start()));
        let hidden = |dropped: usize| told.clone().with_hidden_branch(dropped).slowly_draining();
        Ok(Self {
            hidden: Some(beginning(hidden(0))?),
            further: vec![beginning(hidden(BRANCHES - 1))?, beginning(told.clone().slowly_draining())?],
            unknowns,
        })
    }

    /// All of them, in the order in which they are tried.
    pub fn all(&self) -> impl Iterator<Item = &[f64]> {
        let others = self.hidden.iter().chain(&self.further);
        std::iter::once(self.unknowns.start()).chain(others.map(Vec::as_slice))
    }
}
