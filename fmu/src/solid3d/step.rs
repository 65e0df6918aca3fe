//! One time step of the quarter cylinder under the punch: the stages of [`crate::solver::scheme`].

use super::assembly::{History, assemble};
use super::boundary::Conditions;
use super::field::{self, QUARTERS};
use super::linear::FrozenSolver;
use super::newton::{self, Workspace};
use super::point::SolidMaterial;
use super::sample::SolidSample;
use crate::indentation::boundary::Condition;
use crate::indentation::contact::Touch;
use crate::indentation::discretisation::{Discretisation, Patience, Reached};
use crate::indentation::trend::Trend;
use crate::outputs::{ForceSensitivity, Outputs, Statistics};
use crate::parameters::{Parameters, TimeScheme};
use crate::solver::newton::{NewtonFailure, System};
use crate::solver::scheme::stages;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The sample at one time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SolidState {
    /// Time (s).
    pub time: f64,
    /// Unknowns: displacements (m) and pressures (Pa).
    pub x: Vec<f64>,
    /// Their motion over the last stages.
    pub trend: Trend,
    /// History at the integration points.
    pub history: History,
    /// Results for the whole sample.
    pub outputs: Outputs,
}

/// Advances states; holds the memory and factors of one instance.
pub struct SolidStepper {
    sample: Arc<SolidSample>,
    material: SolidMaterial,
    conditions: Conditions,
    fixed: Vec<bool>,
    scheme: TimeScheme,
    tolerance: f64,
    /// Stress scale (Pa) and length scale (m) that make the system dimensionless.
    stress_scale: f64,
    length_scale: f64,
    column_scale: Vec<f64>,
    linear: FrozenSolver,
    work: Workspace,
    stage_history: History,
    raw_residual: Vec<f64>,
    residual_norms: Vec<f64>,
}

impl SolidStepper {
    /// A stepper for a parameter set on a sample.
    pub fn new(parameters: &Parameters, sample: Arc<SolidSample>) -> Self {
        let m = &parameters.material;
        let stress_scale =
            m.equilibrium.shear_modulus() + m.branches.iter().map(|b| b.ogden.shear_modulus()).sum::<f64>();
        let length_scale = parameters.geometry.punch_radius;
        let scale = |pressure| if pressure { stress_scale } else { length_scale };
        let conditions = Conditions::new(&sample.mesh, &parameters.boundary);
        let unknowns = sample.mesh.unknowns();
        Self {
            material: SolidMaterial::new(m),
            fixed: conditions.unknowns.iter().map(|c| *c != Condition::Free).collect(),
            conditions,
            scheme: parameters.solver.time_scheme,
            tolerance: parameters.solver.newton_tolerance,
            stress_scale,
            length_scale,
            column_scale: sample.mesh.pressure_mask().into_iter().map(scale).collect(),
            linear: FrozenSolver::new(sample.symbolic.clone()),
            work: Workspace::new(unknowns, sample.map.pattern.rows.len()),
            stage_history: History::undeformed(sample.mesh.cells.len(), m.branches.len()),
            raw_residual: vec![0.0; unknowns],
            residual_norms: Vec::new(),
            sample,
        }
    }

    /// The undeformed sample.
    pub fn undeformed(&self, time: f64) -> SolidState {
        let unknowns = self.sample.mesh.unknowns();
        SolidState {
            time,
            x: vec![0.0; unknowns],
            trend: Trend::at_rest(unknowns),
            history: History::undeformed(self.sample.mesh.cells.len(), self.material.branches()),
            outputs: Outputs::default(),
        }
    }

    /// A force that matters (N): the stress scale over the punch's area.
    pub fn force_scale(&self) -> f64 {
        self.stress_scale * self.length_scale * self.length_scale
    }

    /// Norms of the dimensionless residual in the iterations of the last stage.
    pub fn residual_norms(&self) -> &[f64] {
        &self.residual_norms
    }

    /// GMRES iterations since the start.
    pub fn linear_iterations(&self) -> u64 {
        self.linear.iterations()
    }

    /// Whether a state has this stepper's numbers of unknowns and history tensors.
    pub fn fits(&self, state: &SolidState) -> bool {
        state.x.len() == self.column_scale.len()
            && state.trend.unknowns() == state.x.len()
            && state.history.jacobian.len() == self.stage_history.jacobian.len()
            && state.history.cv_inverse.len() == self.stage_history.cv_inverse.len()
    }

