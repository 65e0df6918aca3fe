//! One time step of the sample under the punch.

use super::boundary::Conditions;
use super::contact::{Contact, Slack, Surface, Touch, Trial};
use super::coupling;
use super::discretisation::Patience;
use super::profile::Profile;
use super::sample::Sample;
use super::sensitivity::Sensitivity;
use super::stage::{Drag, StageSystem};
use super::trend::Trend;
use crate::effect::EffectParameters;
use crate::element::field::Integrals;
use crate::element::sensitivity::HistorySensitivity;
use crate::element::{History, Inadmissible, Stage};
use crate::material::PointMaterial;
use crate::outputs::{Outputs, Statistics};
use crate::parameters::{MaterialParameters, Parameters, TimeScheme};
use crate::solver::linear::LinearSolver;
use crate::solver::newton::{self, NewtonFailure, Workspace};
use crate::solver::scheme::stages;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A pull below this fraction of the force scale opens no node.
const NEGLIGIBLE_PULL: f64 = 1e-7;
/// A node closer to the punch's face than this fraction of the punch's radius touches it.
const NEGLIGIBLE_GAP: f64 = 1e-8;
/// Dimensionless stiffness of the drag on the nodes at first, and its changes after a success and a failure.
const FIRST_DRAG: f64 = 1e-2;
const DRAG_FALL: f64 = 0.2;
const DRAG_RISE: f64 = 10.0;
/// Longest motion against drag, in steps: a shorter time step is cheaper than more of them, unless it was tried in vain.
const MAX_DRAGGED: usize = 12;
const MAX_DRAGGED_IN_THE_END: usize = 60;
/// A dimensionless residual from which something like a snap, not a far start, keeps Newton's method.
const NEAR: f64 = 1e-5;
/// A stage changes its nodes in contact at most as many times.
const MAX_CHANGES: usize = 16;

/// The sample at one time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Time (s).
    pub time: f64,
    /// Unknowns: displacements (m) and pressures (Pa).
    pub x: Vec<f64>,
    /// Their motion over the last stages.
    pub trend: Trend,
    /// History at the integration points.
    pub history: History,
    /// Which nodes are in contact with the punch.
    pub contact: Contact,
    /// Where the surface lies.
    pub touch: Touch,
    /// Results.
    pub outputs: Outputs,
    /// Changes with the material's parameters, where they are asked for.
    pub sensitivity: Option<Sensitivity>,
}

/// Advances states; holds the memory and factors of one instance.
pub struct Stepper {
    pub(super) sample: Arc<Sample>,
    pub(super) material: PointMaterial,
    /// What the material is made from anew at every stage, where its moduli drift.
    pub(super) drifting: Option<(MaterialParameters, EffectParameters)>,
    /// Stiffness of the shear layer under the punch (Pa/m), where there is one.
    shear_layer: Option<f64>,
    /// Compliance of the machine (m/N).
    pub(super) compliance: f64,
    pub(super) conditions: Conditions,
    pub(super) surface: Surface,
    scheme: TimeScheme,
    tolerance: f64,
    /// Stress scale (Pa) and length scale (m) that make the system dimensionless.
    stress_scale: f64,
    length_scale: f64,
    pub(super) column_scale: Vec<f64>,
    is_pressure: Vec<bool>,
    pub(super) linear: LinearSolver,
    pub(super) work: Workspace,
    pub(super) stage_history: History,
    /// Change of `stage_history` with the parameters; empty when no sensitivities are asked for.
    pub(super) stage_sensitivity: HistorySensitivity,
    sensitivities: bool,
    raw_residual: Vec<f64>,
    /// Sum of the tangent's rows under the punch (N per unit of the unknowns).
    pub(super) reaction_row: Vec<f64>,
    residual_norms: Vec<f64>,
}

