//! The punch's motion: pieces of constant velocity, integrated ahead of the communication points.
//!
//! Between two changes of its velocity the punch's path is known, so the steps need not end where a
//! master communicates: an instance integrates ahead with its own step sizes and interpolates. Only
//! when the velocity changes is the state computed at that very time. The force therefore does not
//! depend on how a master slices time.

use super::load_cell::LoadCell;
use super::step::{State, Stepper};
use crate::effect::EffectParameters;
use crate::error::StepError;
use crate::outputs::{ForceSensitivity, Outputs, Statistics};
use crate::parameters::SolverParameters;
use crate::solver::newton::NewtonFailure;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A step grows by at most this factor.
const MAX_GROWTH: f64 = 2.0;
/// A step shrinks, after an excessive error, by at most this factor.
const MAX_SHRINK: f64 = 0.25;
/// Ratio of the error to the misfit of the extrapolation: 0.04 for an SDIRK2 step, and up to this for the
/// interpolation between its ends.
const ERROR_CONSTANT: f64 = 0.1;
/// A step is repeated when its estimated error exceeds the tolerance by this factor.
const REJECT: f64 = 8.0;
/// No step moves the punch by more than this fraction of its radius.
const MAX_TRAVEL: f64 = 0.1;
/// Steps below this fraction of the first one are hopeless.
const MIN_FRACTION: f64 = 1e-6;
/// Nodes kept for interpolation.
const NODES: usize = 4;

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

    fn step(
        &mut self,
        old: &State,
        start: f64,
        velocity: f64,
        dt: f64,
        statistics: &mut Statistics,
    ) -> Result<State, NewtonFailure> {
        self.step(old, start, velocity, dt, statistics)
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
}

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

/// Results at the end of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Node {
    time: f64,
    outputs: Outputs,
    sensitivities: Vec<ForceSensitivity>,
}

impl Node {
    fn of(state: &impl Reached) -> Self {
        Self { time: state.time(), outputs: state.outputs(), sensitivities: state.sensitivities() }
    }
}

/// The integrated path: the last two states and the nodes to interpolate between.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Path<S = State> {
    piece: Piece,
    /// Start of the step that covers the present time.
    base: Arc<S>,
    /// Its end, when the present lies inside it.
    ahead: Option<Arc<S>>,
    /// Results at the last few step ends of this piece, oldest first.
    nodes: Vec<Node>,
    next_step: f64,
    first_step: f64,
    largest_force: f64,
    /// The load cell at the start of that step.
    cell: LoadCell,
}

impl<S: Reached> Path<S> {
    /// Contact begins at `time` (s) with displacement zero; `effect` tells of the load cell.
    pub fn touch(stepper: &impl Discretisation<State = S>, effect: &EffectParameters, time: f64) -> Self {
        let base = Arc::new(stepper.undeformed(time));
        Self {
            piece: Piece { start_time: time, start: 0.0, velocity: 0.0 },
            nodes: vec![Node::of(&*base)],
            base,
            ahead: None,
            next_step: f64::INFINITY,
            first_step: f64::INFINITY,
            largest_force: 0.0,
            cell: LoadCell::at_rest(effect, time),
        }
    }

    /// Whether the state belongs to the stepper's mesh and material.
    pub fn fits(&self, stepper: &impl Discretisation<State = S>) -> bool {
        stepper.fits(&self.base) && self.ahead.as_ref().is_none_or(|a| stepper.fits(a))
    }

