//! A search by a rough model. The solution and its force are those of the model asked for. Derivatives are the rough one's: they are as
//! accurate as it is, a per cent, and so are the widths of intervals.

use super::correction::{Goal, Trust, corrected, difference_mn};
use super::twin::Twin;
use crate::fit::{IterationRecord, Options, Solution, StopReason};
use crate::inference::fit::{
    Fit, FitFailure, Found, SearchPlan, Searched, chi_squares, options, search, searched,
};
use crate::inference::setup::Setup;
use crate::noise::Covariance;
use crate::pool::{Priority, Run};

/// The first fit, which knows no correction yet, ends this many times earlier than one that is kept.
const EARLIER: f64 = 10.0;

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
    let twin = Twin::rough(setup);
    let settled = options(setup, plan.evaluations);
    let goal = Goal { bounds: setup.unknowns.optimiser_bounds(), options: &settled, trust: Trust::LITTLE };
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
        match corrected(setup, (&twin, &[]), covariance, goal, end, &mut watch)? {
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

/// chi^2 of the model asked for at the end of a fit by the rough one; infinite where it fails, or the user asked to stop.
fn chi_square_asked(setup: Setup, rough: &Twin, covariance: &Covariance, x: &[f64]) -> f64 {
    let Ok(Some(offset_mn)) = difference_mn(setup, rough.setup(setup), &[], x) else { return f64::INFINITY };
    let twin = Twin { offset_mn, ..rough.clone() };
    let found = chi_squares(twin.setup(setup), &[], covariance, &[x.to_vec()]);
    found.ok().and_then(|all| all[0]).unwrap_or(f64::INFINITY)
}