    /// The state `dt` later, the punch moving from `start` (m) at `velocity` (m/s).
    ///
    /// # Errors
    /// Why a stage has no solution.
    pub fn step(
        &mut self,
        old: &SolidState,
        start: f64,
        velocity: f64,
        dt: f64,
        statistics: &mut Statistics,
    ) -> Result<SolidState, NewtonFailure> {
        let mut new = old.clone();
        new.time = old.time + dt;
        self.stage_history.clone_from(&old.history);
        let stages = stages(self.scheme);
        for (index, stage) in stages.iter().enumerate() {
            let reached = index.checked_sub(1).map_or(0.0, |k| stages[k].time);
            let ahead = (stage.time - reached) * dt;
            let length = stage.fraction * dt;
            let indentation = start + velocity * stage.time * dt;
            let from = new.x.clone();
            new.trend.extrapolate(&mut new.x, ahead);
            let mut solved = self.solve(&mut new.x, length, indentation, statistics);
            if solved.is_err() && new.x != from {
                // The extrapolation may have been the reason.
                new.x.clone_from(&from);
                solved = self.solve(&mut new.x, length, indentation, statistics);
            }
            solved?;
            new.trend.note(&from, &new.x, ahead);
            let last = index + 1 == stages.len();
            let punch = self.conditions.punch.iter();
            let reaction = -QUARTERS * punch.map(|&u| self.raw_residual[u]).sum::<f64>();
            let SolidSample { geometry, map, .. } = &*self.sample;
            let (material, history) = (&self.material, &self.stage_history);
            let o = &mut new.outputs;
            if last {
                (o.force_fluid, o.force_traction) =
                    field::face_forces(geometry, map, material, &new.x, history, length)?;
            }
            let integrals = field::update(
                geometry,
                map,
                material,
                &new.x,
                history,
                length,
                stage.reach,
                &mut new.history,
            )?;
            std::mem::swap(&mut self.stage_history, &mut new.history);
            o.viscous_dissipation_rate = integrals.viscous_dissipation_rate;
            o.porous_dissipation_rate = integrals.porous_dissipation_rate;
            o.viscous_dissipation += stage.weight * dt * integrals.viscous_dissipation_rate;
            o.porous_dissipation += stage.weight * dt * integrals.porous_dissipation_rate;
            o.external_work += stage.weight * dt * velocity * reaction;
            if last {
                o.displacement = indentation;
                o.force = reaction;
                o.force_specimen = reaction;
                o.force_solid = reaction - o.force_fluid;
                o.stored_energy = integrals.stored_energy;
                o.fluid_expelled = -integrals.volume_change;
            }
        }
        std::mem::swap(&mut self.stage_history, &mut new.history);
        Ok(new)
    }

    /// Solves one stage from `stage_history` and leaves the nodal forces in `raw_residual`.
    fn solve(
        &mut self,
        x: &mut [f64],
        dt: f64,
        indentation: f64,
        statistics: &mut Statistics,
    ) -> Result<(), NewtonFailure> {
        let mut system = StageSystem {
            sample: &self.sample,
            material: &self.material,
            conditions: &self.conditions,
            column_scale: &self.column_scale,
            energy_scale: self.stress_scale * self.length_scale.powi(3),
            history: &self.stage_history,
            dt,
            indentation,
            raw_residual: &mut self.raw_residual,
        };
        self.residual_norms = newton::solve(
            &mut system,
            &mut self.linear,
            &self.sample.map.pattern,
            &self.fixed,
            &mut self.work,
            x,
            self.tolerance,
            statistics,
        )?;
        Ok(())
    }
}

/// One implicit stage as a dimensionless system of equations.
struct StageSystem<'a> {
    sample: &'a SolidSample,
    material: &'a SolidMaterial,
    conditions: &'a Conditions,
    column_scale: &'a [f64],
    energy_scale: f64,
    history: &'a History,
    dt: f64,
    indentation: f64,
    raw_residual: &'a mut [f64],
}

impl System for StageSystem<'_> {
    fn evaluate(&mut self, x: &[f64], residual: &mut [f64], values: &mut [f64]) -> Result<f64, usize> {
        let SolidSample { geometry, map, .. } = self.sample;
        assemble(geometry, map, self.material, x, self.history, self.dt, residual, values)
            .map_err(|failed| failed.element)?;
        self.raw_residual.copy_from_slice(residual);
        // Scale of every row; 0 where the row is replaced by the identity's.
        let row_scale: Vec<f64> = self
            .column_scale
            .iter()
            .zip(&self.conditions.unknowns)
            .map(|(scale, c)| if *c == Condition::Free { scale / self.energy_scale } else { 0.0 })
            .collect();
        for column in 0..x.len() {
            let (first, rows) = map.pattern.column(column);
            let scale = self.column_scale[column];
            for (value, &row) in values[first..first + rows.len()].iter_mut().zip(rows) {
                *value *= scale * row_scale[row as usize];
            }
            if self.conditions.unknowns[column] != Condition::Free {
                values[map.pattern.position(column as u32, column as u32) as usize] = 1.0;
            }
        }
        let mut square = 0.0;
        for (unknown, r) in residual.iter_mut().enumerate() {
            let scale = self.column_scale[unknown];
            match self.conditions.unknowns[unknown] {
                Condition::Free => {
                    *r *= row_scale[unknown];
                    square += *r * *r;
                }
                Condition::Fixed => *r = x[unknown] / scale,
                Condition::Punch => *r = (x[unknown] + self.indentation) / scale,
            }
        }
        Ok(square.sqrt())
    }

    fn scale(&self) -> &[f64] {
        self.column_scale
    }
}

impl Discretisation for SolidStepper {
    type State = SolidState;

    fn undeformed(&self, time: f64) -> SolidState {
        self.undeformed(time)
    }

    fn fits(&self, state: &SolidState) -> bool {
        self.fits(state)
    }

    fn force_scale(&self) -> f64 {
        self.force_scale()
    }

    fn separates(&self) -> bool {
        false
    }

    fn step(
        &mut self,
        old: &SolidState,
        start: f64,
        velocity: f64,
        dt: f64,
        _: Patience,
        statistics: &mut Statistics,
    ) -> Result<SolidState, NewtonFailure> {
        self.step(old, start, velocity, dt, statistics)
    }
}

impl Reached for SolidState {
    fn time(&self) -> f64 {
        self.time
    }

    fn outputs(&self) -> Outputs {
        self.outputs
    }

    /// Not computed in three dimensions.
    fn sensitivities(&self) -> Vec<ForceSensitivity> {
        Vec::new()
    }

    /// The punch's face stays where it is put.
    fn touch(&self) -> Touch {
        Touch { in_contact: true, ..Touch::default() }
    }

    fn touches_as(&self, _other: &Self) -> bool {
        true
    }
}