    /// Moves the punch from `from` at `now` to `to` at `end`; returns the results at `end`.
    ///
    /// # Errors
    /// [`StepError::NoConvergence`]; the path is then to be discarded.
    #[allow(clippy::too_many_arguments)]
    pub fn advance(
        &mut self,
        stepper: &mut impl Discretisation<State = S>,
        solver: &SolverParameters,
        punch_radius: f64,
        (now, from): (f64, f64),
        (end, to): (f64, f64),
        statistics: &mut Statistics,
    ) -> Result<Outputs, StepError> {
        let velocity = (to - from) / (end - now);
        if (self.piece.position(end) - to).abs() > 1e-9 * punch_radius {
            self.settle(stepper, now, statistics)?;
            let change = (velocity - self.piece.velocity).abs();
            self.piece = Piece { start_time: now, start: from, velocity };
            // Half the first communication step at most: between the first two nodes there is only a line.
            self.first_step = (solver.initial_increment / change).min(0.5 * (end - now));
            self.next_step = self.next_step.min(self.first_step);
            self.nodes = vec![Node { time: now, ..Node::of(&*self.base) }];
        }
        let longest = (MAX_TRAVEL * punch_radius / velocity.abs()).min(solver.max_step);
        while self.ahead.as_ref().unwrap_or(&self.base).time() < end * (1.0 - 1e-14) {
            if let Some(ahead) = self.ahead.take() {
                self.follow(ahead.time());
                self.base = ahead;
            }
            self.next_step = self.next_step.min(longest);
            self.step_ahead(stepper, solver, statistics)?;
        }
        let mut outputs = self.interpolate(end);
        outputs.displacement = to;
        outputs.force = self.reading(end, &outputs);
        Ok(outputs)
    }

    /// What the load cell reads at a time the path has reached.
    fn reading(&self, time: f64, outputs: &Outputs) -> f64 {
        if self.cell.is_immediate() {
            return self.cell.felt(outputs);
        }
        self.cell.read(time, &self.felt(), |t| self.weights(&self.nodes, t))
    }

    /// Forces on the load cell at the nodes.
    fn felt(&self) -> Vec<f64> {
        self.nodes.iter().map(|n| self.cell.felt(&n.outputs)).collect()
    }

    fn derivatives(&self) -> Vec<&[ForceSensitivity]> {
        self.nodes.iter().map(|n| n.sensitivities.as_slice()).collect()
    }

    /// Moves the load cell on to `time`, before the nodes change.
    fn follow(&mut self, time: f64) {
        if self.cell.is_immediate() {
            return;
        }
        let mut cell = self.cell.clone();
        cell.follow(time, &self.felt(), &self.derivatives(), |t| self.weights(&self.nodes, t));
        self.cell = cell;
    }

    /// Makes `base` the state at `now`.
    fn settle(
        &mut self,
        stepper: &mut impl Discretisation<State = S>,
        now: f64,
        statistics: &mut Statistics,
    ) -> Result<(), StepError> {
        self.follow(now);
        if let Some(ahead) = self.ahead.take() {
            if (ahead.time() - now).abs() <= 1e-12 * now.abs() {
                self.base = ahead;
            } else {
                // The last node lies ahead of the change of velocity and never happens.
                self.nodes.pop();
            }
        }
        while self.base.time() < now * (1.0 - 1e-14) {
            let mut dt = now - self.base.time();
            let state = self.attempt(stepper, &mut dt, statistics)?;
            self.base = Arc::new(state);
        }
        Ok(())
    }

    /// One step beyond `base`, with error control.
    fn step_ahead(
        &mut self,
        stepper: &mut impl Discretisation<State = S>,
        solver: &SolverParameters,
        statistics: &mut Statistics,
    ) -> Result<(), StepError> {
        let mut dt = self.next_step;
        loop {
            let state = self.attempt(stepper, &mut dt, statistics)?;
            let scale =
                state.outputs().force.abs().max(0.1 * self.largest_force).max(1e-3 * stepper.force_scale());
            let error = self.misfit(&state).map(|m| ERROR_CONSTANT * m / (scale * solver.tolerance));
            if let Some(error) = error.filter(|&e| e > REJECT && dt > MIN_FRACTION * self.first_step) {
                statistics.cuts += 1;
                dt *= (0.8 / error.cbrt()).max(MAX_SHRINK);
                continue;
            }
            let growth = error.map_or(MAX_GROWTH, |e| (0.9 / e.cbrt()).clamp(MAX_SHRINK, MAX_GROWTH));
            statistics.steps += 1;
            self.next_step = dt * growth;
            self.largest_force = self.largest_force.max(state.outputs().force.abs());
            if self.nodes.len() == NODES {
                self.nodes.remove(0);
            }
            self.nodes.push(Node::of(&state));
            self.ahead = Some(Arc::new(state));
            return Ok(());
        }
    }