impl Stepper {
    /// A stepper for a parameter set on a sample.
    pub fn new(parameters: &Parameters, sample: Arc<Sample>) -> Self {
        let (m, effect) = (&parameters.material, &parameters.effect);
        let stress_scale =
            m.equilibrium.shear_modulus() + m.branches.iter().map(|b| b.ogden.shear_modulus()).sum::<f64>();
        let length_scale = parameters.geometry.reach();
        let boundary = effect.slip.boundary(&parameters.boundary);
        let profile = Profile::new(&parameters.indenter, parameters.geometry.punch_radius);
        let is_pressure = sample.mesh.pressure_mask();
        let unit = |pressure: &bool| if *pressure { stress_scale } else { length_scale };
        let column_scale = is_pressure.iter().map(unit).collect();
        let unknowns = sample.mesh.unknowns();
        let sensitivities = parameters.solver.sensitivities;
        let material = PointMaterial::with_effects(m, effect, 0.0);
        let softens = material.softening.is_some();
        Self {
            material,
            drifting: effect.modulus_drift.is_active().then(|| (m.clone(), effect.clone())),
            shear_layer: effect.slip.stiffness(),
            compliance: effect.compliance.per_newton,
            conditions: Conditions::new(&sample.mesh, &boundary),
            surface: Surface::new(&sample.mesh, &sample.geometry, &boundary, profile, effect.adhesion),
            scheme: parameters.solver.time_scheme,
            tolerance: parameters.solver.newton_tolerance,
            stress_scale,
            length_scale,
            column_scale,
            is_pressure,
            linear: LinearSolver::new(sample.structure.clone(), parameters.solver.linear_solver),
            work: Workspace::new(unknowns, sample.map.pattern.rows.len()),
            stage_history: History::undeformed(sample.mesh.elements.len(), m.branches.len())
                .remembering(softens),
            stage_sensitivity: HistorySensitivity::default(),
            sensitivities,
            raw_residual: vec![0.0; unknowns],
            reaction_row: vec![0.0; unknowns],
            residual_norms: Vec::new(),
            sample,
        }
    }

    /// The undeformed sample.
    pub fn undeformed(&self, time: f64) -> State {
        let (unknowns, elements) = (self.sample.mesh.unknowns(), self.sample.mesh.elements.len());
        let (branches, nodes) = (self.material.branches(), self.surface.nodes().len());
        let (x, contact) = (vec![0.0; unknowns], self.surface.touched());
        let softens = self.material.softening.is_some();
        State {
            time,
            touch: self.surface.touch(&contact, &x),
            contact,
            x,
            trend: Trend::at_rest(unknowns),
            history: History::undeformed(elements, branches).remembering(softens),
            outputs: Outputs::default(),
            sensitivity: self
                .sensitivities
                .then(|| Sensitivity::undeformed(unknowns, elements, branches, nodes).remembering(softens)),
        }
    }

    /// Unit of energy (J) that makes the residual dimensionless.
    pub(super) fn energy_scale(&self) -> f64 {
        self.stress_scale * self.length_scale.powi(3)
    }

    /// A force that matters (N): the stress scale over the punch's area.
    pub fn force_scale(&self) -> f64 {
        self.stress_scale * self.length_scale * self.length_scale
    }

    /// Values of the dimensionless tangent where the last stage ended, in the order of the sample's pattern.
    pub fn tangent(&self) -> &[f64] {
        self.work.tangent()
    }

    /// Norms of the dimensionless residual in the iterations of the last stage.
    pub fn residual_norms(&self) -> &[f64] {
        &self.residual_norms
    }

    /// Whether a state has this stepper's numbers of unknowns and history tensors.
    pub fn fits(&self, state: &State) -> bool {
        state.x.len() == self.column_scale.len()
            && state.trend.unknowns() == state.x.len()
            && state.history.jacobian.len() == self.stage_history.jacobian.len()
            && state.history.cv_inverse.len() == self.stage_history.cv_inverse.len()
            && state.history.past_strain.len() == self.stage_history.past_strain.len()
            && self.surface.fits(&state.contact)
            && state.sensitivity.is_some() == self.sensitivities
    }

    /// The state `dt` later, the punch moving from `start` (m) at `velocity` (m/s).
    ///
    /// # Errors
    /// Why a stage has no solution.
    pub fn step(
        &mut self,
        old: &State,
        start: f64,
        velocity: f64,
        dt: f64,
        statistics: &mut Statistics,
    ) -> Result<State, NewtonFailure> {
        self.step_with(old, (start, velocity), dt, Patience::Little, statistics)
    }

