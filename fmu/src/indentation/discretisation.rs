//! What the punch's motion needs of a discretised sample.

use super::contact::Touch;
use super::step::{State, Stepper};
use crate::outputs::{ForceSensitivity, Outputs, Statistics};
use crate::solver::newton::NewtonFailure;

/// How long a step may search for its solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Patience {
    /// A shorter step may find it sooner.
    Little,
    /// Shorter steps have not found it either.
    Much,
}

/// What the path integrates: a discretised sample that makes one step at a time.
pub trait Discretisation {
    /// The sample at one time.
    type State: Reached;

    /// The undeformed sample.
    fn undeformed(&self, time: f64) -> Self::State;

    /// Whether a state has this discretisation's numbers of unknowns and history tensors.
    fn fits(&self, state: &Self::State) -> bool;

    /// A force that matters (N).
    fn force_scale(&self) -> f64;

    /// Whether the punch can leave the sample; where it cannot, retraction is an error.
    fn separates(&self) -> bool;

    /// The state `dt` later, the punch moving from `start` (m) at `velocity` (m/s).
    ///
    /// # Errors
    /// Why a stage has no solution.
    fn step(
        &mut self,
        old: &Self::State,
        start: f64,
        velocity: f64,
        dt: f64,
        patience: Patience,
        statistics: &mut Statistics,
    ) -> Result<Self::State, NewtonFailure>;
}

/// What the path needs to know of a state.
pub trait Reached {
    /// Time (s).
    fn time(&self) -> f64;
    /// Results.
    fn outputs(&self) -> Outputs;
    /// Derivatives of the force, where they are computed.
    fn sensitivities(&self) -> Vec<ForceSensitivity>;
    /// Where the surface lies with respect to the punch.
    fn touch(&self) -> Touch;
    /// Whether the same parts of the surface are in contact.
    fn touches_as(&self, other: &Self) -> bool;
}

impl Discretisation for Stepper {
    type State = State;

    fn undeformed(&self, time: f64) -> State {
        self.undeformed(time)
    }

    fn fits(&self, state: &State) -> bool {
        self.fits(state)
    }

    fn force_scale(&self) -> f64 {
        self.force_scale()
    }

    fn separates(&self) -> bool {
        true
    }

    fn step(
        &mut self,
        old: &State,
        start: f64,
        velocity: f64,
        dt: f64,
        patience: Patience,
        statistics: &mut Statistics,
    ) -> Result<State, NewtonFailure> {
        self.step_with(old, (start, velocity), dt, patience, statistics)
    }
}

impl Reached for State {
    fn time(&self) -> f64 {
        self.time
    }

    fn outputs(&self) -> Outputs {
        self.outputs
    }

    fn sensitivities(&self) -> Vec<ForceSensitivity> {
        self.sensitivity.as_ref().map(|s| s.forces.clone()).unwrap_or_default()
    }

    fn touch(&self) -> Touch {
        self.touch
    }

    fn touches_as(&self, other: &Self) -> bool {
        self.contact.touches_as(&other.contact)
    }
}
