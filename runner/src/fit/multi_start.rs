//! Several starts, so that a local minimum is recognised as one.
//!
//! The first start is the user's; the others are a seeded Latin hypercube over the bounds of the optimiser's
//! variables (log parameters). All starts are prefetched, so their first runs fill every worker.

use super::options::Options;
use super::problem::{Bounds, EvaluationFailure, FitError, Problem};
use super::solution::{IterationRecord, Solution, StopReason};
use super::trust_region::minimise;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// How many starts, and where from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MultiStartOptions {
    /// Starts in all, the user's included; at least 1.
    pub starts: usize,
    /// Of the drawn starts, how many are refined (those with the smallest chi^2).
    pub refined: usize,
    /// Seed of the draw: same seed, same starts.
    pub seed: u64,
}

/// What became of one start: the material of a waterfall plot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StartRecord {
    /// 0 is the user's start.
    pub index: usize,
    /// The start, in the optimiser's variables.
    pub start: Vec<f64>,
    /// chi^2 there, if the model could be evaluated.
    pub chi_square_start: Option<f64>,
    /// chi^2 at the end, if it was refined.
    pub chi_square: Option<f64>,
    /// Where it ended.
    pub end: Option<Vec<f64>>,
    /// Why it ended.
    pub stop: Option<StopReason>,
    /// Iterations made.
    pub iterations: usize,
    /// Residual evaluations made.
    pub evaluations: usize,
    /// Evaluations that failed, Jacobians included.
    pub failed: usize,
    /// Why it could not be started.
    pub failure: Option<String>,
}

/// The best solution and the fate of each start.
#[derive(Debug, Clone, PartialEq)]
pub struct MultiStart {
    /// The solution of smallest chi^2; among statistical equals that of the earliest start.
    pub best: Solution,
    /// Which start it came from.
    pub best_start: usize,
    /// All starts, by index.
    pub records: Vec<StartRecord>,
}

impl MultiStart {
    /// Searches from one start each, as one search; the records are numbered one after the other.
    ///
    /// # Errors
    /// When none of them found anything: what kept the first one from it.
    pub fn joined(searches: Vec<Result<Self, FitError>>) -> Result<Self, FitError> {
        let mut all: Option<Self> = None;
        let mut failure = None;
        for search in searches {
            let search = match search {
                Ok(search) => search,
                Err(error) => {
                    failure = failure.or(Some(error));
                    continue;
                }
            };
            let Some(joined) = &mut all else {
                all = Some(search);
                continue;
            };
            let before = joined.records.len();
            if significantly_better(&search.best, &joined.best) {
                (joined.best, joined.best_start) = (search.best, before + search.best_start);
            }
            let later = search.records.into_iter();
            joined.records.extend(later.map(|r| StartRecord { index: before + r.index, ..r }));
        }
        let nothing = || FitError::StartFailed("no start was given".to_owned());
        all.ok_or_else(|| failure.unwrap_or_else(nothing))
    }
}

/// Minimises from several starts. `observe` gets the index of the start and each iteration; breaking ends the
/// whole search with the best point so far.
///
/// # Errors
/// When the user's start is outside the bounds, or no start can be evaluated.
pub fn minimise_from_many<P: Problem + ?Sized>(
    problem: &mut P,
    start: &[f64],
    bounds: &Bounds,
    options: &Options,
    many: &MultiStartOptions,
    observe: &mut dyn FnMut(usize, &IterationRecord) -> ControlFlow<()>,
) -> Result<MultiStart, FitError> {
    bounds.check_start(start)?;
    let mut points = vec![bounds.interior(start, 1e-10)];
    points.extend(latin_hypercube(bounds, many.starts.saturating_sub(1), many.seed));
    let (mut records, interrupted) = screen(problem, &points);
    let order = refinement_order(&records, many.refined);

    let mut best: Option<(usize, Solution)> = None;
    let mut last_error = None;
    for index in order.into_iter().take(if interrupted { 1 } else { usize::MAX }) {
        let mut stopped = false;
        let result = minimise(problem, &points[index], bounds, options, &mut |record| {
            let flow = observe(index, record);
            stopped |= flow.is_break();
            flow
        });
        match result {
            Ok(solution) => {
                stopped |= solution.stop == StopReason::StopRequested;
                records[index].complete(&solution);
                if best.as_ref().is_none_or(|(_, b)| significantly_better(&solution, b)) {
                    best = Some((index, solution));
                }
            }
            Err(error) => {
                stopped |= error == FitError::Interrupted;
                records[index].failure = Some(error.to_string());
                last_error = Some(error);
            }
        }
        if stopped {
            break;
        }
    }
    match best {
        Some((best_start, best)) => Ok(MultiStart { best, best_start, records }),
        None => Err(last_error.unwrap_or_else(|| first_failure(&records))),
    }
}

