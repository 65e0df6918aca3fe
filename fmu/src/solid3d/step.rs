//! One implicit stage of the quarter cylinder under the punch.

use super::assembly::{SolidBody, undeformed};
use super::boundary::Conditions;
use super::field::QUARTERS;
use super::linear::FrozenSolver;
use super::point::SolidMaterial;
use super::sample::SolidSample;
use crate::contact::conditions::Condition;
use crate::contact::status::Contact;
use crate::contact::surface::Touch;
use crate::element::{History, Stage};
use crate::outputs::{Outputs, Statistics};
use crate::parameters::Parameters;
use crate::solver::linear::Singular;
use crate::solver::newton::{self, Aim, NewtonFailure, System, Workspace};
use crate::specimen::extrapolation::Extrapolation;
use crate::specimen::step::{Found, Task};
use crate::specimen::{Constants, Discretisation, State};
use std::sync::Arc;

/// Loosest reduction of a linear residual: a Newton correction need be no better than that far from the solution.
const LOOSEST: f64 = 1e-2;

/// Advances states; holds the memory and factors of one instance.
pub struct SolidStepper {
    sample: Arc<SolidSample>,
    material: SolidMaterial,
    conditions: Conditions,
    fixed: Vec<bool>,
    tolerance: f64,
    /// Stress scale (Pa) and length scale (m) that make the system dimensionless.
    stress_scale: f64,
    length_scale: f64,
    column_scale: Vec<f64>,
    linear: FrozenSolver,
    work: Workspace,
    raw_residual: Vec<f64>,
    residual_norms: Vec<f64>,
    constants: Constants,
}

impl SolidStepper {
    /// A stepper for a parameter set on a sample.
    pub fn new(parameters: &Parameters, sample: Arc<SolidSample>) -> Self {
        let m = &parameters.material;
        let stress_scale = m.instantaneous_shear_modulus();
        let length_scale = parameters.geometry.punch_radius;
        let scale = |pressure| if pressure { stress_scale } else { length_scale };
        let conditions = Conditions::new(&sample.mesh, &parameters.boundary);
        let unknowns = sample.mesh.unknowns();
        let mut stepper = Self {
            material: SolidMaterial::new(m),
            fixed: conditions.unknowns.iter().map(|c| *c != Condition::Free).collect(),
            conditions,
            tolerance: parameters.solver.newton_tolerance,
            stress_scale,
            length_scale,
            column_scale: sample.mesh.pressure_mask().into_iter().map(scale).collect(),
            linear: FrozenSolver::new(sample.symbolic.clone()),
            work: Workspace::new(unknowns, sample.map.pattern.rows.len()),
            raw_residual: vec![0.0; unknowns],
            residual_norms: Vec::new(),
            constants: Constants::new(
                (stress_scale, length_scale),
                false,
                parameters.solver.time_scheme,
                0.0,
            ),
            sample,
        };
        stepper.constants.lengths = stepper.undeformed(0.0).lengths();
        stepper
    }

    /// Norms of the dimensionless residual in the iterations of the last stage.
    pub fn residual_norms(&self) -> &[f64] {
        &self.residual_norms
    }

    /// GMRES iterations since the start.
    pub fn linear_iterations(&self) -> u64 {
        self.linear.iterations()
    }

    /// Newton's method on one stage; leaves the nodal forces in `raw_residual`.
    fn equilibrate(
        &mut self,
        x: &mut [f64],
        task: &Task<'_>,
        statistics: &mut Statistics,
    ) -> Result<(), NewtonFailure> {
        let mut system = StageSystem {
            body: self.sample.body(&self.material),
            conditions: &self.conditions,
            column_scale: &self.column_scale,
            energy_scale: self.stress_scale * self.length_scale.powi(3),
            history: task.start.history,
            dt: task.length,
            displacement: task.displacement,
            raw_residual: &mut self.raw_residual,
            fixed: &self.fixed,
            linear: &mut self.linear,
            statistics,
        };
        self.residual_norms = newton::solve(&mut system, &mut self.work, x, self.tolerance)?;
        Ok(())
    }
}

