//! One time step: the stages of a scheme, one after the other, in either dimension.

use super::derivatives::Sensitivity;
use super::extrapolation::Extrapolation;
use super::state::{Lengths, State};
use crate::contact::decision::Decision;
use crate::contact::status::Contact;
use crate::contact::surface::Touch;
use crate::element::History;
use crate::element::field::Integrals;
use crate::machine::machine_energy;
use crate::outputs::Statistics;
use crate::solver::newton::NewtonFailure;
use crate::solver::parameters::TimeScheme;
use crate::solver::scheme::stages;

/// How long a step may search for its solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Patience {
    /// A shorter step may find it sooner.
    Little,
    /// Shorter steps have not found it either.
    Much,
}

/// The punch's motion over a step, at constant velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Displacement at its start (m).
    pub start: f64,
    /// Velocity (m/s).
    pub velocity: f64,
}

/// What a stage starts from.
#[derive(Debug, Clone, Copy)]
pub struct Start<'a> {
    /// Unknowns.
    pub x: &'a [f64],
    /// Nodes in contact.
    pub contact: &'a Contact,
    /// History, continued through the stages before.
    pub history: &'a History,
    /// Changes with the parameters, where they are asked for.
    pub sensitivity: Option<&'a Sensitivity>,
}

/// One implicit stage to be solved.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// What it starts from.
    pub start: Start<'a>,
    /// Unknowns at which the search begins.
    pub guess: &'a [f64],
    /// Time of its end since the test's start (s).
    pub time: f64,
    /// Its length (s).
    pub length: f64,
    /// How far the history is continued for the next stage, as [`crate::solver::scheme::SchemeStage::reach`].
    pub reach: f64,
    /// Displacement of the punch (m).
    pub displacement: f64,
    /// Whether it ends the step.
    pub is_last: bool,
    /// How long its solution may be searched for.
    pub patience: Patience,
    /// The contact's decisions to follow instead of the surface's own.
    pub follow: Option<&'a [Decision]>,
}

/// What a stage found.
#[derive(Debug, Clone)]
pub struct Found {
    /// Unknowns.
    pub x: Vec<f64>,
    /// Nodes in contact while it was solved.
    pub contact: Contact,
    /// Nodes in contact from its end on.
    pub next: Contact,
    /// How the contact was decided, solution by solution.
    pub decisions: Vec<Decision>,
    /// Force of the punch (N).
    pub reaction: f64,
    /// Fluid force and traction integral over the face (N), at the end of a step.
    pub face: Option<(f64, f64)>,
    /// Energies and volume.
    pub integrals: Integrals,
    /// History from its end on, continued by the stage's reach.
    pub history: History,
    /// Changes with the parameters, where they are asked for.
    pub sensitivity: Option<Sensitivity>,
}

/// A step that was made.
#[derive(Debug, Clone)]
pub struct Step {
    /// The state at its end.
    pub state: State,
    /// What makes it again.
    pub stages: Vec<Solved>,
}

/// How a stage was solved: what a replay of it needs.
#[derive(Debug, Clone)]
pub struct Solved {
    /// Unknowns: a replay begins at them, as another solution may be near where an edge folds.
    pub x: Vec<f64>,
    /// How the contact was decided, solution by solution.
    pub decisions: Vec<Decision>,
}

/// What stays the same from step to step.
#[derive(Debug, Clone, PartialEq)]
pub struct Constants {
    /// Numbers of entries of the specimen's states.
    pub lengths: Lengths,
    /// A force that matters (N): the stress scale over the punch's area.
    pub force_scale: f64,
    /// Whether the punch can leave the specimen; where it cannot, retraction is an error.
    pub separates: bool,
    /// Scheme in time.
    pub scheme: TimeScheme,
    /// Compliance of the machine (m/N).
    pub compliance: f64,
}

impl Constants {
    /// Of a specimen whose entries are not counted yet, with its scales of stress (Pa) and length (m).
    pub fn new((stress, length): (f64, f64), separates: bool, scheme: TimeScheme, compliance: f64) -> Self {
        Self {
            lengths: Lengths::default(),
            force_scale: stress * length * length,
            separates,
            scheme,
            compliance,
        }
    }
}

/// A discretised specimen that makes one step at a time.
pub trait Discretisation {
    /// The undeformed specimen.
    fn undeformed(&self, time: f64) -> State;

    /// What stays the same from step to step.
    fn constants(&self) -> &Constants;

    /// Where the surface lies with the unknowns `x`.
    fn touch(&self, contact: &Contact, x: &[f64]) -> Touch;

