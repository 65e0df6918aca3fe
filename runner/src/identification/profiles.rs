//! Which intervals are taken from the profile of the likelihood: those asked for, and those whose linearised ends are open or wrong.

use crate::fit::EvaluationFailure;
use crate::inference::parameter::FitParameter;
use crate::inference::profile::{Profile, Profiler, Target, targets};
use crate::inference::statistics::{Determination, ParameterEstimate};
use crate::inference::{Fit, Setup, Statistics, Unknowns};
use crate::pool::{Run, side_by_side};
use crate::report::ProfileRow;

/// In the place of a name: none but those asked for, not even where the linearised interval is wrong.
pub const NONE: &str = "none";

/// Names that can be asked for.
pub fn names(unknowns: &Unknowns) -> Vec<String> {
    targets(unknowns, unknowns.start()).into_iter().map(|t| t.parameter.symbol).collect()
}

/// The first name that is asked for and unknown.
pub fn unknown<'a>(unknowns: &Unknowns, asked: &'a [String]) -> Option<&'a String> {
    let all = targets(unknowns, unknowns.start());
    asked.iter().find(|name| *name != NONE && !all.iter().any(|t| t.is_called(name)))
}

/// Whether profiles are made unasked: without derivatives a run tells too little to be worth it.
fn is_automatic(setup: Setup, asked: &[String]) -> bool {
    !asked.iter().any(|name| name == NONE) && setup.is_differentiable()
}

/// Whether the linearised interval of a term is worth a better one: a parameter that is made of terms is as straight as they are; of what is
/// open to both sides, or not told from others, nothing is claimed.
fn is_doubtful(term: &ParameterEstimate) -> bool {
    matches!(term.determination, Determination::Loose | Determination::Undetermined) && term.open != [true; 2]
}

/// Starts the runs that the profiles begin with. They need no bends: those lengthen intervals, but not the path that is followed.
pub fn prefetch(setup: Setup, fit: &Fit, statistics: &Statistics, asked: &[String]) -> Vec<Run> {
    if !is_automatic(setup, asked) {
        return vec![];
    }
    let profiler = Profiler { setup, fit, statistics, evaluations: 0 };
    let targets = targets(setup.unknowns, &fit.solution.x);
    let doubtful = targets.iter().zip(&statistics.terms).filter(|(_, term)| is_doubtful(term));
    doubtful.flat_map(|(target, _)| profiler.prefetch(target)).collect()
}

/// Profiles of a fit.
///
/// # Errors
/// When the user asked to stop.
pub fn profiles(
    setup: Setup,
    fit: &Fit,
    statistics: &Statistics,
    evaluations: usize,
    asked: &[String],
) -> Result<Vec<ProfileRow>, EvaluationFailure> {
    let profiler = Profiler { setup, fit, statistics, evaluations };
    let targets = targets(setup.unknowns, &fit.solution.x);
    let is_doubtful =
        |k: usize| is_automatic(setup, asked) && statistics.terms.get(k).is_some_and(is_doubtful);
    let is_asked = |target: &Target| asked.iter().any(|name| target.is_called(name));
    let profiler = &profiler;
    let task = |(k, target): (usize, _)| {
        let is_wanted = is_doubtful(k) && !is_asked(target);
        move || is_wanted.then(|| profiler.swift(target))
    };
    let swift: Vec<Option<Result<Profile, EvaluationFailure>>> =
        side_by_side(targets.iter().enumerate().map(task));
    let mut rows = Vec::new();
    for (k, (target, swift)) in targets.iter().zip(swift).enumerate() {
        if is_asked(target) {
            rows.push(row(target, &profiler.profile(target)?, statistics, true));
        } else if let Some(profile) = swift {
            let found = row(target, &profile?, statistics, false);
            if differs(&found, &statistics.terms[k]) {
                rows.push(found);
            }
        }
    }
    Ok(rows)
}

/// Ends that differ by a smaller part of the interval are the same.
const SAME: f64 = 0.15;

/// Whether a profile says something else than the linearised interval.
fn differs(profile: &ProfileRow, linear: &ParameterEstimate) -> bool {
    let unit = &linear.parameter.unit;
    let internal = |v: f64| linear.parameter.to_internal(v);
    let ends = [(profile.lower, linear.interval.lower), (profile.upper, linear.interval.upper)];
    let apart = ends.iter().map(|(a, b)| (internal(a * unit.si) - internal(*b)).abs()).fold(0.0, f64::max);
    let width = (internal(linear.interval.upper) - internal(linear.interval.lower)).abs();
    profile.open != linear.open || apart > SAME * width
}

fn row(target: &Target, profile: &Profile, statistics: &Statistics, asked: bool) -> ProfileRow {
    let p: &FitParameter = &target.parameter;
    let shown = |q: f64| p.unit.from_si(p.to_value(target.at + q));
    let (low, high) = p.internal_bounds();
    let ends = [
        profile.ends[0].map(|q| (target.at + q).max(low)),
        profile.ends[1].map(|q| (target.at + q).min(high)),
    ];
    let at = |end: Option<f64>, bound: f64| p.unit.from_si(p.to_value(end.unwrap_or(bound)));
    let (a, b) = (at(ends[0], low), at(ends[1], high));
    let mut open = ends.map(|end| end.is_none());
    if a > b {
        open.swap(0, 1);
    }
    ProfileRow {
        name: p.name.clone(),
        symbol: p.symbol.clone(),
        unit: p.unit.name.clone(),
        value: shown(0.0),
        lower: a.min(b),
        upper: a.max(b),
        open,
        threshold: statistics.quantile(&target.gradient).powi(2),
        points: profile.points.iter().map(|(q, rise)| [shown(*q), *rise]).collect(),
        asked,
    }
}
