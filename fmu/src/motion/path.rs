//! The punch's motion: pieces of constant velocity, integrated ahead of the communication points.
//!
//! Between two changes of its velocity the punch's path is known, so the steps need not end where a
//! master communicates: an instance integrates ahead with its own step sizes and interpolates. Only
//! when the velocity changes is the state computed at that very time. The force therefore does not
//! depend on how a master slices time.
//!
//! Off contact the sample is on its own and the punch's velocity does not matter; the steps follow the level of
//! the surface, and the last one before the punch lands is as long as it takes to touch.

use super::interpolation::Node;
use super::step_control::{self, STANDING, first_step};
use super::stops::{Reached, Stops};
use crate::error::StepError;
use crate::outputs::{Outputs, Statistics};
use crate::sensor::{LoadCell, LoadCellParameters};
use crate::solver::parameters::SolverParameters;
use crate::specimen::{Discretisation, Motion, Patience, State};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// No step moves the punch by more than this fraction of its radius.
const MAX_TRAVEL: f64 = 0.1;
/// Steps below this fraction of the first one are hopeless.
const MIN_FRACTION: f64 = 1e-6;
/// Below this fraction of the first step it is not the step's length that keeps the solution from being found.
const SHORT: f64 = 1e-2;
/// Attempts that may fail within [`STRETCH`]: a path that goes on in steps next to nothing would go on for hours.
const MAX_FAILURES: u32 = 100;
/// Over the time since the last change of velocity, or [`FIRST_STEPS`] where they are longer.
const STRETCH: f64 = 0.01;
/// In lengths of the first step; one of them is some thousandth of a ramp.
const FIRST_STEPS: f64 = 10.0;
/// Where the punch is while the sample is on its own (m): so far above it that nothing touches.
const AWAY: f64 = -1e3;
/// The punch has landed when its gap is below this fraction of the initial increment.
const LANDED: f64 = 0.05;
/// Times this close to each other, relative to them, are one.
const ROUNDING: f64 = 1e-14;
/// Nodes kept for interpolation.
pub(super) const NODES: usize = 4;

/// A piece of the path with constant velocity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    start_time: f64,
    start: f64,
    velocity: f64,
}

impl Piece {
    /// Punch displacement at `time` (m).
    fn position(&self, time: f64) -> f64 {
        self.start + self.velocity * (time - self.start_time)
    }
}

/// The integrated path: the last two states and the nodes to interpolate between.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Path {
    piece: Piece,
    /// Start of the step that covers the present time.
    base: Arc<State>,
    /// Its end, when the present lies inside it.
    ahead: Option<Arc<State>>,
    /// Results at the last few step ends of this piece, oldest first.
    pub(super) nodes: Vec<Node>,
    /// Since when the response is smooth: the last change of velocity or of contact (s).
    pub(super) origin: f64,
    next_step: f64,
    pub(super) first_step: f64,
    largest_force: f64,
    /// The load cell at the start of that step.
    pub(super) cell: LoadCell,
    deepest: f64,
    /// Attempts that failed since a time (s).
    failures: (f64, u32),
}

impl Path {
    /// Contact begins at `time` (s) with displacement zero.
    pub fn touch(stepper: &dyn Discretisation, time: f64) -> Self {
        let base = Arc::new(stepper.undeformed(time));
        Self {
            piece: Piece { start_time: time, start: 0.0, velocity: 0.0 },
            nodes: vec![Node::of(&base)],
            base,
            ahead: None,
            origin: time,
            next_step: f64::INFINITY,
            first_step: f64::INFINITY,
            largest_force: 0.0,
            cell: LoadCell::at_rest(&LoadCellParameters::default(), time),
            deepest: 0.0,
            failures: (time, 0),
        }
    }

    /// The same path with a load cell.
    pub fn with_load_cell(mut self, parameters: &LoadCellParameters) -> Self {
        self.cell = LoadCell::at_rest(parameters, self.base.time);
        self
    }

    /// Whether the state belongs to the stepper's mesh and material.
    pub fn fits(&self, stepper: &dyn Discretisation) -> bool {
        let fits = |state: &State| state.lengths() == stepper.constants().lengths;
        fits(&self.base) && self.ahead.as_deref().is_none_or(fits)
    }