    /// Solves one stage.
    ///
    /// # Errors
    /// Why it has no solution.
    fn solve(&mut self, task: &Task<'_>, statistics: &mut Statistics) -> Result<Found, NewtonFailure>;

    /// The state `dt` (s) later.
    ///
    /// # Errors
    /// Why a stage has no solution.
    fn step(
        &mut self,
        old: &State,
        motion: Motion,
        dt: f64,
        patience: Patience,
        statistics: &mut Statistics,
    ) -> Result<Step, NewtonFailure> {
        advance(self, old, (motion, dt), patience, None, statistics)
    }

    /// The state `dt` (s) later with the contact's decisions of another step, however the surface would decide, and near its solutions.
    ///
    /// # Errors
    /// Why a stage has no solution.
    fn replay(
        &mut self,
        old: &State,
        motion: Motion,
        dt: f64,
        stages: &[Solved],
        statistics: &mut Statistics,
    ) -> Result<Step, NewtonFailure> {
        advance(self, old, (motion, dt), Patience::Much, Some(stages), statistics)
    }
}

fn advance<D: Discretisation + ?Sized>(
    discretisation: &mut D,
    old: &State,
    (motion, dt): (Motion, f64),
    patience: Patience,
    follow: Option<&[Solved]>,
    statistics: &mut Statistics,
) -> Result<Step, NewtonFailure> {
    let mut outputs = old.outputs;
    let mut trend = old.trend.clone();
    let mut solved: Vec<Solved> = Vec::new();
    let mut last: Option<Found> = None;
    let mut reached = 0.0;
    let stages = stages(discretisation.constants().scheme);
    for (index, stage) in stages.iter().enumerate() {
        let start = last.as_ref().map_or_else(|| Start::of(old), Start::after);
        let ahead = (stage.time - reached) * dt;
        let follow = follow.map(|solved| solved.get(index));
        let mut guess = start.x.to_vec();
        match follow.flatten() {
            Some(other) => guess.clone_from(&other.x),
            None => trend.extrapolate(&mut guess, ahead),
        }
        let task = Task {
            start,
            guess: &guess,
            time: old.time + stage.time * dt,
            length: stage.fraction * dt,
            reach: stage.reach,
            displacement: motion.start + motion.velocity * stage.time * dt,
            is_last: index + 1 == stages.len(),
            patience,
            follow: follow.map(|other| other.map_or(&[][..], |solved| &solved.decisions)),
        };
        let mut found = discretisation.solve(&task, statistics);
        if found.is_err() && guess != start.x {
            // The extrapolation may have been the reason.
            found = discretisation.solve(&Task { guess: start.x, ..task }, statistics);
        }
        let mut found = found?;
        if found.contact.touches_as(start.contact) {
            trend.note(start.x, &found.x, ahead);
        } else {
            // A velocity that jumps with the contact does not tell where the next stage ends.
            trend = Extrapolation::at_rest(found.x.len());
        }
        let Integrals { viscous_dissipation_rate, porous_dissipation_rate, .. } = found.integrals;
        outputs.viscous_dissipation_rate = viscous_dissipation_rate;
        outputs.porous_dissipation_rate = porous_dissipation_rate;
        outputs.viscous_dissipation += stage.weight * dt * viscous_dissipation_rate;
        outputs.porous_dissipation += stage.weight * dt * porous_dissipation_rate;
        outputs.external_work += stage.weight * dt * motion.velocity * found.reaction;
        outputs.displacement = task.displacement;
        solved.push(Solved { x: found.x.clone(), decisions: std::mem::take(&mut found.decisions) });
        reached = stage.time;
        last = Some(found);
    }
    let Some(Found { x, next, reaction, face, integrals, history, sensitivity, .. }) = last else {
        return Err(NewtonFailure::ForeignState);
    };
    (outputs.force_fluid, outputs.force_traction) = face.unwrap_or_default();
    outputs.force = reaction;
    outputs.force_specimen = reaction;
    outputs.force_solid = reaction - outputs.force_fluid;
    // The machine keeps its own part of the work.
    let compliance = discretisation.constants().compliance;
    outputs.external_work -=
        machine_energy(compliance, reaction) - machine_energy(compliance, old.outputs.force_specimen);
    outputs.stored_energy = integrals.stored_energy;
    outputs.fluid_expelled = -integrals.volume_change;
    let touch = discretisation.touch(&next, &x);
    let time = old.time + dt;
    let state = State { time, x, trend, history, contact: next, touch, outputs, sensitivity };
    Ok(Step { state, stages: solved })
}

impl<'a> Start<'a> {
    fn of(state: &'a State) -> Self {
        let State { x, contact, history, sensitivity, .. } = state;
        Self { x, contact, history, sensitivity: sensitivity.as_ref() }
    }

    fn after(stage: &'a Found) -> Self {
        let Found { x, next, history, sensitivity, .. } = stage;
        Self { x, contact: next, history, sensitivity: sensitivity.as_ref() }
    }
}
