//! Forward sensitivities: how the force changes with every parameter of the material.
//!
//! Direct differentiation of a converged stage `R(x, h(theta), theta) = 0`, h its history:
//! `K dx = -(dR/dh dh + dR/dtheta)`. The tangent is that of the last Newton evaluation; one factorisation
//! serves all parameters. Steps and their sizes are part of the method, not of the model: they stay fixed.

use super::boundary::Condition;
use super::coupling::UnitMotion;
use super::step::Stepper;
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
    /// Of the force.
    pub forces: Vec<ForceSensitivity>,
}

impl Sensitivity {
    /// The undeformed state does not depend on any parameter.
    pub fn undeformed(unknowns: usize, elements: usize, branches: usize) -> Self {
        let parameters = MaterialParameter::count(branches);
        Self {
            x: vec![0.0; unknowns * parameters],
            history: HistorySensitivity::undeformed(elements, branches),
            forces: vec![ForceSensitivity::default(); parameters],
        }
    }
}

impl Stepper {
    /// Changes of unknowns, forces and history over the stage that was just solved; the history's changes at
    /// its start are in `stage_sensitivity`.
    pub(super) fn differentiate(
        &mut self,
        x: &[f64],
        dt: f64,
        reach: f64,
        new: &mut Sensitivity,
        statistics: &mut Statistics,
    ) -> Result<(), NewtonFailure> {
        let (body, unknowns) = (self.sample.body(&self.material), x.len());
        let stage = Stage { x, old: &self.stage_history, dt };
        let loads = &mut new.x;
        body.residual_sensitivity(&stage, &self.stage_sensitivity, &mut self.flows, loads)?;
        for (load, force) in loads.chunks_exact(unknowns).zip(&mut new.forces) {
            force.force = -self.conditions.punch.iter().map(|&u| load[u]).sum::<f64>();
        }
        let energy_scale = self.energy_scale();
        for load in loads.chunks_exact_mut(unknowns) {
            for ((value, scale), condition) in
                load.iter_mut().zip(&self.column_scale).zip(&self.conditions.unknowns)
            {
                *value = if *condition == Condition::Free { -*value * scale / energy_scale } else { 0.0 };
            }
        }
        statistics.factorisations += 1;
        let tangent = self.work.tangent();
        let singular = |_| NewtonFailure::Singular(0);
        self.linear.factorise(tangent).map_err(singular)?;
        self.linear.solve_again(tangent, loads).map_err(singular)?;
        let mut fluid = vec![0.0; new.forces.len()];
        for (change, force) in loads.chunks_exact_mut(unknowns).zip(&mut new.forces) {
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
            for (change, force) in loads.chunks_exact_mut(unknowns).zip(&mut new.forces) {
                force.force = unit.follow(self.compliance, scale, force.force, change);
            }
        }
        body.fluid_force_sensitivity(x, loads, &mut fluid)?;
        for (force, fluid) in new.forces.iter_mut().zip(fluid) {
            (force.specimen, force.fluid) = (force.force, fluid);
        }
        let (old, flows) = (&self.stage_sensitivity, &self.flows);
        Ok(body.update_sensitivity(x, reach, loads, old, flows, &mut new.history)?)
    }
}
