//! One implicit stage as a system of equations for Newton's method.

use crate::contact::conditions::{Condition, Conditions, Guide};
use crate::contact::profile::Profile;
use crate::element::{Body, History, Stage};
use crate::machine::UnitMotion;
use crate::outputs::Statistics;
use crate::solver::linear::{LinearSolver, Singular};
use crate::solver::newton::{Aim, System};

/// Dimensionless springs between the nodes and where they were: one long step of an overdamped motion.
#[derive(Clone, Copy)]
pub(super) struct Drag<'a> {
    /// Where they were.
    pub from: &'a [f64],
    /// Stiffness.
    pub stiffness: f64,
    /// Which unknowns are pressures, without drag.
    pub is_pressure: &'a [bool],
}

/// One implicit stage as a dimensionless system of equations.
pub(super) struct StageSystem<'a> {
    pub body: Body<'a>,
    pub conditions: &'a Conditions,
    pub column_scale: &'a [f64],
    pub energy_scale: f64,
    pub history: &'a History,
    pub dt: f64,
    pub displacement: f64,
    pub shear_layer: Option<f64>,
    pub compliance: f64,
    pub profile: &'a Profile,
    pub drag: Option<Drag<'a>>,
    pub raw_residual: &'a mut [f64],
    pub reaction_row: &'a mut [f64],
    pub linear: &'a mut LinearSolver,
    pub statistics: &'a mut Statistics,
}

impl StageSystem<'_> {
    /// Scales the tangent and puts the conditions' rows into it; `residual` are the nodal forces less the adhesive pulls.
    fn constrain(&mut self, guides: &[(usize, Guide)], residual: &[f64], values: &mut [f64]) {
        let pattern = &self.body.map.pattern;
        for (radial, guide) in guides {
            // The pattern is symmetric: these are the columns that have an entry in the row.
            for &column in pattern.column(*radial).1 {
                // The axial unknown of a node follows its radial one.
                let k = pattern.position(*radial as u32, column) as usize;
                values[k] += guide.ratio * values[k + 1];
                if *radial == column as usize {
                    values[k] += guide.ratio_slope * residual[radial + 1];
                }
            }
        }
        // Factor of every row, 0 where the unknown is held, and whether it is a part of the reaction.
        let part = |(scale, condition): (&f64, &Condition)| match condition {
            Condition::Free => (*scale, false),
            Condition::Fixed => (0.0, false),
            Condition::Punch => (0.0, true),
        };
        let parts: Vec<(f64, bool)> =
            self.column_scale.iter().zip(&self.conditions.unknowns).map(part).collect();
        for column in 0..self.column_scale.len() {
            let (first, rows) = pattern.column(column);
            let scale = self.column_scale[column] / self.energy_scale;
            let mut reaction = 0.0;
            let values = &mut values[first..first + rows.len()];
            for (value, &row) in values.iter_mut().zip(rows) {
                let (factor, is_pushed) = parts[row as usize];
                if is_pushed {
                    reaction += *value;
                }
                *value *= scale * factor;
            }
            if self.conditions.unknowns[column] != Condition::Free {
                values[rows.partition_point(|&row| (row as usize) < column)] = 1.0;
            }
            self.reaction_row[column] = reaction;
        }
        for (radial, guide) in guides {
            // Where the node slides, the face's height changes with its slope.
            values[pattern.position(*radial as u32 + 1, *radial as u32) as usize] -= guide.face.slope;
        }
    }

    /// Solves for a correction with the factors that there are; where the machine gives way, the punch moves with it.
    fn solve(
        &mut self,
        correction: &mut [f64],
        by: impl Fn(&mut LinearSolver, &mut [f64]) -> Result<(), Singular>,
    ) -> Result<(), Singular> {
        let Self { conditions, column_scale, compliance, linear, reaction_row, .. } = self;
        by(linear, correction)?;
        if *compliance != 0.0 {
            let unit = UnitMotion::new(conditions, column_scale, reaction_row, |rhs| by(linear, rhs))?;
            unit.couple(*compliance, column_scale, reaction_row, correction);
        }
        Ok(())
    }
}

