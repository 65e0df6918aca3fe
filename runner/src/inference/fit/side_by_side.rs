//! Searches from the starts that the data tell, side by side: a fit of one test keeps one core busy.

use super::{JacobianLoad, SearchPlan, Setup, problem};
use crate::fit::multi_start::minimise_from_many;
use crate::fit::{FitError, IterationRecord, MultiStart, MultiStartOptions, Options, Solution};
use crate::noise::Covariance;
use std::panic::resume_unwind;
use std::sync::mpsc;
use std::thread;

/// Drawn starts that are refined to the end; the others are only screened.
const REFINED: usize = 8;

/// What all of them found.
pub struct Searched {
    /// As one search.
    pub joined: MultiStart,
    /// Where each told start ended, with its index: the best one, then the others by chi^2.
    pub ends: Vec<(usize, Solution)>,
    /// How busy the pool was while Jacobians were formed.
    pub load: JacobianLoad,
    /// Points at which the model failed.
    pub failed_points: u64,
}

/// Searches from all starts of the plan; `observe` sees each accepted step with the index of its start, on the caller's thread.
///
/// # Errors
/// When no start can be evaluated.
pub fn searched(
    setup: Setup,
    covariance: &Covariance,
    plan: &SearchPlan,
    options: &Options,
    observe: &mut dyn FnMut(usize, &IterationRecord),
) -> Result<Searched, FitError> {
    let own = MultiStartOptions { starts: plan.starts.max(1), refined: REFINED, seed: plan.seed };
    let alone = MultiStartOptions { starts: 1, ..own.clone() };
    let first = (0, setup.unknowns.start(), &own);
    let others =
        plan.others.iter().zip(own.starts..).map(|(start, number)| (number, start.as_slice(), &alone));
    let searches: Vec<_> = thread::scope(|scope| {
        let (sender, records) = mpsc::channel();
        let begin = |(number, start, many)| {
            let sender = sender.clone();
            let tell = move |start: usize, record: &IterationRecord| {
                // Where nobody listens any more, nobody needs to know.
                let _ = sender.send((number + start, record.clone()));
            };
            scope.spawn(move || from_one(setup, covariance, start, (many, options), &tell))
        };
        let begun: Vec<_> = std::iter::once(first).chain(others).map(begin).collect();
        drop(sender);
        records.iter().for_each(|(start, record)| observe(start, &record));
        begun.into_iter().map(|search| search.join().unwrap_or_else(|panic| resume_unwind(panic))).collect()
    });
    let load = searches.iter().map(|s| s.1).reduce(JacobianLoad::beside).unwrap_or_default();
    let failed_points = searches.iter().map(|s| s.2).sum();
    let numbered = searches.iter().zip(std::iter::once(0).chain(own.starts..));
    let end = |((found, ..), before): (&(Result<MultiStart, _>, _, _), usize)| {
        found.as_ref().ok().map(|found| (before + found.best_start, found.best.clone()))
    };
    let mut ends: Vec<(usize, Solution)> = numbered.filter_map(end).collect();
    let joined = MultiStart::joined(searches.into_iter().map(|s| s.0).collect())?;
    ends.sort_by(|a, b| a.1.chi_square.total_cmp(&b.1.chi_square));
    ends.sort_by_key(|(start, _)| *start != joined.best_start);
    Ok(Searched { joined, ends, load, failed_points })
}

/// One search, how busy the pool was, and the points at which the model failed.
fn from_one(
    setup: Setup,
    covariance: &Covariance,
    start: &[f64],
    (many, options): (&MultiStartOptions, &Options),
    tell: &dyn Fn(usize, &IterationRecord),
) -> (Result<MultiStart, FitError>, JacobianLoad, u64) {
    let mut problem = problem(setup, &[], covariance);
    let mut watch = |start: usize, record: &IterationRecord| {
        tell(start, record);
        setup.engine.going_on()
    };
    let bounds = setup.unknowns.optimiser_bounds();
    let found = minimise_from_many(&mut problem, start, bounds, options, many, &mut watch);
    (found, problem.inner().load(), problem.inner().failed())
}
