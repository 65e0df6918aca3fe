//! What a rough model differs by from the one asked for, and fits that go on with it.

use super::twin::Twin;
use crate::fit::{
    Bounds, EvaluationFailure, IterationRecord, Options, Problem, Solution, StopReason, Whitening, minimise,
};
use crate::inference::effect::Candidate;
use crate::inference::fit::{FitFailure, ROUGH, problem};
use crate::inference::problem::ForceProblem;
use crate::inference::setup::Setup;
use crate::noise::Covariance;
use crate::pool::Priority;
use nalgebra::DVector;
use std::ops::ControlFlow;

/// The corrected model foresees the other one where their squared difference is less than this part of the number of points or, where that is
/// larger, of chi^2, in units of the covariance: no further correction lowers chi^2 by more than about that.
const FORESEEN: f64 = 1e-2;
/// The same where what may be the answer is fitted again by a finer model: a tenth of chi^2 tells what misses the data.
const FORESEEN_ROUGHLY: f64 = 1e-1;
/// Corrections shrink the difference by a factor of ten or more each; where so many do not suffice, something else is wrong.
const MOST_CORRECTIONS: usize = 4;

/// What a rougher model is trusted with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trust {
    /// Part of chi^2 that it has to foresee, corrected, to have led to a minimum.
    pub foreseen: f64,
    /// Part of chi^2 by which a rough fit may end above its start and stay the rougher model's.
    pub astray: f64,
}

impl Trust {
    /// Where nothing is fitted again.
    pub const LITTLE: Self = Self { foreseen: FORESEEN, astray: 0.0 };
    /// Where what may be the answer is fitted again by a finer model.
    pub const MUCH: Self = Self { foreseen: FORESEEN_ROUGHLY, astray: ROUGH };
}

/// How fits by a rough model end.
#[derive(Clone, Copy)]
pub(in crate::inference) struct Goal<'a> {
    /// Of parameters and magnitudes.
    pub bounds: &'a Bounds,
    /// Tolerances.
    pub options: &'a Options,
    /// What the rough model is trusted with.
    pub trust: Trust,
}

/// Goes on from the end of a fit by the rough model, with what the two models differ by. With the solution the corrected rough model, where it is
/// a minimum of the model asked for; none where the user asked to stop, or the rough model does not lead there.
pub(super) fn corrected(
    setup: Setup,
    (rough, active): (&Twin, &[&Candidate]),
    covariance: &Covariance,
    goal: Goal,
    mut solution: Solution,
    watch: &mut dyn FnMut(&IterationRecord) -> ControlFlow<()>,
) -> Result<(Solution, Option<Twin>), FitFailure> {
    let mut twin = rough.clone();
    // The best point of the model asked for, and by what the rough one is corrected there.
    let mut best: Option<(Solution, Twin)> = None;
    for _ in 0..MOST_CORRECTIONS {
        if solution.stop == StopReason::StopRequested {
            break;
        }
        let apart = match difference_mn(setup, twin.setup(setup), active, &solution.x) {
            Err(EvaluationFailure::Interrupted) => {
                // The best point of the corrected rough model is kept.
                solution.stop = StopReason::StopRequested;
                break;
            }
            other => other?,
        };
        let Some(apart) = apart else {
            // The rough model leads to where the one asked for cannot be computed.
            match last_computable(setup, &twin, active, &solution.iterations) {
                Err(EvaluationFailure::Interrupted) => solution.stop = StopReason::StopRequested,
                found => {
                    if let Some((x, there)) = found? {
                        solution.residual = problem(there.setup(setup), active, covariance).residual(&x)?;
                        solution.chi_square = solution.residual.iter().map(|r| r * r).sum();
                        solution.x = x;
                    }
                }
            }
            break;
        };
        let before = std::mem::replace(&mut twin.offset_mn, apart);
        let before = before.into_iter().chain(std::iter::repeat(0.0));
        let changes = twin.offset_mn.iter().zip(before).map(|(new, old)| new - old);
        let change = DVector::from_iterator(twin.offset_mn.len(), changes);
        let mut corrected = problem(twin.setup(setup), active, covariance);
        solution.residual = corrected.residual(&solution.x)?;
        solution.chi_square = solution.residual.iter().map(|r| r * r).sum();
        let most = goal.trust.foreseen * solution.chi_square.max(change.len() as f64);
        let is_foreseen = covariance.apply(&change).norm_squared() <= most;
        // A correction that does not lower chi^2 any more has met steps of the rough model.
        let is_worse = best.as_ref().is_some_and(|(best, _)| best.chi_square <= solution.chi_square);
        if is_foreseen || is_worse {
            let (solution, twin) = best.filter(|_| is_worse).unwrap_or((solution, twin));
            return Ok((solution, Some(twin)));
        }
        best = Some((solution.clone(), twin.clone()));
        solution = after(minimise(&mut corrected, &solution.x, goal.bounds, goal.options, watch)?, &solution);
    }
    Ok((solution, None))
}

/// The last point on the way of fits by the rough model at which the model asked for can be computed, and the rough one corrected there.
fn last_computable(
    asked: Setup,
    twin: &Twin,
    active: &[&Candidate],
    way: &[IterationRecord],
) -> Result<Option<(Vec<f64>, Twin)>, EvaluationFailure> {
    for IterationRecord { x, .. } in way.iter().rev().skip(1) {
        if let Some(offset_mn) = difference_mn(asked, twin.setup(asked), active, x)? {
            return Ok(Some((x.clone(), Twin { offset_mn, ..twin.clone() })));
        }
    }
    Ok(None)
}

/// Force of the model asked for minus that of the rough one (mN); none where one of them fails.
pub(super) fn difference_mn(
    asked: Setup,
    rough: Setup,
    active: &[&Candidate],
    x: &[f64],
) -> Result<Option<Vec<f64>>, EvaluationFailure> {
    let rough_derivatives = ForceProblem::new(rough, active).exact_columns() > 0;
    // The rough run is the fit's own.
    let runs = [(asked, false), (rough, rough_derivatives)];
    let runs = runs.map(|(setup, derivatives)| {
        ForceProblem::new(setup, active).submit(x, derivatives, Priority::Urgent)
    });
    let [forces, rough] = runs.map(|runs| Setup::computable_forces_mn(&runs));
    let offset_mn = asked.offset_mn.iter().copied().chain(std::iter::repeat(0.0));
    let apart = forces?.zip(rough?).map(|(a, r)| a.into_iter().zip(r).zip(offset_mn));
    Ok(apart.map(|apart| apart.map(|((a, r), offset)| a + offset - r).collect()))
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