    /// The same with some patience.
    ///
    /// # Errors
    /// Why a stage has no solution.
    pub fn step_with(
        &mut self,
        old: &State,
        (start, velocity): (f64, f64),
        dt: f64,
        patience: Patience,
        statistics: &mut Statistics,
    ) -> Result<State, NewtonFailure> {
        let mut new = old.clone();
        new.time = old.time + dt;
        self.stage_history.clone_from(&old.history);
        if let Some(sensitivity) = &old.sensitivity {
            self.stage_sensitivity.clone_from(&sensitivity.history);
        }
        let stages = stages(self.scheme);
        for (index, stage) in stages.iter().enumerate() {
            let reached = index.checked_sub(1).map_or(0.0, |k| stages[k].time);
            let ahead = (stage.time - reached) * dt;
            let length = stage.fraction * dt;
            let indentation = start + velocity * stage.time * dt;
            if let Some((material, effect)) = &self.drifting {
                self.material = PointMaterial::with_effects(material, effect, old.time + stage.time * dt);
            }
            let (from, touched) = (new.x.clone(), new.contact.clone());
            new.trend.extrapolate(&mut new.x, ahead);
            let mut solved = self.solve(&mut new, &from, length, indentation, patience, statistics);
            if solved.is_err() && new.x != from {
                // The extrapolation may have been the reason.
                new.x.clone_from(&from);
                new.contact.clone_from(&touched);
                solved = self.solve(&mut new, &from, length, indentation, patience, statistics);
            }
            let next = solved?;
            if new.contact.touches_as(&touched) {
                new.trend.note(&from, &new.x, ahead);
            } else {
                // What jumps with the contact does not go on.
                new.trend = Trend::at_rest(from.len());
            }
            let last = index + 1 == stages.len();
            let reaction = self.reaction();
            if last {
                self.faces(&mut new, length)?;
            }
            if let Some(sensitivity) = &mut new.sensitivity {
                self.differentiate(&new.x, &new.contact, length, stage.reach, sensitivity, statistics)?;
                std::mem::swap(&mut self.stage_sensitivity, &mut sensitivity.history);
            }
            self.differentiate_held(&mut new, &next, length, statistics)?;
            new.contact = next;
            let integrals = self.update(&mut new, length, stage.reach)?;
            std::mem::swap(&mut self.stage_history, &mut new.history);
            let o = &mut new.outputs;
            o.viscous_dissipation_rate = integrals.viscous_dissipation_rate;
            o.porous_dissipation_rate = integrals.porous_dissipation_rate;
            o.viscous_dissipation += stage.weight * dt * integrals.viscous_dissipation_rate;
            o.porous_dissipation += stage.weight * dt * integrals.porous_dissipation_rate;
            o.external_work += stage.weight * dt * velocity * reaction;
            if last {
                o.displacement = indentation;
                o.force = reaction;
                o.force_specimen = reaction;
                // The machine keeps its own part of the work.
                o.external_work -= coupling::machine_energy(self.compliance, reaction)
                    - coupling::machine_energy(self.compliance, old.outputs.force_specimen);
                o.force_solid = reaction - o.force_fluid;
                o.stored_energy = integrals.stored_energy;
                o.fluid_expelled = -integrals.volume_change;
            }
        }
        std::mem::swap(&mut self.stage_history, &mut new.history);
        if let Some(sensitivity) = &mut new.sensitivity {
            std::mem::swap(&mut self.stage_sensitivity, &mut sensitivity.history);
        }
        new.touch = self.surface.touch(&new.contact, &new.x);
        Ok(new)
    }

    /// Solves one stage from `stage_history`, finds which nodes are in contact and leaves the nodal forces in
    /// `raw_residual`. Returns the contact from the end of the stage on.
    fn solve(
        &mut self,
        new: &mut State,
        from: &[f64],
        dt: f64,
        indentation: f64,
        patience: Patience,
        statistics: &mut Statistics,
    ) -> Result<Contact, NewtonFailure> {
        let slack =
            Slack { force: NEGLIGIBLE_PULL * self.force_scale(), length: NEGLIGIBLE_GAP * self.length_scale };
        let mut past = self.surface.no_past();
        for _ in 0..=MAX_CHANGES {
            self.conditions.apply(&self.surface, &new.contact);
            self.find(&mut new.x, dt, indentation, patience, statistics)?;
            let (x, forces, mut contact) = (&new.x, &self.raw_residual, new.contact.clone());
            let indentation = indentation - self.compliance * self.reaction();
            let trial = Trial { x, from, forces, indentation, slack };
            if !self.surface.change(&mut contact, &trial, &mut past) {
                return Ok(contact);
            }
            self.differentiate_held(new, &contact, dt, statistics)?;
            new.contact = contact;
        }
        Err(NewtonFailure::Contact)
    }

