//! Steps that are led back to the floor of a valley that bends.

use super::problem::{EvaluationFailure, Problem};
use super::solution::StopReason;
use super::step::{ScaledModel, Step};
use super::subproblem::Decomposition;
use super::trust_region::{Log, Point, agreement, evaluate};
use nalgebra::DVector;

/// A step that achieves a smaller part of what was predicted is corrected, and shrinks the region where that does not help.
pub(super) const POOR: f64 = 0.25;
/// Corrections of one step at most; each is an evaluation.
const MOST: usize = 3;

/// Where a step leads.
pub(super) struct Trial {
    pub x: DVector<f64>,
    pub f: DVector<f64>,
    pub cost: f64,
}

impl Trial {
    pub(super) fn new(x: DVector<f64>, f: DVector<f64>) -> Self {
        let cost = 0.5 * f.norm_squared();
        Self { x, f, cost }
    }
}

/// What corrects a step.
pub(super) struct Correction<'a> {
    /// The quadratic model that chose it.
    pub model: &'a ScaledModel<'a>,
    /// The decomposition that it came from, and its Levenberg-Marquardt parameter.
    pub solver: (&'a Decomposition, f64),
    /// The step.
    pub step: &'a Step,
    /// Whether no bound bent it.
    pub is_straight: bool,
    /// Where it starts.
    pub here: &'a Point,
    /// Evaluations of the whole fit at most.
    pub most_evaluations: usize,
}

impl Correction<'_> {
    /// The better of the step's end and what corrections of it lead to.
    ///
    /// # Errors
    /// When the user asked to stop.
    pub(super) fn lead<P: Problem + ?Sized>(
        &self,
        problem: &mut P,
        mut trial: Trial,
        log: &mut Log,
    ) -> Result<Trial, StopReason> {
        let (here, straight) = (self.here, &self.step.p_scaled);
        let mut path = straight.clone();
        for _ in 0..MOST {
            let is_poor = agreement(here.cost - trial.cost, self.step.predicted) < POOR;
            if !is_poor || !self.is_straight || log.evaluations >= self.most_evaluations {
                break;
            }
            let turned = self.model.turned(self.solver, (straight, &path), (&here.f, &trial.f));
            let Some(turned) = turned else { break };
            let end = &here.x + self.model.d.component_mul(&turned);
            let x = DVector::from_vec(self.model.bounds.interior(end.as_slice(), 0.0));
            match evaluate(problem, &x, log).map(|f| Trial::new(x.clone(), f)) {
                Ok(better) if better.cost < trial.cost => {
                    problem.rejected(trial.x.as_slice());
                    (trial, path) = (better, turned);
                }
                Err(EvaluationFailure::Interrupted) => return Err(StopReason::StopRequested),
                Ok(_) | Err(EvaluationFailure::Failed(_)) => {
                    problem.rejected(x.as_slice());
                    break;
                }
            }
        }
        Ok(trial)
    }
}
