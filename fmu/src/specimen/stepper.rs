//! The axisymmetric specimen of one instance: what its stages are solved with.

use super::derivatives::Sensitivity;
use super::sample::Sample;
use super::state::State;
use super::step::{Discretisation, Found, Start, Task};
use super::trend::Trend;
use crate::effect::EffectParameters;
use crate::element::undeformed;
use crate::indentation::boundary::Conditions;
use crate::indentation::contact::{Contact, Surface, Touch};
use crate::indentation::profile::Profile;
use crate::material::PointMaterial;
use crate::outputs::{Outputs, Statistics};
use crate::parameters::{MaterialParameters, Parameters, TimeScheme};
use crate::solver::linear::LinearSolver;
use crate::solver::newton::{NewtonFailure, Workspace};
use std::sync::Arc;

/// Solves the stages of an axisymmetric specimen; holds the memory and factors of one instance.
pub struct Stepper {
    pub(super) sample: Arc<Sample>,
    pub(super) material: PointMaterial,
    /// What the material is made from anew at every stage, where its moduli drift.
    pub(super) drifting: Option<(MaterialParameters, EffectParameters)>,
    /// Stiffness of the shear layer under the punch (Pa/m), where there is one.
    pub(super) shear_layer: Option<f64>,
    /// Compliance of the machine (m/N).
    pub(super) compliance: f64,
    pub(super) conditions: Conditions,
    pub(super) surface: Surface,
    scheme: TimeScheme,
    /// Tolerance of Newton's method [-].
    pub(super) tolerance: f64,
    /// Stress scale (Pa) and length scale (m) that make the system dimensionless.
    stress_scale: f64,
    pub(super) length_scale: f64,
    pub(super) column_scale: Vec<f64>,
    pub(super) is_pressure: Vec<bool>,
    pub(super) linear: LinearSolver,
    pub(super) work: Workspace,
    sensitivities: bool,
    /// Nodal forces of the last solution, without boundary conditions (N).
    pub(super) raw_residual: Vec<f64>,
    /// Sum of the tangent's rows under the punch (N per unit of the unknowns).
    pub(super) reaction_row: Vec<f64>,
    pub(super) residual_norms: Vec<f64>,
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
        Self {
            material: PointMaterial::with_effects(m, effect, 0.0),
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
            sensitivities: parameters.solver.sensitivities,
            raw_residual: vec![0.0; unknowns],
            reaction_row: vec![0.0; unknowns],
            residual_norms: Vec::new(),
            sample,
        }
    }

    /// Unit of energy (J) that makes the residual dimensionless.
    pub(super) fn energy_scale(&self) -> f64 {
        self.stress_scale * self.length_scale.powi(3)
    }

    /// Values of the dimensionless tangent where the last stage ended, in the order of the sample's pattern.
    pub fn tangent(&self) -> &[f64] {
        self.work.tangent()
    }

    /// Norms of the dimensionless residual in the iterations of the last stage.
    pub fn residual_norms(&self) -> &[f64] {
        &self.residual_norms
    }

    /// The surface under the punch.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }
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
            trend: Trend::at_rest(unknowns),
            history: undeformed(elements, branches).remembering(softens),
            outputs: Outputs::default(),
            sensitivity: self
                .sensitivities
                .then(|| Sensitivity::undeformed(elements, branches, nodes).remembering(softens)),
        }
    }

    fn fits(&self, state: &State) -> bool {
        let own = self.undeformed(0.0);
        state.x.len() == own.x.len()
            && state.trend.unknowns() == own.x.len()
            && state.history.fits(&own.history)
            && self.surface.fits(&state.contact)
            && match (&state.sensitivity, &own.sensitivity) {
                (Some(sensitivity), Some(own)) => sensitivity.fits(own),
                (None, None) => true,
                _ => false,
            }
    }

    fn force_scale(&self) -> f64 {
        self.stress_scale * self.length_scale * self.length_scale
    }

    fn separates(&self) -> bool {
        true
    }

    fn scheme(&self) -> TimeScheme {
        self.scheme
    }

    fn compliance(&self) -> f64 {
        self.compliance
    }

    fn touch(&self, contact: &Contact, x: &[f64]) -> Touch {
        self.surface.touch(contact, x)
    }

    fn solve(
        &mut self,
        start: &Start<'_>,
        guess: &[f64],
        task: &Task<'_>,
        statistics: &mut Statistics,
    ) -> Result<Found, NewtonFailure> {
        if let Some((material, effect)) = &self.drifting {
            self.material = PointMaterial::with_effects(material, effect, task.time);
        }
        self.solve_stage(start, guess, task, statistics)
    }
}
