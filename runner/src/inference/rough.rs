//! A fit by a rough model, corrected by runs of the model asked for.
//!
//! The rough model - coarsest mesh, steps and residuals as accurate as it is - differs by a per cent of the force and costs a
//! fraction. It is fitted; then the difference of the two models at the solution is added to its force as it is, and the fit
//! goes on, until a run of the model asked for gives what the corrected rough one foresees (space mapping: Bandler et al. 1994).
//! The solution is that of the model asked for; derivatives on the way, whose errors only slow the iteration, are the rough one's.

use super::fit::{Fit, FitFailure, Found, SearchPlan, options, search};
use super::problem::ForceProblem;
use super::setup::Setup;
use crate::fit::{
    EvaluationFailure, IterationRecord, Problem, SharedErrors, Solution, StopReason, Whitening, minimise,
};
use crate::noise::Covariance;
use crate::pool::Priority;
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;

const ROUGH: [(&str, f64); 3] =
    [("mesh.preset", 1.0), ("solver.tolerance", 1e-2), ("solver.newton_tolerance", 1e-6)];
/// The corrected model foresees the other one where their squared difference is less than this part of the number of points, in units
/// of the covariance: no further correction lowers chi^2 by more than about that.
const FORESEEN: f64 = 1e-2;
/// Corrections shrink the difference by a factor of ten or more each; where so many do not suffice, something else is wrong.
const MOST_CORRECTIONS: usize = 4;

/// Whether the model has a rough twin: it is poropunch's own, and nothing of what makes it rough was chosen.
pub fn applies(setup: Setup) -> bool {
    let chosen = |name: &String| name.starts_with("mesh.") || name.starts_with("solver.");
    setup.engine.is_own() && !setup.unknowns.fixed().keys().any(chosen)
}

/// [`search`] by the rough model; by runs of the model asked for alone where the rough one leads nowhere.
///
/// # Errors
/// When no start can be evaluated.
pub fn search_roughly(
    setup: Setup,
    covariance: &Covariance,
    plan: &SearchPlan,
    observe: &mut dyn FnMut(usize, &IterationRecord),
) -> Result<Found, FitFailure> {
    let unknowns = setup.unknowns.clone().with_fixed(&ROUGH);
    let rough = Setup { unknowns: &unknowns, ..setup };
    let Ok(found) = search(rough, covariance, plan, observe) else {
        return search(setup, covariance, plan, observe);
    };
    let best_start = found.best_start;
    let mut watch = |record: &IterationRecord| {
        observe(best_start, record);
        if setup.engine.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let measured = DVector::from_vec(setup.measured_mn());
    let mut offset = vec![0.0; measured.len()];
    let mut solution = found.fit.solution.clone();
    for _ in 0..MOST_CORRECTIONS {
        if solution.stop == StopReason::StopRequested {
            break;
        }
        let apart = match difference_mn(setup, rough, &solution.x) {
            Err(EvaluationFailure::Interrupted) => {
                // The best point of the corrected rough model is kept.
                solution.stop = StopReason::StopRequested;
                break;
            }
            other => other?,
        };
        let Some(apart) = apart else { break };
        let change =
            DVector::from_iterator(offset.len(), apart.iter().zip(&offset).map(|(new, old)| new - old));
        offset = apart;
        if covariance.apply(&change).norm_squared() <= FORESEEN * measured.len() as f64 {
            let fit = Fit::at(setup, &[], covariance, solution)?;
            return Ok(Found { fit, ..found });
        }
        let forces = ForceProblem::new(rough, &[]);
        let prior = if covariance.is_known() { forces.prior() } else { forces.prior().flat() };
        let corrected = Corrected { rough: forces, offset: &offset };
        let mut problem = SharedErrors::new(corrected, covariance, measured.clone(), prior);
        let bounds = setup.unknowns.optimiser_bounds();
        let options = options(setup, plan.evaluations);
        solution = after(minimise(&mut problem, &solution.x, bounds, &options, &mut watch)?, &solution);
    }
    if solution.stop == StopReason::StopRequested {
        return Ok(Found { fit: Fit { solution, ..found.fit.clone() }, ..found });
    }
    let unknowns = setup.unknowns.clone().starting_at(&solution.x);
    search(Setup { unknowns: &unknowns, ..setup }, covariance, plan, observe)
}

/// Force of the model asked for minus that of the rough one (mN); none where one of them fails.
fn difference_mn(asked: Setup, rough: Setup, x: &[f64]) -> Result<Option<Vec<f64>>, EvaluationFailure> {
    // With derivatives where there are some: the last of these runs is the solution's.
    let runs = [asked, rough].map(|setup| {
        let derivatives = ForceProblem::new(setup, &[]).exact_columns() > 0;
        setup.submit(x, &[], derivatives, Priority::Urgent)
    });
    let [asked, rough] = runs.map(|runs| Setup::computable_forces_mn(&runs));
    Ok(asked?.zip(rough?).map(|(a, r)| a.iter().zip(r).map(|(a, r)| a - r).collect()))
}

/// A solution with the history of the one that it goes on from.
fn after(mut best: Solution, before: &Solution) -> Solution {
    let (iterations, evaluations) = (before.iteration_count(), before.evaluations);
    let later = best.iterations.iter().skip(1).map(|record| IterationRecord {
        iteration: record.iteration + iterations,
        evaluations: record.evaluations + evaluations,
        ..record.clone()
    });
    best.iterations = before.iterations.iter().cloned().chain(later).collect();
    best.evaluations += evaluations;
    best.jacobians += before.jacobians;
    best.failures.splice(0..0, before.failures.iter().cloned());
    best
}

/// The rough model with what the other one differed by at one point (mN).
struct Corrected<'a> {
    rough: ForceProblem<'a>,
    offset: &'a [f64],
}

impl Problem for Corrected<'_> {
    fn dimension(&self) -> usize {
        self.rough.dimension()
    }

    fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
        let residual = self.rough.residual(x)?;
        Ok(residual.iter().zip(self.offset).map(|(r, offset)| r + offset).collect())
    }

    fn jacobian(&mut self, x: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
        let rough: Vec<f64> = r.iter().zip(self.offset).map(|(r, offset)| r - offset).collect();
        self.rough.jacobian(x, &rough)
    }

    fn prefetch(&mut self, points: &[Vec<f64>]) {
        self.rough.prefetch(points);
    }

    fn rejected(&mut self, x: &[f64]) {
        self.rough.rejected(x);
    }
}