    /// Whether steps from here go on in time: what a path from elsewhere need not.
    pub fn is_sound(&self) -> bool {
        let Piece { start_time, start, velocity } = self.piece;
        let times: Vec<f64> = self.nodes.iter().map(|node| node.time).collect();
        let numbers = [start_time, start, velocity, self.origin, self.largest_force, self.deepest];
        numbers.iter().chain([&self.base.time]).chain(&times).all(|number| number.is_finite())
            && self.ahead.as_ref().is_none_or(|ahead| ahead.time > self.base.time)
            && self.next_step > 0.0
            && self.first_step > 0.0
            && (1..=NODES).contains(&times.len())
            && times.is_sorted_by(|a, b| a < b)
    }

    /// Moves the punch from `from` at `now` to `to` at `end`; returns the results at `end`.
    ///
    /// # Errors
    /// [`StepError::NoConvergence`]; the path is then to be discarded.
    #[allow(clippy::too_many_arguments)]
    pub fn advance(
        &mut self,
        stepper: &mut dyn Discretisation,
        solver: &SolverParameters,
        punch_radius: f64,
        start: (f64, f64),
        end: (f64, f64),
        statistics: &mut Statistics,
    ) -> Result<Outputs, StepError> {
        let whole = Stops::default();
        let advanced = self.advance_until(stepper, solver, punch_radius, start, end, whole, statistics);
        advanced.map(|(outputs, ..)| outputs)
    }

    /// Moves the punch from `from` at `now` to `to` at `end`, or until something that `stops` names; returns the
    /// results, the time and what it was.
    ///
    /// # Errors
    /// [`StepError::NoConvergence`]; the path is then to be discarded.
    #[allow(clippy::too_many_arguments)]
    pub fn advance_until(
        &mut self,
        stepper: &mut dyn Discretisation,
        solver: &SolverParameters,
        punch_radius: f64,
        (now, from): (f64, f64),
        (mut end, to): (f64, f64),
        stops: Stops,
        statistics: &mut Statistics,
    ) -> Result<(Outputs, f64, Reached), StepError> {
        let velocity = (to - from) / (end - now);
        if (self.piece.position(end) - to).abs() > 1e-9 * punch_radius {
            let piece = Piece { start_time: now, start: from, velocity };
            if !self.stays_free(&piece) {
                self.settle(stepper, now, statistics)?;
            }
            if self.base.touch.in_contact {
                let change = (velocity - self.piece.velocity).abs();
                let is_first = self.next_step.is_infinite();
                self.first_step = first_step(solver, change, end - now, is_first);
                self.next_step = self.next_step.min(self.first_step);
                self.start_anew(Node { time: now, ..Node::of(&self.base) });
            }
            self.piece = piece;
        }
        let longest = (MAX_TRAVEL * punch_radius / velocity.abs().max(STANDING)).min(solver.max_step);
        let mut displacement = to;
        while self.ahead.as_ref().unwrap_or(&self.base).time < end * (1.0 - ROUNDING) {
            if let Some(ahead) = self.ahead.take() {
                if ahead.time > now * (1.0 + ROUNDING)
                    && (stops.steps || stops.events && self.changes(&ahead))
                {
                    (end, displacement) = (ahead.time, self.piece.position(ahead.time));
                    self.ahead = Some(ahead);
                    break;
                }
                self.follow(ahead.time);
                self.base = ahead;
            }
            if self.base.touch.in_contact || self.lands(solver, end) {
                self.next_step = self.next_step.min(longest);
                self.step_ahead(stepper, solver, statistics)?;
            } else {
                self.fly(stepper, solver, statistics)?;
            }
        }
        let mut outputs = self.interpolate(end);
        outputs.displacement = displacement;
        outputs.force = self.reading(end, &outputs);
        Ok((outputs, end, self.reached(end)))
    }

    /// Whether contact is made or lost between `base` and the state after it.
    fn changes(&self, ahead: &State) -> bool {
        ahead.touch.in_contact != self.base.touch.in_contact
    }

