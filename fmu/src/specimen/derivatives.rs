//! Forward sensitivities: how the force changes with every parameter of the material and, where they are asked for, with the
//! magnitudes of effects.
//!
//! Direct differentiation of a converged stage `R(x, h(theta), c(theta), theta) = 0`, h its history and c what the
//! contact remembers: `K dx = -(dR/dh dh + dR/dc dc + dR/dtheta)`. The tangent is that of the last Newton
//! evaluation; one factorisation serves all parameters. The contact remembers where each node stuck, and the friction
//! under which a patch yields; both depend on the parameters, and their changes are carried along. Steps, their sizes
//! and the stages in which nodes are touched, released or let slide are the computed curve's own: they stay fixed, and
//! where another parameter would move such an event the derivative of the curve jumps there.

use super::step::Task;
use super::stepper::Stepper;
use crate::contact::conditions::Condition;
use crate::contact::status::Contact;
use crate::element::Stage;
use crate::element::sensitivity::HistorySensitivity;
use crate::law::Magnitude;
use crate::machine::UnitMotion;
use crate::outputs::{ForceSensitivity, Statistics};
use crate::solver::newton::NewtonFailure;
use serde::{Deserialize, Serialize};

/// Changes of a state by every parameter: the material's in the order of [`crate::law::MaterialParameter::index`], then the
/// first [`Magnitude::OF_SPECIMEN`] magnitudes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sensitivity {
    /// Of the history.
    pub history: HistorySensitivity,
    /// Of what the contact remembers.
    pub contact: ContactSensitivity,
    /// Of the force.
    pub forces: Vec<ForceSensitivity>,
}

/// Changes of what the contact remembers, parameter by parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ContactSensitivity {
    /// Of the radial displacements at which the nodes of the surface stick (m).
    held: Vec<f64>,
    /// Of the friction under which its corners yield [-].
    yielding: Vec<f64>,
}

impl Sensitivity {
    /// The undeformed state under so many nodes of the surface does not depend on any of the parameters.
    pub fn undeformed(elements: usize, branches: usize, nodes: usize, parameters: usize) -> Self {
        Self {
            history: HistorySensitivity::undeformed(elements, branches, parameters),
            contact: ContactSensitivity {
                held: vec![0.0; nodes * parameters],
                yielding: vec![0.0; nodes.div_ceil(2) * parameters],
            },
            forces: vec![ForceSensitivity::default(); parameters],
        }
    }

    /// The same of a material that softens with past strain, where `softens` says so.
    pub fn remembering(mut self, softens: bool) -> Self {
        self.history = self.history.remembering(softens);
        self
    }

    /// Numbers of its entries.
    pub fn lengths(&self) -> [usize; 6] {
        let ([jacobian, cv_inverse, past_strain], contact) = (self.history.lengths(), &self.contact);
        [jacobian, cv_inverse, past_strain, contact.held.len(), contact.yielding.len(), self.forces.len()]
    }
}

/// A solution of a stage.
#[derive(Debug, Clone, Copy)]
pub(super) struct Converged<'a> {
    pub stage: Stage<'a>,
    /// Nodes in contact while it was solved.
    pub contact: &'a Contact,
    /// Changes of the history at its start.
    pub history: &'a HistorySensitivity,
}

/// Changes of a solution, parameter by parameter.
pub(super) struct Changes {
    /// Of the unknowns.
    x: Vec<f64>,
    /// Of the force of the punch (N).
    force: Vec<f64>,
}

impl Stepper {
    /// Changes of the solution that was just found, given those of what the contact remembers.
    pub(super) fn differentiate(
        &mut self,
        at: &Converged<'_>,
        remembered: &ContactSensitivity,
        task: &Task<'_>,
        statistics: &mut Statistics,
    ) -> Result<Changes, NewtonFailure> {
        self.linearise(at.stage.x, task, statistics)?;
        let (x, unknowns) = (at.stage.x, at.stage.x.len());
        let (places, mut loads) = (self.places(), vec![0.0; self.parameters * unknowns]);
        self.sample.body(&self.material).residual_sensitivity(&at.stage, at.history, &mut loads)?;
        let reaction = |load: &[f64]| -self.conditions.punch.iter().map(|&u| load[u]).sum::<f64>();
        let mut force: Vec<f64> = loads.chunks_exact(unknowns).map(reaction).collect();
        if let Some(places) = places {
            self.add_contact_loads(places, at, &mut loads, &mut force);
        }
        let energy_scale = self.energy_scale();
        let (nodes, corners) = (self.surface.nodes(), self.surface.nodes().len().div_ceil(2));
        let ContactSensitivity { held, yielding } = remembered;
        let remembered = held.chunks_exact(nodes.len()).zip(yielding.chunks_exact(corners));
        let strength = places.map(|places| places.of(Magnitude::AdhesiveStrength));
        for (parameter, (load, (held, yielding))) in
            loads.chunks_exact_mut(unknowns).zip(remembered).enumerate()
        {
            for slide in &self.conditions.slides {
                let guide = slide.at(self.surface.profile(), x);
                load[slide.radial] += guide.ratio * load[slide.radial + 1];
                if let Some(corner) = at.contact.yielding_corner(slide.node) {
                    let axial = self.raw_residual[slide.radial + 1] - self.conditions.pull(slide.radial + 1);
                    let by_friction = guide.ratio_by_friction * axial - slide.adhesion;
                    load[slide.radial] += by_friction * yielding[corner];
                }
            }
            if strength == Some(parameter) {
                self.add_friction_of_adhesion(at, load);
            }
            for ((value, scale), condition) in
                load.iter_mut().zip(&self.column_scale).zip(&self.conditions.unknowns)
            {
                *value = if *condition == Condition::Free { -*value * scale / energy_scale } else { 0.0 };
            }
            for (k, (node, held)) in nodes.iter().zip(held).enumerate() {
                if at.contact.is_held(k) && self.conditions.unknowns[node.radial] == Condition::Fixed {
                    load[node.radial] = held / self.column_scale[node.radial];
                    // A place farther out on an inclined face is higher.
                    load[node.axial] = self.surface.face(k, at.contact).slope * load[node.radial];
                }
            }
        }
        if let Some(places) = places {
            self.add_motion_of_punch(places, &mut loads);
        }
        statistics.factorisations += 1;
        let tangent = self.work.tangent();
        let singular = |_| NewtonFailure::Singular(0);
        self.linear.factorise(tangent).map_err(singular)?;
        self.linear.solve_again(tangent, &mut loads).map_err(singular)?;
        for (change, force) in loads.chunks_exact_mut(unknowns).zip(&mut force) {
            for ((value, scale), row) in change.iter_mut().zip(&self.column_scale).zip(&self.reaction_row) {
                *value *= scale;
                *force -= row * *value;
            }
        }
        if self.constants.compliance != 0.0 {
            let (scale, row) = (&self.column_scale, &self.reaction_row);
            let unit =
                UnitMotion::new(&self.conditions, scale, row, |rhs| self.linear.solve_again(tangent, rhs))
                    .map_err(singular)?;
            for (change, force) in loads.chunks_exact_mut(unknowns).zip(&mut force) {
                *force = unit.follow(self.constants.compliance, scale, *force, change);
            }
        }
        Ok(Changes { x: loads, force })
    }

