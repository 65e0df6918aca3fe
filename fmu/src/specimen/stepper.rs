//! The axisymmetric specimen of one instance: what its stages are solved with.

use super::sample::Sample;
use super::setup::Setup;
use super::step::{Constants, Discretisation};
use crate::contact::parameters::BoundaryParameters;
use crate::contact::{Conditions, Profile, Surface};
use crate::law::PointMaterial;
use crate::law::extensions::Extensions;
use crate::law::parameters::MaterialParameters;
use crate::solver::linear::LinearSolver;
use crate::solver::newton::Workspace;
use std::sync::Arc;

/// Solves the stages of an axisymmetric specimen; holds the memory and factors of one instance.
pub struct Stepper {
    pub(super) sample: Arc<Sample>,
    pub(super) material: PointMaterial,
    /// What the material is made from anew at every stage, where its moduli drift or could do so.
    pub(super) drifting: Option<(MaterialParameters, Extensions)>,
    /// Stiffness of the shear layer under the punch (Pa/m), where there is one.
    pub(super) shear_layer: Option<f64>,
    pub(super) conditions: Conditions,
    pub(super) surface: Surface,
    /// Tolerance of Newton's method [-].
    pub(super) tolerance: f64,
    /// Stress scale (Pa) and length scale (m) that make the system dimensionless.
    pub(super) stress_scale: f64,
    pub(super) length_scale: f64,
    pub(super) column_scale: Vec<f64>,
    pub(super) is_pressure: Vec<bool>,
    pub(super) linear: LinearSolver,
    pub(super) work: Workspace,
    /// How many parameters the force is differentiated by.
    pub(super) parameters: usize,
    /// Nodal forces of the last solution, without boundary conditions (N).
    pub(super) raw_residual: Vec<f64>,
    /// Sum of the tangent's rows under the punch (N per unit of the unknowns).
    pub(super) reaction_row: Vec<f64>,
    pub(super) residual_norms: Vec<f64>,
    pub(super) constants: Constants,
}

impl Stepper {
    /// A stepper for a set-up on a sample.
    pub fn new(setup: &Setup, sample: Arc<Sample>) -> Self {
        let m = &setup.material;
        let stress_scale = m.instantaneous_shear_modulus();
        let length_scale = setup.geometry.reach();
        let bonded_punch = setup.boundary.bonded_punch && setup.shear_layer.is_none();
        let boundary = BoundaryParameters { bonded_punch, ..setup.boundary.clone() };
        let profile = Profile::new(&setup.indenter, setup.geometry.punch_radius);
        let is_pressure = sample.mesh.pressure_mask();
        let unit = |pressure: &bool| if *pressure { stress_scale } else { length_scale };
        let column_scale = is_pressure.iter().map(unit).collect();
        let unknowns = sample.mesh.unknowns();
        let mut stepper = Self {
            material: PointMaterial::extended(m, &setup.extensions, 0.0),
            drifting: (setup.extensions.growth_rate != 0.0 || setup.solver.effect_sensitivities)
                .then(|| (m.clone(), setup.extensions)),
            shear_layer: setup.shear_layer,
            conditions: Conditions::new(&sample.mesh, &boundary),
            surface: Surface::new(&sample.mesh, &sample.geometry, &boundary, profile, setup.adhesion),
            tolerance: setup.solver.newton_tolerance,
            stress_scale,
            length_scale,
            column_scale,
            is_pressure,
            linear: LinearSolver::new(sample.structure.clone(), setup.solver.linear_solver),
            work: Workspace::new(unknowns, sample.map.pattern.rows.len()),
            parameters: setup.solver.differentiated(m.branches.len()),
            raw_residual: vec![0.0; unknowns],
            reaction_row: vec![0.0; unknowns],
            residual_norms: Vec::new(),
            constants: Constants::new(
                (stress_scale, length_scale),
                true,
                setup.solver.time_scheme,
                setup.compliance,
            ),
            sample,
        };
        stepper.constants.lengths = stepper.undeformed(0.0).lengths();
        stepper
    }

    /// Unit of energy (J) that makes the residual dimensionless.
    pub(super) fn energy_scale(&self) -> f64 {
        self.stress_scale * self.length_scale.powi(3)
    }

    /// Values of the dimensionless tangent that was formed last, in the order of the sample's pattern.
    pub fn tangent(&self) -> &[f64] {
        self.work.tangent()
    }

    /// Norms of the dimensionless residual in the iterations of the last stage.
    pub fn residual_norms(&self) -> &[f64] {
        &self.residual_norms
    }

    /// The discretised sample.
    pub fn sample(&self) -> &Sample {
        &self.sample
    }

    /// The material at a time since the test's start (s).
    pub fn material_at(&self, time: f64) -> PointMaterial {
        match &self.drifting {
            Some((material, extensions)) => PointMaterial::extended(material, extensions, time),
            None => self.material.clone(),
        }
    }

    /// The surface under the punch.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }
}