    /// What is at a time that the path has reached.
    fn reached(&self, time: f64) -> Reached {
        match &self.ahead {
            Some(ahead) if (ahead.time - time).abs() > ROUNDING * time => Reached::End,
            Some(ahead) if self.changes(ahead) => Reached::Contact,
            Some(_) => Reached::Step,
            None => Reached::End,
        }
    }

    /// Forgets the past: the response is smooth from `node` on.
    fn start_anew(&mut self, node: Node) {
        self.origin = node.time;
        self.nodes = vec![node];
    }

    /// The state at a time the path has reached, computed beside the path: the path stays as it is.
    ///
    /// # Errors
    /// [`StepError::NoConvergence`].
    pub fn state_at(&self, stepper: &mut dyn Discretisation, time: f64) -> Result<Arc<State>, StepError> {
        let mut beside = self.clone();
        beside.settle(stepper, time, &mut Statistics::default())?;
        Ok(beside.base)
    }

    /// Distance from the punch to where it would touch the surface (m).
    fn gap(&self, state: &State) -> f64 {
        state.touch.clearance - self.piece.position(state.time)
    }

    /// Whether the punch touches nothing on a new piece of its path as far as the states go.
    fn stays_free(&self, piece: &Piece) -> bool {
        let states = || std::iter::once(&self.base).chain(&self.ahead);
        let lowest =
            states().map(|s| piece.position(s.time.max(piece.start_time))).fold(piece.start, f64::max);
        states().all(|s| !s.touch.in_contact && s.touch.clearance > lowest)
    }

    /// Whether the punch, which was off contact, is at the surface; the steps then start small.
    fn lands(&mut self, solver: &SolverParameters, end: f64) -> bool {
        if self.gap(&self.base) > LANDED * solver.initial_increment {
            return false;
        }
        let (node, velocity) = (Node::of(&self.base), self.piece.velocity.max(0.0));
        self.first_step = first_step(solver, velocity, end - node.time, true).min(self.next_step);
        self.next_step = self.first_step;
        self.start_anew(node);
        true
    }

    /// Makes `base` the state at `now`.
    fn settle(
        &mut self,
        stepper: &mut dyn Discretisation,
        now: f64,
        statistics: &mut Statistics,
    ) -> Result<(), StepError> {
        self.follow(now);
        if let Some(ahead) = self.ahead.take() {
            if (ahead.time - now).abs() <= 1e-12 * now.abs() {
                self.base = ahead;
            } else {
                // The last node lies ahead of the change of velocity and never happens.
                self.nodes.pop();
            }
        }
        let unsettled = self.base.time < now * (1.0 - ROUNDING);
        while self.base.time < now * (1.0 - ROUNDING) {
            let mut dt = now - self.base.time;
            let (start, velocity) = self.motion();
            let state = self.attempt(stepper, (start, velocity), &mut dt, statistics)?;
            self.base = Arc::new(state);
        }
        if unsettled {
            let node = Node::of(&self.base);
            if self.nodes.is_empty() { self.start_anew(node) } else { self.keep(node) }
        }
        Ok(())
    }

    /// Position and velocity of the punch from `base` on; off contact it is far away.
    fn motion(&self) -> (f64, f64) {
        if self.base.touch.in_contact {
            (self.piece.position(self.base.time), self.piece.velocity)
        } else {
            (AWAY, 0.0)
        }
    }

    /// One step beyond `base` in contact, with error control.
    fn step_ahead(
        &mut self,
        stepper: &mut dyn Discretisation,
        solver: &SolverParameters,
        statistics: &mut Statistics,
    ) -> Result<(), StepError> {
        let mut dt = self.next_step;
        let motion = (self.piece.position(self.base.time), self.piece.velocity);
        loop {
            let state = self.attempt(stepper, motion, &mut dt, statistics)?;
            let force = state.outputs.force;
            let scale = force.abs().max(0.1 * self.largest_force).max(1e-3 * stepper.constants().force_scale);
            let misfit = self.misfit(&state, force, |node| node.outputs.force);
            let error = misfit.map(|m| step_control::error(m, scale, solver.tolerance));
            // A change of contact is a kink that no step resolves: it need not become shorter than the first.
            let changed = !state.touches_as(&self.base);
            let shortest = if changed { self.first_step } else { MIN_FRACTION * self.first_step };
            if let Some(error) = error.filter(|&e| step_control::is_excessive(e) && dt > shortest) {
                statistics.cuts += 1;
                dt *= step_control::shrinkage(error);
                continue;
            }
            self.largest_force = self.largest_force.max(force.abs());
            self.deepest = self.deepest.max(state.outputs.displacement);
            self.accept(state, dt, error, statistics);
            return Ok(());
        }
    }

