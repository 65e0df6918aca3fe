//! The search for the equilibrium of one set of nodes in contact.

use super::step::{Patience, Task};
use super::stepper::Stepper;
use super::system::{Drag, StageSystem};
use crate::outputs::Statistics;
use crate::solver::newton::{self, NewtonFailure, Workspace};

/// Dimensionless stiffness of the drag on the nodes at first, and its changes after a success and a failure.
const FIRST_DRAG: f64 = 1e-2;
const DRAG_FALL: f64 = 0.2;
const DRAG_RISE: f64 = 10.0;
/// Longest motion against drag, in steps: a shorter time step is cheaper than more of them, unless it was tried in vain.
const MAX_DRAGGED: usize = 12;
const MAX_DRAGGED_IN_THE_END: usize = 60;
/// A dimensionless residual from which something like a snap, not a far start, keeps Newton's method.
const NEAR: f64 = 1e-5;

impl Stepper {
    /// Finds the equilibrium of a stage for the nodes that are in contact. Where Newton's method fails - beside a
    /// peeling edge the folded surface may snap from one equilibrium to another - drag on the nodes leads it there.
    pub(super) fn find(
        &mut self,
        x: &mut Vec<f64>,
        task: &Task<'_>,
        statistics: &mut Statistics,
    ) -> Result<(), NewtonFailure> {
        let start = x.clone();
        let Err(failure) = self.equilibrate(x, task, None, statistics) else { return Ok(()) };
        // Under a fully closed face a far start fails for other reasons, which a shorter step removes if anything does.
        let near = matches!(failure, NewtonFailure::NotConverged { residual, .. } if residual < NEAR);
        let closed =
            self.conditions.slides.is_empty() && self.conditions.punch.len() >= self.surface.face_nodes();
        if closed && !near && task.patience == Patience::Little {
            return Err(failure);
        }
        x.clone_from(&start);
        let (mut reached, mut drag) = (start, FIRST_DRAG);
        let is_pressure = self.is_pressure.clone();
        let longest = match task.patience {
            Patience::Little => MAX_DRAGGED,
            Patience::Much => MAX_DRAGGED_IN_THE_END,
        };
        for _ in 0..longest {
            let dragged = Some(Drag { from: &reached, stiffness: drag, is_pressure: &is_pressure });
            match self.equilibrate(x, task, dragged, statistics) {
                Ok(()) => {
                    reached.clone_from(x);
                    drag *= DRAG_FALL;
                    if self.equilibrate(x, task, None, statistics).is_ok() {
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
        task: &Task<'_>,
        drag: Option<Drag<'_>>,
        statistics: &mut Statistics,
    ) -> Result<(), NewtonFailure> {
        let tolerance = self.tolerance;
        let (mut system, work) = self.stage_system(task, drag, statistics);
        self.residual_norms = newton::solve(&mut system, work, x, tolerance)?;
        Ok(())
    }

    /// Forms the tangent at the solution `x` of a stage.
    pub(super) fn linearise(
        &mut self,
        x: &[f64],
        task: &Task<'_>,
        statistics: &mut Statistics,
    ) -> Result<(), NewtonFailure> {
        let (mut system, work) = self.stage_system(task, None, statistics);
        work.evaluate(&mut system, x).map(drop).map_err(NewtonFailure::Inadmissible)
    }

    /// One stage's equations, and the vectors of their iteration.
    fn stage_system<'a>(
        &'a mut self,
        task: &Task<'a>,
        drag: Option<Drag<'a>>,
        statistics: &'a mut Statistics,
    ) -> (StageSystem<'a>, &'a mut Workspace) {
        let system = StageSystem {
            energy_scale: self.energy_scale(),
            body: self.sample.body(&self.material),
            conditions: &self.conditions,
            column_scale: &self.column_scale,
            history: task.start.history,
            dt: task.length,
            displacement: task.displacement,
            shear_layer: self.shear_layer,
            compliance: self.constants.compliance,
            profile: self.surface.profile(),
            drag,
            raw_residual: &mut self.raw_residual,
            reaction_row: &mut self.reaction_row,
            linear: &mut self.linear,
            statistics,
        };
        (system, &mut self.work)
    }
}