impl System for StageSystem<'_> {
    fn evaluate(
        &mut self,
        x: &[f64],
        residual: &mut [f64],
        mut values: Option<&mut [f64]>,
    ) -> Result<f64, usize> {
        let stage = Stage { x, old: self.history, dt: self.dt };
        self.body.assemble(&stage, residual, values.as_deref_mut()).map_err(|failed| failed.element)?;
        if let Some(stiffness) = self.shear_layer {
            let layer = (stiffness, &self.conditions.closed_points[..]);
            self.body.add_shear_layer(layer, x, residual, values.as_deref_mut());
        }
        self.raw_residual.copy_from_slice(residual);
        let indentation = if self.compliance == 0.0 {
            self.displacement
        } else {
            self.displacement - self.compliance * self.conditions.reaction(self.raw_residual)
        };
        for &(axial, pull) in &self.conditions.pulls {
            residual[axial] -= pull;
        }
        let guides: Vec<(usize, Guide)> =
            self.conditions.slides.iter().map(|s| (s.radial, s.at(self.profile, x))).collect();
        if let Some(values) = values.as_deref_mut() {
            self.constrain(&guides, residual, values);
        }
        for ((radial, guide), slide) in guides.iter().zip(&self.conditions.slides) {
            residual[*radial] += guide.ratio * residual[radial + 1] - slide.friction * slide.adhesion;
        }
        for (unknown, r) in residual.iter_mut().enumerate() {
            let scale = self.column_scale[unknown];
            let value = self.conditions.values[unknown];
            match self.conditions.unknowns[unknown] {
                Condition::Free => *r *= scale / self.energy_scale,
                Condition::Fixed => *r = (x[unknown] - value) / scale,
                Condition::Punch => *r = (x[unknown] + indentation - value) / scale,
            }
        }
        let mut square = 0.0;
        for (radial, guide) in &guides {
            let axial = radial + 1;
            residual[axial] = (x[axial] + indentation - guide.face.height) / self.column_scale[axial];
            if !self.profile.is_flat() {
                // Newton's method has to find the place on a curved face.
                square += residual[axial] * residual[axial];
            }
        }
        if let Some(drag) = &self.drag {
            let places = drag.is_pressure.iter().zip(&self.conditions.unknowns);
            for (unknown, (is_pressure, condition)) in places.enumerate() {
                if *condition == Condition::Free && !is_pressure {
                    let moved = (x[unknown] - drag.from[unknown]) / self.column_scale[unknown];
                    residual[unknown] += drag.stiffness * moved;
                    if let Some(values) = values.as_deref_mut() {
                        let diagonal = self.body.map.pattern.position(unknown as u32, unknown as u32);
                        values[diagonal as usize] += drag.stiffness;
                    }
                }
            }
        }
        for (r, condition) in residual.iter().zip(&self.conditions.unknowns) {
            if *condition == Condition::Free {
                square += r * r;
            }
        }
        if self.compliance != 0.0 {
            // All nodes of the punch miss its place by the same.
            let miss = self.conditions.punch.first().map_or(0.0, |&u| residual[u]);
            square += miss * miss;
        }
        Ok(square.sqrt())
    }

    fn correct(&mut self, values: &[f64], correction: &mut [f64], _: Aim) -> Result<(), Singular> {
        self.statistics.factorisations += 1;
        self.linear.factorise(values)?;
        self.solve(correction, |linear, rhs| linear.solve_again(values, rhs))
    }

    const KEEPS_FACTORS: bool = true;

    fn correct_again(&mut self, correction: &mut [f64]) -> Result<(), Singular> {
        self.solve(correction, LinearSolver::solve_roughly)
    }

    fn scale(&self) -> &[f64] {
        self.column_scale
    }

    fn statistics(&mut self) -> &mut Statistics {
        self.statistics
    }
}
