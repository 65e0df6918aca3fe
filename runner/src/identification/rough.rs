//! A fit by a rough model, corrected by runs of the model asked for.
//!
//! The rough model - coarsest mesh, steps and residuals as accurate as it is - differs by a per cent of the force and costs a
//! fraction. It is fitted; then the difference of the two models at the solution is added to its residuals as it is, and the fit
//! goes on, until a run of the model asked for gives what the corrected rough one foresees (space mapping: Bandler et al. 1994).
//! The solution is that of the model asked for; derivatives, whose errors only slow the iteration, are the rough one's.

use super::{FitOptions, Identification, curves, directly, trust_region};
use crate::engine::Engine;
use crate::fit::trust_region::minimise;
use crate::fit::{EvaluationFailure, FitError, IterationRecord, Problem, Solution, StopReason};
use crate::objective::{Dataset, Objective, ParameterMap};
use nalgebra::DMatrix;
use std::ops::ControlFlow;

const ROUGH: [(&str, f64); 3] =
    [("mesh.preset", 1.0), ("solver.tolerance", 1e-2), ("solver.newton_tolerance", 1e-6)];
/// Such a part of chi^2 is less than what the rough model is wrong by.
const FIRST_GAIN: f64 = 1e-2;
/// Corrected, an iteration is worth its runs where it lowers chi^2 by this part: a tenth of a point of a hundred.
const CORRECTED_GAIN: f64 = 1e-3;
/// The fit has settled where the corrected model foresees the other one, the sum of their squared differences being below this part
/// of chi^2, or where a correction has lowered the other one's chi^2 by less than that.
const SETTLED: f64 = 1e-2;
/// Corrections shrink the difference by a factor of ten or more each; where so many do not suffice, something else is wrong.
const MOST_CORRECTIONS: usize = 4;

/// Whether the model has a rough twin: it is poropunch's own, and nothing of what makes it rough was chosen.
pub fn applies(engine: &Engine, parameters: &ParameterMap) -> bool {
    let chosen = |name: &String| name.starts_with("mesh.") || name.starts_with("solver.");
    engine.is_own() && !parameters.fixed().keys().any(chosen)
}

/// Fits; by runs of the model asked for alone where the rough one leads nowhere.
///
/// # Errors
/// When no start can be evaluated.
pub fn identify(
    engine: &Engine,
    datasets: &[Dataset],
    parameters: &ParameterMap,
    options: &FitOptions,
    observe: &mut dyn FnMut(usize, &IterationRecord),
) -> Result<Identification, FitError> {
    let rough = parameters.clone().with_fixed(&ROUGH);
    let first = FitOptions { least_gain: Some(FIRST_GAIN), ..options.clone() };
    let Ok(mut found) = directly(engine, datasets, &rough, &first, observe) else {
        return directly(engine, datasets, parameters, options, observe);
    };
    let start = found.search.best.x.clone();
    let best_start = found.search.best_start;
    let mut watch = |record: &IterationRecord| {
        observe(best_start, record);
        if engine.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let mut twin =
        Corrected { rough: Objective::new(engine, datasets, &rough, options.step), offset: vec![] };
    let trust =
        trust_region(&twin.rough, &FitOptions { least_gain: Some(CORRECTED_GAIN), ..options.clone() });
    let sum = |residual: &[f64]| residual.iter().map(|r| r * r).sum::<f64>();
    let mut asked = residuals(engine, datasets, parameters, &start);
    for _ in 0..MOST_CORRECTIONS {
        let Some(residual) = asked.filter(|_| found.search.best.stop != StopReason::StopRequested) else {
            break;
        };
        let before = sum(&residual);
        twin.correct(&found.search.best, &residual);
        let best =
            minimise(&mut twin, &found.search.best.x, parameters.optimiser_bounds(), &trust, &mut watch)?;
        found.search.best = after(best, &found.search.best);
        asked = residuals(engine, datasets, parameters, &found.search.best.x);
        let Some(residual) = asked.as_ref() else { break };
        let differences = residual.iter().zip(&found.search.best.residual).map(|(a, b)| (a - b).powi(2));
        let (differences, chi_square) = (differences.sum::<f64>(), sum(residual));
        let little = SETTLED * chi_square;
        if differences <= little || (0.0..=little).contains(&(before - chi_square)) {
            let best = &mut found.search.best;
            best.residual.clone_from(residual);
            best.chi_square = chi_square;
            found.values = parameters.settings(&best.x);
            found.failed_points += twin.rough.failed();
            return Ok(found);
        }
    }
    // A stop asked for in a run of the model asked for leaves the corrected rough model's best point.
    if engine.is_stopped() {
        found.search.best.stop = StopReason::StopRequested;
    }
    if found.search.best.stop == StopReason::StopRequested {
        found.values = parameters.settings(&found.search.best.x);
        return Ok(found);
    }
    let start = parameters.clone().starting_at(&found.search.best.x);
    directly(engine, datasets, &start, options, observe)
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

/// Residuals of the model asked for; none where it fails.
fn residuals(
    engine: &Engine,
    datasets: &[Dataset],
    parameters: &ParameterMap,
    x: &[f64],
) -> Option<Vec<f64>> {
    let mut all = Vec::new();
    for (dataset, curve) in datasets.iter().zip(curves(engine, datasets, &parameters.settings(x))) {
        dataset.append_residuals(&*curve.ok()?, &mut all);
    }
    Some(all)
}

/// The rough model with what the other one differed by at one point.
struct Corrected<'a> {
    rough: Objective<'a>,
    offset: Vec<f64>,
}

impl Corrected<'_> {
    /// Makes the residuals at a solution of this problem those of the model asked for.
    fn correct(&mut self, at: &Solution, asked: &[f64]) {
        self.offset.resize(asked.len(), 0.0);
        for (offset, (asked, had)) in self.offset.iter_mut().zip(asked.iter().zip(&at.residual)) {
            *offset += asked - had;
        }
    }
}

impl Problem for Corrected<'_> {
    fn dimension(&self) -> usize {
        self.rough.dimension()
    }

    fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
        let residual = self.rough.residual(x)?;
        Ok(residual.iter().zip(&self.offset).map(|(r, offset)| r + offset).collect())
    }

    fn jacobian(&mut self, x: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
        let rough: Vec<f64> = r.iter().zip(&self.offset).map(|(r, offset)| r - offset).collect();
        self.rough.jacobian(x, &rough)
    }

    fn prefetch(&mut self, points: &[Vec<f64>]) {
        self.rough.prefetch(points);
    }

    fn rejected(&mut self, x: &[f64]) {
        self.rough.rejected(x);
    }
}