    /// Steps from `base`, cutting `dt` until it converges.
    fn attempt(
        &self,
        stepper: &mut impl Discretisation<State = S>,
        dt: &mut f64,
        statistics: &mut Statistics,
    ) -> Result<S, StepError> {
        let base = &self.base;
        loop {
            let start = self.piece.position(base.time());
            match stepper.step(base, start, self.piece.velocity, *dt, statistics) {
                Ok(state) => return Ok(state),
                Err(reason) => {
                    statistics.cuts += 1;
                    *dt *= 0.25;
                    if *dt < MIN_FRACTION * self.first_step {
                        return Err(StepError::NoConvergence {
                            time: base.time(),
                            step_size: *dt,
                            reason: reason.to_string(),
                        });
                    }
                }
            }
        }
    }

    /// Difference between a new force and the one extrapolated from the last nodes.
    fn misfit(&self, state: &S) -> Option<f64> {
        let known = &self.nodes[self.nodes.len().saturating_sub(NODES - 1)..];
        if known.len() < 2 {
            return None;
        }
        let extrapolated: f64 =
            self.weights(known, state.time()).iter().zip(known).map(|(w, n)| w * n.outputs.force).sum();
        Some((state.outputs().force - extrapolated).abs())
    }

    fn interpolate(&self, time: f64) -> Outputs {
        let weights = self.weights(&self.nodes, time);
        let terms: Vec<_> = weights.iter().zip(&self.nodes).map(|(&w, n)| (w, &n.outputs)).collect();
        Outputs::combine(&terms)
    }

    /// Derivatives of the force at a time the path has reached; empty when they are not computed.
    pub fn sensitivities(&self, time: f64) -> Vec<ForceSensitivity> {
        let parameters = self.nodes.last().map_or(0, |n| n.sensitivities.len());
        if parameters == 0 {
            return Vec::new();
        }
        let mut sum = vec![ForceSensitivity::default(); parameters];
        for (weight, node) in self.weights(&self.nodes, time).into_iter().zip(&self.nodes) {
            for (sum, at) in sum.iter_mut().zip(&node.sensitivities) {
                sum.force += weight * at.force;
                sum.specimen += weight * at.specimen;
                sum.fluid += weight * at.fluid;
            }
        }
        if !self.cell.is_immediate() {
            let lagging =
                self.cell.read_derivatives(time, &self.derivatives(), |t| self.weights(&self.nodes, t));
            sum.iter_mut().zip(lagging).for_each(|(sum, derivative)| sum.force = derivative);
        }
        sum
    }

    /// Lagrange weights in the square root of the time since the change of velocity, in which both
    /// linear growth and seepage (square root of time) are polynomials; two nodes give a line in time.
    fn weights(&self, nodes: &[Node], time: f64) -> Vec<f64> {
        let root = nodes.len() > 2;
        let s = |t: f64| {
            let since = t - self.piece.start_time;
            if root { (since + self.first_step).max(0.0).sqrt() } else { since }
        };
        let x = s(time);
        let known: Vec<f64> = nodes.iter().map(|n| s(n.time)).collect();
        known
            .iter()
            .enumerate()
            .map(|(i, a)| {
                let others = known.iter().enumerate().filter(|(j, _)| *j != i);
                others.map(|(_, b)| (x - b) / (a - b)).product()
            })
            .collect()
    }
}