/// One implicit stage as a dimensionless system of equations.
struct StageSystem<'a> {
    body: SolidBody<'a>,
    conditions: &'a Conditions,
    column_scale: &'a [f64],
    energy_scale: f64,
    history: &'a History,
    dt: f64,
    displacement: f64,
    raw_residual: &'a mut [f64],
    fixed: &'a [bool],
    linear: &'a mut FrozenSolver,
    statistics: &'a mut Statistics,
}

impl System for StageSystem<'_> {
    fn evaluate(
        &mut self,
        x: &[f64],
        residual: &mut [f64],
        mut values: Option<&mut [f64]>,
    ) -> Result<f64, usize> {
        let stage = Stage { x, old: self.history, dt: self.dt };
        self.body.assemble(stage, residual, values.as_deref_mut())?;
        let map = self.body.map;
        self.raw_residual.copy_from_slice(residual);
        // Scale of every row; 0 where the row is replaced by the identity's.
        let row_scale: Vec<f64> = self
            .column_scale
            .iter()
            .zip(&self.conditions.unknowns)
            .map(|(scale, c)| if *c == Condition::Free { scale / self.energy_scale } else { 0.0 })
            .collect();
        if let Some(values) = values {
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
                Condition::Punch => *r = (x[unknown] + self.displacement) / scale,
            }
        }
        Ok(square.sqrt())
    }

    fn correct(&mut self, values: &[f64], correction: &mut [f64], aim: Aim) -> Result<(), Singular> {
        // The quadratic remainder is about ten times the squared norm: what is smaller need not be solved.
        let enough = 0.2 * aim.tolerance / aim.norm.max(f64::MIN_POSITIVE);
        let reduction = (3.0 * aim.norm).clamp(1e-12, LOOSEST).max(enough.min(LOOSEST));
        let pattern = &self.body.map.pattern;
        self.linear.solve(pattern, values, self.fixed, correction, reduction, self.statistics)
    }

    fn scale(&self) -> &[f64] {
        self.column_scale
    }

    fn statistics(&mut self) -> &mut Statistics {
        self.statistics
    }
}

impl Discretisation for SolidStepper {
    fn undeformed(&self, time: f64) -> State {
        let unknowns = self.sample.mesh.unknowns();
        let (x, contact) = (vec![0.0; unknowns], Contact::default());
        State {
            time,
            touch: self.touch(&contact, &x),
            x,
            trend: Extrapolation::at_rest(unknowns),
            history: undeformed(self.sample.mesh.cells.len(), self.material.branches()),
            contact,
            outputs: Outputs::default(),
            sensitivity: None,
        }
    }

    fn constants(&self) -> &Constants {
        &self.constants
    }

    /// The punch's face stays where it is put.
    fn touch(&self, _: &Contact, _: &[f64]) -> Touch {
        Touch { in_contact: true, ..Touch::default() }
    }

    fn solve(&mut self, task: &Task<'_>, statistics: &mut Statistics) -> Result<Found, NewtonFailure> {
        let mut x = task.guess.to_vec();
        self.equilibrate(&mut x, task, statistics)?;
        let punch = self.conditions.punch.iter();
        let reaction = -QUARTERS * punch.map(|&u| self.raw_residual[u]).sum::<f64>();
        let stage = Stage { x: &x, old: task.start.history, dt: task.length };
        let body = self.sample.body(&self.material);
        let face = task.is_last.then(|| body.face_forces(stage)).transpose()?;
        let mut history = task.start.history.clone();
        let integrals = body.update(stage, task.reach, &mut history)?;
        Ok(Found {
            x,
            contact: Contact::default(),
            next: Contact::default(),
            decisions: Vec::new(),
            reaction,
            face,
            integrals,
            history,
            sensitivity: None,
        })
    }
}