    /// Solves one stage for the nodes that are in contact. Where Newton's method fails - beside a peeling edge the
    /// folded surface may snap from one equilibrium to another - drag on the nodes leads it there.
    fn find(
        &mut self,
        x: &mut Vec<f64>,
        dt: f64,
        indentation: f64,
        patience: Patience,
        statistics: &mut Statistics,
    ) -> Result<(), NewtonFailure> {
        let start = x.clone();
        let Err(failure) = self.equilibrate(x, dt, indentation, None, statistics) else { return Ok(()) };
        // Under a fully closed face a far start fails for other reasons, which a shorter step removes if anything does.
        let near = matches!(failure, NewtonFailure::NotConverged { residual, .. } if residual < NEAR);
        let closed =
            self.conditions.slides.is_empty() && self.conditions.punch.len() == self.surface.nodes().len();
        if closed && !near && patience == Patience::Little {
            return Err(failure);
        }
        x.clone_from(&start);
        let (mut reached, mut drag) = (start, FIRST_DRAG);
        let is_pressure = self.is_pressure.clone();
        let longest = match patience {
            Patience::Little => MAX_DRAGGED,
            Patience::Much => MAX_DRAGGED_IN_THE_END,
        };
        for _ in 0..longest {
            let dragged = Some(Drag { from: &reached, stiffness: drag, is_pressure: &is_pressure });
            match self.equilibrate(x, dt, indentation, dragged, statistics) {
                Ok(()) => {
                    reached.clone_from(x);
                    drag *= DRAG_FALL;
                    if self.equilibrate(x, dt, indentation, None, statistics).is_ok() {
                        return Ok(());
                    }
                }
                Err(_) => drag *= DRAG_RISE,
            }
            x.clone_from(&reached);
        }
        Err(failure)
    }

    /// Newton's method on one stage.
    fn equilibrate(
        &mut self,
        x: &mut [f64],
        dt: f64,
        indentation: f64,
        drag: Option<Drag<'_>>,
        statistics: &mut Statistics,
    ) -> Result<(), NewtonFailure> {
        let energy_scale = self.energy_scale();
        let mut system = StageSystem {
            body: self.sample.body(&self.material),
            conditions: &self.conditions,
            column_scale: &self.column_scale,
            energy_scale,
            history: &self.stage_history,
            dt,
            indentation,
            shear_layer: self.shear_layer,
            compliance: self.compliance,
            profile: self.surface.profile(),
            drag,
            raw_residual: &mut self.raw_residual,
            reaction_row: &mut self.reaction_row,
        };
        self.residual_norms =
            newton::solve(&mut system, &mut self.linear, &mut self.work, x, self.tolerance, statistics)?;
        Ok(())
    }

    /// Force of the punch on the sample where the last stage ended (N).
    fn reaction(&self) -> f64 {
        self.conditions.reaction(&self.raw_residual)
    }

    fn faces(&self, new: &mut State, dt: f64) -> Result<(), NewtonFailure> {
        let stage = Stage { x: &new.x, old: &self.stage_history, dt };
        let closed = self.surface.closed_points(&new.contact);
        let (fluid, traction) = self.sample.body(&self.material).face_forces(&stage, &closed)?;
        new.outputs.force_fluid = fluid;
        new.outputs.force_traction = traction;
        Ok(())
    }

    fn update(&self, new: &mut State, dt: f64, reach: f64) -> Result<Integrals, NewtonFailure> {
        let stage = Stage { x: &new.x, old: &self.stage_history, dt };
        Ok(self.sample.body(&self.material).update(&stage, reach, &mut new.history)?)
    }
}

impl From<Inadmissible> for NewtonFailure {
    fn from(failed: Inadmissible) -> Self {
        Self::Inadmissible(failed.element)
    }
}