/// `count` points in the box, each coordinate stratified into `count` equal cells. Unbounded coordinates are
/// drawn within [-1, 1].
pub fn latin_hypercube(bounds: &Bounds, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let dimension = bounds.lower().len();
    let mut points = vec![vec![0.0; dimension]; count];
    for j in 0..dimension {
        let (l, u) = (bounds.lower()[j], bounds.upper()[j]);
        let (l, u) = (if l.is_finite() { l } else { -1.0 }, if u.is_finite() { u } else { 1.0 });
        let mut cells: Vec<usize> = (0..count).collect();
        for i in (1..count).rev() {
            cells.swap(i, (rng.next_u64() % (i as u64 + 1)) as usize);
        }
        for (point, cell) in points.iter_mut().zip(cells) {
            point[j] = l + (u - l) * (cell as f64 + uniform(&mut rng)) / count as f64;
        }
    }
    points
}

/// A number strictly between 0 and 1, from the upper 52 bits.
fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    ((rng.next_u64() >> 12) as f64 + 0.5) / (1u64 << 52) as f64
}

/// Lower by more than the noise of one residual. Among equals the earliest start stays, the user's first of all:
/// interchangeable parameters (the branches of a viscous model) then keep the order that the user gave them.
fn significantly_better(new: &Solution, old: &Solution) -> bool {
    new.chi_square < old.chi_square * (1.0 - 1.0 / old.residual.len() as f64)
}

/// chi^2 at each start; a single start needs no screening. Second: whether the user interrupted.
fn screen<P: Problem + ?Sized>(problem: &mut P, points: &[Vec<f64>]) -> (Vec<StartRecord>, bool) {
    let mut records: Vec<_> =
        points.iter().enumerate().map(|(i, p)| StartRecord::new(i, p.clone())).collect();
    if points.len() < 2 {
        return (records, false);
    }
    problem.prefetch(points);
    for (record, point) in records.iter_mut().zip(points) {
        match problem.residual(point) {
            Ok(r) => record.chi_square_start = Some(r.iter().map(|v| v * v).sum()),
            Err(EvaluationFailure::Failed(reason)) => record.failure = Some(reason),
            Err(EvaluationFailure::Interrupted) => return (records, true),
        }
    }
    (records, false)
}

/// The user's start first, then the best of the others.
fn refinement_order(records: &[StartRecord], refined: usize) -> Vec<usize> {
    let usable = |r: &&StartRecord| r.failure.is_none() && r.chi_square_start.is_none_or(f64::is_finite);
    let mut drawn: Vec<&StartRecord> = records.iter().skip(1).filter(usable).collect();
    let chi_square = |r: &StartRecord| r.chi_square_start.unwrap_or(f64::INFINITY);
    drawn.sort_by(|a, b| chi_square(a).total_cmp(&chi_square(b)));
    let own = records.iter().take(1).filter(usable).map(|r| r.index);
    own.chain(drawn.iter().take(refined).map(|r| r.index)).collect()
}

fn first_failure(records: &[StartRecord]) -> FitError {
    let reason = records.iter().find_map(|r| r.failure.clone());
    FitError::StartFailed(reason.unwrap_or_else(|| "no start was evaluated".to_owned()))
}

impl StartRecord {
    fn new(index: usize, start: Vec<f64>) -> Self {
        Self {
            index,
            start,
            chi_square_start: None,
            chi_square: None,
            end: None,
            stop: None,
            iterations: 0,
            evaluations: 0,
            failed: 0,
            failure: None,
        }
    }

