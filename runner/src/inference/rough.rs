//! A fit by a rough model, corrected by runs of the model asked for.
//!
//! The rough model - coarsest mesh, steps and residuals as accurate as it is - differs by a per cent of the force and costs a
//! fraction. It is fitted; then the difference of the two models at the solution is added to its force as it is, and the fit
//! goes on, until a run of the model asked for gives what the corrected rough one foresees, or fits no better than the one before
//! (space mapping: Bandler et al. 1994).
//! The solution and its force are those of the model asked for. Derivatives are the rough one's: they are as accurate as it is, a
//! per cent, and so are the widths of intervals.

use super::fit::{
    Fit, FitFailure, Found, SearchPlan, Searched, chi_squares, options, problem, search, searched,
};
use super::problem::ForceProblem;
use super::setup::Setup;
use super::start::{Face, Known};
use super::unknowns::Unknowns;
use crate::fit::{
    EvaluationFailure, IterationRecord, Options, Problem, Solution, StopReason, Whitening, minimise,
};
use crate::noise::Covariance;
use crate::pool::{Priority, Run};
use nalgebra::DVector;
use std::ops::ControlFlow;

const ROUGH: [(&str, f64); 3] =
    [("mesh.preset", 1.0), ("solver.tolerance", 1e-2), ("solver.newton_tolerance", 1e-7)];
/// Rougher under a sphere or a cone, where the contact's nodes close one after the other, each by iterations of its own: elements
/// twice the coarsest mesh's and first step, both over the radius of the shank.
const ROUGH_TIP: [(&str, f64); 2] = [("mesh.edge_size", 1.0 / 8.0), ("solver.initial_increment", 0.05)];
const ROUGH_TIP_RESIDUAL: (&str, f64) = ("solver.newton_tolerance", 1e-6);
/// The corrected model foresees the other one where their squared difference is less than this part of the number of points, in units
/// of the covariance: no further correction lowers chi^2 by more than about that.
const FORESEEN: f64 = 1e-2;
/// Corrections shrink the difference by a factor of ten or more each; where so many do not suffice, something else is wrong.
const MOST_CORRECTIONS: usize = 4;
/// The first fit, which knows no correction yet, ends this many times earlier than one that is kept.
const EARLIER: f64 = 10.0;

/// The rough model with what the one asked for differed by at one point.
#[derive(Debug, Clone)]
pub struct Twin {
    unknowns: Unknowns,
    /// Force of the model asked for minus that of the rough one (mN); empty: not known.
    offset_mn: Vec<f64>,
}

impl Twin {
    /// What stands for the model asked for.
    pub fn setup<'a>(&'a self, asked: Setup<'a>) -> Setup<'a> {
        Setup { unknowns: &self.unknowns, offset_mn: &self.offset_mn, ..asked }
    }
}

/// Whether the model has a rough twin: it is poropunch's own, no coarser one, and nothing else of what makes it rough was chosen.
pub fn applies(setup: Setup) -> bool {
    let [(preset, coarsest), ..] = ROUGH;
    let is_chosen = |(name, value): (&String, &f64)| match name.as_str() {
        name if name == preset => *value == coarsest,
        name => name.starts_with("mesh.") || name.starts_with("solver."),
    };
    setup.engine.is_own() && !setup.unknowns.fixed().iter().any(is_chosen)
}

/// The unknowns of the rough model.
fn rough_unknowns(setup: Setup) -> Unknowns {
    let at_start = setup.unknowns.settings(setup.unknowns.start());
    let known = Known::of(&|name| setup.value(&at_start, name));
    let unknowns = setup.unknowns.clone().with_fixed(&ROUGH);
    match known.map(|known| known.rig.face) {
        Some(Face::Sphere { shank, .. } | Face::Cone { shank, .. }) => {
            let lengths = ROUGH_TIP.map(|(name, part)| (name, part * shank));
            unknowns.with_fixed(&lengths).with_fixed(&[ROUGH_TIP_RESIDUAL])
        }
        _ => unknowns,
    }
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
    let twin = Twin { unknowns: rough_unknowns(setup), offset_mn: vec![] };
    let settled = options(setup, plan.evaluations);
    let earlier = Options {
        chi_square_tolerance: EARLIER * settled.chi_square_tolerance,
        noise_tolerance: EARLIER * settled.noise_tolerance,
        foreseen_tolerance: EARLIER * settled.foreseen_tolerance,
        ..settled.clone()
    };
    let Ok(searched) = searched(twin.setup(setup), covariance, plan, &earlier, observe) else {
        return search(setup, covariance, plan, observe);
    };
    let Searched { joined, ends, load, failed_points } = searched;
    let found = |start: usize, fit: Fit, twin: Option<Twin>| Found {
        fit,
        best_start: start,
        starts: joined.records.clone(),
        load,
        failed_points,
        twin,
    };
    // The first end's correction may show that another is wanted: what the model asked for gives there is computed by workers that
    // would be idle meanwhile, and is dropped where it is not.
    let idle = setup.engine.pool().idle().saturating_sub(setup.observations.len());
    let begin = |(_, end): &(usize, Solution)| setup.submit(&end.x, &[], false, Priority::Speculative);
    let _beside: Vec<Vec<Run>> = ends.iter().skip(1).take(idle).map(begin).collect();
    let mut ends = ends.into_iter().peekable();
    // Ends by chi^2 of the model asked for there.
    let mut judged: Vec<(f64, usize, Solution)> = vec![];
    let mut best: Option<Found> = None;
    let mut astray = joined.best.x.clone();
    loop {
        let least = |judged: &[(f64, usize, Solution)]| {
            let best = best.iter().map(|best| best.fit.solution.chi_square);
            judged.iter().map(|(chi_square, ..)| *chi_square).chain(best).fold(f64::INFINITY, f64::min)
        };
        // What is this much worse by the rough model is hardly the better one; ends that are nearer are judged by the model asked for.
        while let Some((start, end)) = ends.next_if(|(_, end)| end.chi_square < least(&judged)) {
            let chi_square = chi_square_asked(setup, &twin, covariance, &end.x);
            judged.push((chi_square, start, end));
        }
        judged.sort_by(|a, b| b.0.total_cmp(&a.0));
        let Some((chi_square, start, end)) = judged.pop() else { break };
        if best.as_ref().is_some_and(|best| best.fit.solution.chi_square <= chi_square) {
            break;
        }
        let mut watch = |record: &IterationRecord| {
            observe(start, record);
            setup.engine.going_on()
        };
        // Its runs were made: no stop keeps them from being seen.
        let by_rough_one = Fit::at(twin.setup(setup), &[], covariance, end.clone())?;
        match corrected(setup, &twin, covariance, end, &settled, &mut watch)? {
            (solution, None) if solution.stop == StopReason::StopRequested => {
                let fit = Fit { solution, ..by_rough_one };
                return Ok(best.unwrap_or_else(|| found(start, fit, None)));
            }
            (solution, None) => astray = solution.x,
            (solution, Some(twin)) => {
                if best.as_ref().is_none_or(|best| solution.chi_square < best.fit.solution.chi_square) {
                    let fit = Fit::at(twin.setup(setup), &[], covariance, solution)?;
                    best = Some(found(start, fit, Some(twin)));
                }
            }
        }
    }
    if let Some(best) = best {
        return Ok(best);
    }
    let unknowns = setup.unknowns.clone().starting_at(&astray);
    search(
        Setup { unknowns: &unknowns, ..setup },
        covariance,
        &SearchPlan { others: vec![], ..plan.clone() },
        observe,
    )
}

