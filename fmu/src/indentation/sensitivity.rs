//! Forward sensitivities: how the force changes with every parameter of the material.
//!
//! Direct differentiation of a converged stage `R(x, h(theta), theta) = 0`, h its history:
//! `K dx = -(dR/dh dh + dR/dtheta)`. The tangent is that of the last Newton evaluation; one factorisation
//! serves all parameters. Steps and their sizes are part of the method, not of the model: they stay fixed, and
//! so do the stage in which a node is touched or released and the friction under which a patch yields. A node that sticks is held where it was touched,
//! which depends on the parameters: its change is carried along.

use super::boundary::Condition;
use super::contact::Contact;
use super::coupling::UnitMotion;
use super::step::{State, Stepper};
use crate::element::Stage;
use crate::element::sensitivity::HistorySensitivity;
use crate::material::MaterialParameter;
use crate::outputs::{ForceSensitivity, Statistics};
use crate::solver::newton::NewtonFailure;
use serde::{Deserialize, Serialize};

/// Changes of a state by every parameter, in the order of [`MaterialParameter::index`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sensitivity {
    /// Of the unknowns, parameter by parameter.
    pub x: Vec<f64>,
    /// Of the history.
    pub history: HistorySensitivity,
    /// Of the radial displacements at which the nodes of the surface stick, parameter by parameter.
    pub held: Vec<f64>,
    /// Of the force.
    pub forces: Vec<ForceSensitivity>,
}

impl Sensitivity {
    /// The undeformed state does not depend on any parameter.
    pub fn undeformed(unknowns: usize, elements: usize, branches: usize, surface: usize) -> Self {
        let parameters = MaterialParameter::count(branches);
        Self {
            x: vec![0.0; unknowns * parameters],
            held: vec![0.0; surface * parameters],
            history: HistorySensitivity::undeformed(elements, branches),
            forces: vec![ForceSensitivity::default(); parameters],
        }
    }

    /// The same of a material that softens with past strain, where `softens` says so.
    pub fn remembering(mut self, softens: bool) -> Self {
        self.history = self.history.remembering(softens);
        self
    }
}

impl Stepper {
    /// Changes of unknowns, forces and history over the stage that was just solved; the history's changes at
    /// its start are in `stage_sensitivity`.
    pub(super) fn differentiate(
        &mut self,
        x: &[f64],
        contact: &Contact,
        dt: f64,
        reach: f64,
        new: &mut Sensitivity,
        statistics: &mut Statistics,
    ) -> Result<(), NewtonFailure> {
        self.differentiate_unknowns(x, contact, dt, new, statistics)?;
        let body = self.sample.body(&self.material);
        let mut fluid = vec![0.0; new.forces.len()];
        let closed = self.surface.closed_points(contact);
        body.fluid_force_sensitivity(x, &new.x, &closed, &mut fluid)?;
        for (force, fluid) in new.forces.iter_mut().zip(fluid) {
            (force.specimen, force.fluid) = (force.force, fluid);
        }
        let stage = Stage { x, old: &self.stage_history, dt };
        Ok(body.update_sensitivity(&stage, reach, &new.x, &self.stage_sensitivity, &mut new.history)?)
    }

    /// Takes note of how the places change at which nodes will stick that `touched` holds and the conditions of
    /// the stage that was just solved do not yet.
    pub(super) fn differentiate_held(
        &mut self,
        state: &mut State,
        touched: &Contact,
        dt: f64,
        statistics: &mut Statistics,
    ) -> Result<(), NewtonFailure> {
        let count = self.surface.nodes().len();
        let newly = |k: usize| touched.is_held(k) && !state.contact.is_held(k);
        let Some(sensitivity) = &mut state.sensitivity else { return Ok(()) };
        if !(0..count).any(newly) {
            return Ok(());
        }
        self.differentiate_unknowns(&state.x, &state.contact, dt, sensitivity, statistics)?;
        let changes = sensitivity.x.chunks_exact(state.x.len());
        for (held, change) in sensitivity.held.chunks_exact_mut(count).zip(changes) {
            for (k, (held, node)) in held.iter_mut().zip(self.surface.nodes()).enumerate() {
                if newly(k) {
                    *held = change[node.radial];
                }
            }
        }
        Ok(())
    }

    /// Changes of the unknowns and of the force.
    fn differentiate_unknowns(
        &mut self,
        x: &[f64],
        contact: &Contact,
        dt: f64,
        new: &mut Sensitivity,
        statistics: &mut Statistics,
    ) -> Result<(), NewtonFailure> {
        let (body, unknowns) = (self.sample.body(&self.material), x.len());
        let stage = Stage { x, old: &self.stage_history, dt };
        let Sensitivity { x: loads, held, forces, .. } = new;
        body.residual_sensitivity(&stage, &self.stage_sensitivity, loads)?;
        for (load, force) in loads.chunks_exact(unknowns).zip(forces.iter_mut()) {
            force.force = -self.conditions.punch.iter().map(|&u| load[u]).sum::<f64>();
        }
        let energy_scale = self.energy_scale();
        let nodes = self.surface.nodes();
        for (load, held) in loads.chunks_exact_mut(unknowns).zip(held.chunks_exact(nodes.len())) {
            for slide in &self.conditions.slides {
                load[slide.radial] += slide.at(self.surface.profile(), x).ratio * load[slide.radial + 1];
            }
            for ((value, scale), condition) in
                load.iter_mut().zip(&self.column_scale).zip(&self.conditions.unknowns)
            {
                *value = if *condition == Condition::Free { -*value * scale / energy_scale } else { 0.0 };
            }
            for (k, (node, held)) in nodes.iter().zip(held).enumerate() {
                if contact.is_held(k) && self.conditions.unknowns[node.radial] == Condition::Fixed {
                    load[node.radial] = held / self.column_scale[node.radial];
                    // A place farther out on an inclined face is higher.
                    load[node.axial] = self.surface.face(k, contact).slope * load[node.radial];
                }
            }
        }
        statistics.factorisations += 1;
        let tangent = self.work.tangent();
        let singular = |_| NewtonFailure::Singular(0);
        self.linear.factorise(tangent).map_err(singular)?;
        self.linear.solve_again(tangent, loads).map_err(singular)?;
        for (change, force) in loads.chunks_exact_mut(unknowns).zip(forces) {
            for ((value, scale), row) in change.iter_mut().zip(&self.column_scale).zip(&self.reaction_row) {
                *value *= scale;
                force.force -= row * *value;
            }
        }
        if self.compliance != 0.0 {
            let (scale, row) = (&self.column_scale, &self.reaction_row);
            let unit =
                UnitMotion::new(&self.conditions, scale, row, |rhs| self.linear.solve_again(tangent, rhs))
                    .map_err(singular)?;
            for (change, force) in new.x.chunks_exact_mut(unknowns).zip(&mut new.forces) {
                force.force = unit.follow(self.compliance, scale, force.force, change);
            }
        }
        Ok(())
    }
}
