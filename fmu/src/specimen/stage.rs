//! One implicit stage of the axisymmetric specimen: equilibrium and contact in turns, then what follows from them.

use super::derivatives::{ContactSensitivity, Converged, Sensitivity};
use super::extrapolation::Extrapolation;
use super::state::State;
use super::step::{Constants, Discretisation, Found, Task};
use super::stepper::Stepper;
use crate::contact::decision::{Decision, Slack, Trial};
use crate::contact::{Contact, Touch};
use crate::element::{Inadmissible, Stage, undeformed};
use crate::law::PointMaterial;
use crate::outputs::{Outputs, Statistics};
use crate::solver::newton::NewtonFailure;

/// A pull below this fraction of the force scale opens no node.
const NEGLIGIBLE_PULL: f64 = 1e-7;
/// A node closer to the punch's face than this fraction of the punch's radius touches it.
const NEGLIGIBLE_GAP: f64 = 1e-8;
/// A stage changes its nodes in contact at most as many times.
const MAX_CHANGES: usize = 16;

/// An equilibrium with the nodes in contact that belong to it.
struct Settled {
    x: Vec<f64>,
    /// Nodes in contact while it was solved, and from then on.
    contact: Contact,
    next: Contact,
    decisions: Vec<Decision>,
    /// Changes of what the contact remembered while it was solved.
    remembered: Option<ContactSensitivity>,
}

impl Discretisation for Stepper {
    fn undeformed(&self, time: f64) -> State {
        let (unknowns, elements) = (self.sample.mesh.unknowns(), self.sample.mesh.elements.len());
        let (branches, nodes) = (self.material.branches(), self.surface.nodes().len());
        let (x, contact) = (vec![0.0; unknowns], self.surface.touched());
        let softens = self.material.softening.is_some();
        State {
            time,
            touch: self.surface.touch(&contact, &x),
            contact,
            x,
            trend: Extrapolation::at_rest(unknowns),
            history: undeformed(elements, branches).remembering(softens),
            outputs: Outputs::default(),
            sensitivity: (self.parameters > 0).then(|| {
                Sensitivity::undeformed(elements, branches, nodes, self.parameters).remembering(softens)
            }),
        }
    }

    fn constants(&self) -> &Constants {
        &self.constants
    }

    fn touch(&self, contact: &Contact, x: &[f64]) -> Touch {
        self.surface.touch(contact, x)
    }

    fn solve(&mut self, task: &Task<'_>, statistics: &mut Statistics) -> Result<Found, NewtonFailure> {
        let start = &task.start;
        if let Some((material, extensions)) = &self.drifting {
            self.material = PointMaterial::extended(material, extensions, task.time);
        }
        let settled = self.settle(task, statistics)?;
        let Settled { x, contact, next, decisions, remembered } = settled;
        let reaction = self.conditions.reaction(&self.raw_residual);
        let stage = Stage { x: &x, old: start.history, dt: task.length };
        let body = self.sample.body(&self.material);
        let face = task.is_last.then(|| body.face_forces(&stage, &self.surface.closed_points(&contact)));
        let face = face.transpose()?;
        let mut history = start.history.clone();
        let integrals = body.update(&stage, task.reach, &mut history)?;
        let sensitivity = match start.sensitivity.zip(remembered) {
            None => None,
            Some((start, mut remembered)) => {
                let at = Converged { stage, contact: &contact, history: &start.history };
                let changes = self.differentiate(&at, &remembered, task, statistics)?;
                self.note_contact(&at, &next, &changes, &mut remembered)?;
                Some(self.continue_sensitivity(&at, task.reach, &changes, remembered)?)
            }
        };
        Ok(Found { x, contact, next, decisions, reaction, face, integrals, history, sensitivity })
    }
}

impl Stepper {
    /// Solves with the nodes in contact, and again with others, until the surface lets them stand; leaves the nodal
    /// forces in `raw_residual`.
    fn settle(&mut self, task: &Task<'_>, statistics: &mut Statistics) -> Result<Settled, NewtonFailure> {
        let start = &task.start;
        let slack = Slack {
            force: NEGLIGIBLE_PULL * self.constants.force_scale,
            length: NEGLIGIBLE_GAP * self.length_scale,
        };
        let (mut x, mut contact) = (task.guess.to_vec(), start.contact.clone());
        let mut remembered = start.sensitivity.map(|s| s.contact.clone());
        let (mut past, mut decisions) = (self.surface.no_past(), Vec::new());
        for solution in 0..=MAX_CHANGES {
            self.conditions.apply(&self.surface, &contact);
            self.find(&mut x, task, statistics)?;
            let reaction = self.conditions.reaction(&self.raw_residual);
            let indentation = task.displacement - self.constants.compliance * reaction;
            let trial = Trial { x: &x, from: start.x, forces: &self.raw_residual, indentation, slack };
            let decision = match task.follow {
                None => self.surface.decide(&contact, &trial, &mut past),
                Some(decisions) => decisions.get(solution).cloned().ok_or(NewtonFailure::Contact)?,
            };
            let next = self.surface.follow(&contact, &decision, &trial);
            let stands = !decision.solve_again;
            decisions.push(decision);
            if stands {
                return Ok(Settled { x, contact, next, decisions, remembered });
            }
            if let Some((start_changes, remembered)) = start.sensitivity.zip(remembered.as_mut())
                && self.surface.remembers(&contact, &next)
            {
                let stage = Stage { x: &x, old: start.history, dt: task.length };
                let at = Converged { stage, contact: &contact, history: &start_changes.history };
                let changes = self.differentiate(&at, remembered, task, statistics)?;
                self.note_contact(&at, &next, &changes, remembered)?;
            }
            contact = next;
        }
        Err(NewtonFailure::Contact)
    }
}

impl From<Inadmissible> for NewtonFailure {
    fn from(failed: Inadmissible) -> Self {
        Self::Inadmissible(failed.element)
    }
}