/// Goes on from the end of a fit by the rough model, with what the two models differ by. With the solution the corrected rough model, where it is
/// a minimum of the model asked for; none where the user asked to stop, or the rough model does not lead there.
fn corrected(
    setup: Setup,
    rough: &Twin,
    covariance: &Covariance,
    mut solution: Solution,
    settled: &Options,
    watch: &mut dyn FnMut(&IterationRecord) -> ControlFlow<()>,
) -> Result<(Solution, Option<Twin>), FitFailure> {
    let mut twin = rough.clone();
    // The best point of the model asked for, and by what the rough one is corrected there.
    let mut best: Option<(Solution, Twin)> = None;
    for _ in 0..MOST_CORRECTIONS {
        if solution.stop == StopReason::StopRequested {
            break;
        }
        let apart = match difference_mn(setup, twin.setup(setup), &solution.x) {
            Err(EvaluationFailure::Interrupted) => {
                // The best point of the corrected rough model is kept.
                solution.stop = StopReason::StopRequested;
                break;
            }
            other => other?,
        };
        let Some(apart) = apart else { break };
        let before = std::mem::replace(&mut twin.offset_mn, apart);
        let before = before.into_iter().chain(std::iter::repeat(0.0));
        let changes = twin.offset_mn.iter().zip(before).map(|(new, old)| new - old);
        let change = DVector::from_iterator(twin.offset_mn.len(), changes);
        let is_foreseen = covariance.apply(&change).norm_squared() <= FORESEEN * change.len() as f64;
        let mut corrected = problem(twin.setup(setup), &[], covariance);
        solution.residual = corrected.residual(&solution.x)?;
        solution.chi_square = solution.residual.iter().map(|r| r * r).sum();
        // A correction that does not lower chi^2 any more has met steps of the rough model.
        let is_worse = best.as_ref().is_some_and(|(best, _)| best.chi_square <= solution.chi_square);
        if is_foreseen || is_worse {
            let (solution, twin) = best.filter(|_| is_worse).unwrap_or((solution, twin));
            return Ok((solution, Some(twin)));
        }
        best = Some((solution.clone(), twin.clone()));
        let bounds = setup.unknowns.optimiser_bounds();
        solution = after(minimise(&mut corrected, &solution.x, bounds, settled, watch)?, &solution);
    }
    Ok((solution, None))
}

/// chi^2 of the model asked for at the end of a fit by the rough one; infinite where it fails, or the user asked to stop.
fn chi_square_asked(setup: Setup, rough: &Twin, covariance: &Covariance, x: &[f64]) -> f64 {
    let Ok(Some(offset_mn)) = difference_mn(setup, rough.setup(setup), x) else { return f64::INFINITY };
    let twin = Twin { offset_mn, ..rough.clone() };
    let found = chi_squares(twin.setup(setup), &[], covariance, &[x.to_vec()]);
    found.ok().and_then(|all| all[0]).unwrap_or(f64::INFINITY)
}

/// Force of the model asked for minus that of the rough one (mN); none where one of them fails.
fn difference_mn(asked: Setup, rough: Setup, x: &[f64]) -> Result<Option<Vec<f64>>, EvaluationFailure> {
    let rough_derivatives = ForceProblem::new(rough, &[]).exact_columns() > 0;
    // The rough run is the fit's own.
    let runs = [(asked, false), (rough, rough_derivatives)];
    let runs = runs.map(|(setup, derivatives)| setup.submit(x, &[], derivatives, Priority::Urgent));
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