    fn complete(&mut self, solution: &Solution) {
        self.chi_square_start = solution.iterations.first().map(|r| r.chi_square);
        self.chi_square = Some(solution.chi_square);
        self.end = Some(solution.x.clone());
        self.stop = Some(solution.stop);
        self.iterations = solution.iteration_count();
        self.evaluations = solution.evaluations;
        self.failed = solution.failures.len();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// `r = (x^2 - 1)^2 / 2 + 0.1 (x - 1)`-like landscape with a poor minimum at x < 0 and the good one at 1.
    struct DoubleWell {
        prefetched: usize,
        fails_above: f64,
    }

    impl Problem for DoubleWell {
        fn dimension(&self) -> usize {
            1
        }
        fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
            if x[0] > self.fails_above {
                return Err(EvaluationFailure::Failed("too far right".to_owned()));
            }
            Ok(vec![x[0] * x[0] - 1.0, 0.3 * (x[0] - 1.0)])
        }
        fn jacobian(&mut self, x: &[f64], _: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
            Ok(DMatrix::from_column_slice(2, 1, &[2.0 * x[0], 0.3]))
        }
        fn prefetch(&mut self, points: &[Vec<f64>]) {
            self.prefetched = self.prefetched.max(points.len());
        }
    }

    fn search(fails_above: f64, starts: usize) -> (MultiStart, usize) {
        let mut problem = DoubleWell { prefetched: 0, fails_above };
        let bounds = Bounds::new(vec![-2.0], vec![2.0]).unwrap();
        let many = MultiStartOptions { starts, refined: 8, seed: 7 };
        let go = &mut |_, _: &IterationRecord| ControlFlow::Continue(());
        let options = Options::default();
        let result = minimise_from_many(&mut problem, &[-1.5], &bounds, &options, &many, go).unwrap();
        (result, problem.prefetched)
    }

    #[test]
    fn finds_the_better_well_and_keeps_the_fate_of_each_start() {
        let (single, _) = search(f64::INFINITY, 1);
        assert!(single.best.x[0] < -0.9, "{:?}", single.best.x);
        let (many, prefetched) = search(f64::INFINITY, 9);
        assert_eq!((many.records.len(), prefetched), (9, 9));
        assert!((many.best.x[0] - 1.0).abs() < 1e-6);
        assert!(many.best_start > 0 && many.records[0].chi_square.unwrap() > 0.1);
        assert_eq!(many, search(f64::INFINITY, 9).0);
    }

    #[test]
    fn starts_that_fail_are_recorded_and_skipped() {
        let (many, _) = search(1.2, 12);
        assert!((many.best.x[0] - 1.0).abs() < 1e-6);
        let failed: Vec<_> = many.records.iter().filter(|r| r.failure.is_some()).collect();
        assert!(!failed.is_empty());
        assert!(failed.iter().all(|r| r.start[0] > 1.2 && r.chi_square.is_none()));
    }

    #[test]
    fn of_searches_side_by_side_the_best_is_told_and_one_that_fails_is_no_end() {
        let from = |start: f64| {
            let mut problem = DoubleWell { prefetched: 0, fails_above: 2.5 };
            let bounds = Bounds::new(vec![-2.0], vec![3.0]).unwrap();
            let many = MultiStartOptions { starts: 1, refined: 8, seed: 7 };
            let go = &mut |_, _: &IterationRecord| ControlFlow::Continue(());
            minimise_from_many(&mut problem, &[start], &bounds, &Options::default(), &many, go)
        };
        let joined = MultiStart::joined(vec![from(2.9), from(-1.5), from(1.5)]).unwrap();
        assert!((joined.best.x[0] - 1.0).abs() < 1e-6);
        assert_eq!((joined.best_start, joined.records.len(), joined.records[1].index), (1, 2, 1));
        let first = MultiStart::joined(vec![from(1.5), from(-1.5)]).unwrap();
        assert_eq!((first.best_start, first.best.x[0]), (0, joined.best.x[0]));
        assert!(matches!(MultiStart::joined(vec![from(2.9)]), Err(FitError::StartFailed(_))));
    }

    #[test]
    fn hypercube_is_stratified_and_seeded() {
        let bounds = Bounds::new(vec![0.0, -30.0], vec![1.0, 10.0]).unwrap();
        let points = latin_hypercube(&bounds, 16, 3);
        for (j, (l, width)) in [(0.0, 1.0), (-30.0, 40.0)].into_iter().enumerate() {
            let mut cells: Vec<usize> =
                points.iter().map(|p| ((p[j] - l) / width * 16.0).floor() as usize).collect();
            cells.sort_unstable();
            assert_eq!(cells, (0..16).collect::<Vec<_>>());
        }
        assert_ne!(points, latin_hypercube(&bounds, 16, 4));
    }
}