    /// One step beyond `base` off contact, which ends where the punch lands at the latest.
    fn fly(
        &mut self,
        stepper: &mut dyn Discretisation,
        solver: &SolverParameters,
        statistics: &mut Statistics,
    ) -> Result<(), StepError> {
        let gap = self.gap(&self.base);
        let mut dt = self.next_step.min(solver.max_step);
        if self.piece.velocity > 0.0 {
            dt = dt.min(gap / self.piece.velocity.max(STANDING));
        }
        let scale = self.deepest.max(solver.initial_increment);
        loop {
            let state = self.attempt(stepper, (AWAY, 0.0), &mut dt, statistics)?;
            let misfit = self.misfit(&state, state.touch.level, |node| node.level);
            let error = misfit.map(|m| step_control::error(m, scale, solver.tolerance));
            if let Some(error) =
                error.filter(|&e| step_control::is_excessive(e) && dt > MIN_FRACTION * self.first_step)
            {
                statistics.cuts += 1;
                dt *= step_control::shrinkage(error);
                continue;
            }
            let left = self.gap(&state);
            if left < -LANDED * solver.initial_increment {
                statistics.cuts += 1;
                dt *= (gap / (gap - left)).clamp(0.05, 0.95);
                continue;
            }
            self.accept(state, dt, error, statistics);
            return Ok(());
        }
    }

    /// Takes a state as the next one.
    fn accept(&mut self, state: State, dt: f64, error: Option<f64>, statistics: &mut Statistics) {
        statistics.steps += 1;
        self.next_step = dt * step_control::growth(error);
        if !state.touches_as(&self.base) {
            let before = Node::of(&self.base);
            self.start_anew(before);
        }
        self.keep(Node::of(&state));
        self.ahead = Some(Arc::new(state));
    }

    fn keep(&mut self, node: Node) {
        if self.nodes.len() == NODES {
            self.nodes.remove(0);
        }
        self.nodes.push(node);
    }

    /// Steps from `base` with the punch at `start` (m) and moving at `velocity` (m/s), cutting `dt` until it
    /// converges.
    fn attempt(
        &mut self,
        stepper: &mut dyn Discretisation,
        (start, velocity): (f64, f64),
        dt: &mut f64,
        statistics: &mut Statistics,
    ) -> Result<State, StepError> {
        let base = &self.base;
        let stretch = (FIRST_STEPS * self.first_step).max(STRETCH * (base.time - self.piece.start_time));
        if base.time > self.failures.0 + stretch {
            self.failures = (base.time, 0);
        }
        let lost =
            |step_size: f64, reason: String| StepError::NoConvergence { time: base.time, step_size, reason };
        loop {
            // A state of somebody's making may ask for shorter and shorter steps without end.
            if *dt <= ROUNDING * base.time.abs() {
                return Err(lost(*dt, "the step is too short to go on in time".to_owned()));
            }
            let patience = if *dt < SHORT * self.first_step { Patience::Much } else { Patience::Little };
            match stepper.step(base, Motion { start, velocity }, *dt, patience, statistics) {
                Ok(step) => return Ok(step.state),
                Err(reason) => {
                    statistics.cuts += 1;
                    self.failures.1 = self.failures.1.saturating_add(1);
                    *dt *= 0.25;
                    if *dt < MIN_FRACTION * self.first_step || self.failures.1 > MAX_FAILURES {
                        return Err(lost(*dt, reason.to_string()));
                    }
                }
            }
        }
    }
}