    /// Takes note of what the contact will remember from now on: where nodes stick that `next` holds and the solution
    /// did not, and the friction of the patches that begin to yield.
    pub(super) fn note_contact(
        &self,
        at: &Converged<'_>,
        next: &Contact,
        changes: &Changes,
        remembered: &mut ContactSensitivity,
    ) -> Result<(), NewtonFailure> {
        let (unknowns, nodes) = (at.stage.x.len(), self.surface.nodes());
        for (k, node) in nodes.iter().enumerate() {
            if next.is_held(k) && !at.contact.is_held(k) {
                let places = remembered.held.chunks_exact_mut(nodes.len());
                for (held, change) in places.zip(changes.x.chunks_exact(unknowns)) {
                    held[k] = change[node.radial];
                }
            }
        }
        if !self.surface.begins_to_yield(at.contact, next) {
            return Ok(());
        }
        let forces = self.nodal_force_changes(at, changes)?;
        let corners = nodes.len().div_ceil(2);
        let each = changes.x.chunks_exact(unknowns).zip(forces.chunks_exact(unknowns));
        let strength = self.places().map(|places| places.of(Magnitude::AdhesiveStrength));
        let all = remembered.yielding.chunks_exact_mut(corners).zip(each);
        for (parameter, (yielding, (x_change, force_change))) in all.enumerate() {
            let solution = (at.stage.x, self.raw_residual.as_slice());
            let strength_change = if strength == Some(parameter) { 1.0 } else { 0.0 };
            self.surface.differentiate_yield(
                (at.contact, next),
                solution,
                (x_change, force_change, strength_change),
                yielding,
            );
        }
        Ok(())
    }

    /// Changes of the nodal forces on the surface (N), parameter by parameter; other entries mean nothing.
    fn nodal_force_changes(&self, at: &Converged<'_>, changes: &Changes) -> Result<Vec<f64>, NewtonFailure> {
        let unknowns = at.stage.x.len();
        let body = self.sample.body(&self.material);
        let mut forces = vec![0.0; changes.x.len()];
        body.residual_sensitivity(&at.stage, at.history, &mut forces)?;
        let pattern = &self.sample.map.pattern;
        let (mut residual, mut tangent) = (vec![0.0; unknowns], vec![0.0; pattern.rows.len()]);
        body.assemble(&at.stage, &mut residual, Some(&mut tangent))?;
        for (force, change) in forces.chunks_exact_mut(unknowns).zip(changes.x.chunks_exact(unknowns)) {
            for (column, change) in change.iter().enumerate() {
                let (first, rows) = pattern.column(column);
                for (value, &row) in tangent[first..].iter().zip(rows) {
                    force[row as usize] += value * change;
                }
            }
        }
        Ok(forces)
    }

    /// Changes of forces and history over the stage that was solved.
    pub(super) fn continue_sensitivity(
        &self,
        at: &Converged<'_>,
        reach: f64,
        changes: &Changes,
        contact: ContactSensitivity,
    ) -> Result<Sensitivity, NewtonFailure> {
        let body = self.sample.body(&self.material);
        let mut fluid = vec![0.0; changes.force.len()];
        let closed = self.surface.closed_points(at.contact);
        body.fluid_force_sensitivity(at.stage.x, &changes.x, &closed, &mut fluid)?;
        let forces = changes.force.iter().zip(fluid);
        let forces =
            forces.map(|(&force, fluid)| ForceSensitivity { force, specimen: force, fluid }).collect();
        let mut history = at.history.clone();
        body.update_sensitivity(&at.stage, reach, &changes.x, at.history, &mut history)?;
        Ok(Sensitivity { history, contact, forces })
    }
}
