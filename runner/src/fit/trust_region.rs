//! Trust-region-reflective least squares within bounds.
//!
//! Coleman-Li scaling turns the bounds into a change of variables, the subproblem is solved exactly by SVD,
//! steps that leave the box are reflected at it (Branch, Coleman and Li 1999; the method behind SciPy's
//! `trf`). What is added: a failed evaluation shrinks the region, every iteration is reported, and the fit
//! can be stopped at any time with its best point.

use super::coleman_li;
use super::correction::{Correction, POOR, Trial};
use super::options::{Options, Scaling};
use super::problem::{Bounds, EvaluationFailure, FitError, Problem};
use super::solution::{IterationRecord, Solution, StopReason};
use super::step::ScaledModel;
use super::subproblem::Decomposition;
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;

/// Where a step gains more than this part of what was predicted of it, the next one may be longer.
const GOOD: f64 = 0.75;
/// A quarter of a step misses what was predicted of it by a sixteenth of what the whole step does, where residuals are smooth, and by a
/// quarter where the Jacobian is wrong. Where it misses by more than this part, residuals jump in between: no shorter step is worth more.
const NOISY: f64 = 0.5;
/// Such a jump is a small part of what is left: hayes_relax_2 has jumps of 0.15. A step that misses by more leads where the model bends away
/// from its tangent, and so may a quarter of it.
const JUMP: f64 = 0.25;

/// A point with residuals and Jacobian.
pub(super) struct Point {
    pub x: DVector<f64>,
    pub f: DVector<f64>,
    jacobian: DMatrix<f64>,
    pub cost: f64,
}

/// Counters and records.
pub(super) struct Log {
    iterations: Vec<IterationRecord>,
    pub evaluations: usize,
    jacobians: usize,
    failures: Vec<String>,
    consecutive_failures: usize,
}

/// Minimises `|r(x)|^2` within `bounds` from `start`. `observe` sees the start and every accepted step and may
/// stop the fit.
///
/// # Errors
/// When the start is outside the bounds or cannot be evaluated. Everything later is in [`Solution::stop`].
pub fn minimise<P: Problem + ?Sized>(
    problem: &mut P,
    start: &[f64],
    bounds: &Bounds,
    options: &Options,
    observe: &mut dyn FnMut(&IterationRecord) -> ControlFlow<()>,
) -> Result<Solution, FitError> {
    let n = problem.dimension();
    if start.len() != n {
        return Err(FitError::Dimension { what: "start", expected: n, found: start.len() });
    }
    bounds.check_start(start)?;
    let mut log =
        Log { iterations: vec![], evaluations: 0, jacobians: 0, failures: vec![], consecutive_failures: 0 };
    let mut point = first_point(problem, bounds.interior(start, 1e-10), &mut log)?;
    let initial_cost = point.cost;
    let mut scale = column_scale(&point.jacobian, options.scaling, None);
    let mut radius = options.initial_radius.unwrap_or_else(|| initial_radius(&point, bounds, &scale));
    let mut alpha = 0.0;
    let mut optimality = point_optimality(&point, bounds);
    log.record(&point, 0.0, 0.0, radius, optimality);
    if let Some(last) = log.iterations.last()
        && observe(last).is_break()
    {
        return Ok(log.finish(point, StopReason::StopRequested));
    }

    // Whether the last step gained next to nothing.
    let mut creeps = false;
    loop {
        if optimality <= options.gradient_tolerance * initial_cost {
            return Ok(log.finish(point, StopReason::Gradient));
        }
        let region = (&mut radius, &mut alpha, creeps);
        let (accepted, outcome) = iterate(problem, &point, bounds, options, &scale, region, &mut log);
        if let Some((next, step_norm)) = accepted {
            let reduction = 2.0 * (point.cost - next.cost);
            creeps = reduction < 2.0 * options.chi_square_tolerance * point.cost;
            point = next;
            scale = column_scale(&point.jacobian, options.scaling, Some(&scale));
            optimality = point_optimality(&point, bounds);
            log.record(&point, reduction, step_norm, radius, optimality);
            if let Some(last) = log.iterations.last()
                && observe(last).is_break()
                && outcome.is_none()
            {
                return Ok(log.finish(point, StopReason::StopRequested));
            }
        }
        if let Some(stop) = outcome {
            return Ok(log.finish(point, stop));
        }
    }
}

type Accepted = Option<(Point, f64)>;

/// Tries steps of shrinking length from `point` until one is taken or the fit ends.
fn iterate<P: Problem + ?Sized>(
    problem: &mut P,
    point: &Point,
    bounds: &Bounds,
    options: &Options,
    scale: &DVector<f64>,
    (radius, alpha, creeps): (&mut f64, &mut f64, bool),
    log: &mut Log,
) -> (Accepted, Option<StopReason>) {
    let g = point.jacobian.tr_mul(&point.f);
    let (mut v, dv) = coleman_li::scaling(&point.x, &g, bounds);
    let optimality = v.component_mul(&g).amax();
    for i in 0..v.len() {
        if dv[i] != 0.0 {
            v[i] /= scale[i];
        }
    }
    let d = v.map(f64::sqrt).component_mul(scale);
    let diagonal = g.component_mul(&dv).component_mul(scale);
    let g_h = d.component_mul(&g);
    let mut j_h = point.jacobian.clone();
    for (j, mut column) in j_h.column_iter_mut().enumerate() {
        column *= d[j];
    }
    let decomposition = decompose(&j_h, &diagonal, &point.f, options.rank_tolerance);
    let model = ScaledModel {
        x: &point.x,
        d: &d,
        jacobian: &j_h,
        gradient: &g_h,
        diagonal: &diagonal,
        bounds,
        theta: (1.0 - optimality).max(0.995),
    };

    let mut rejected = false;
    // By how much the last rejected step missed what was predicted of it.
    let mut missed = f64::INFINITY;
    loop {
        if log.evaluations >= options.max_evaluations {
            return (None, Some(StopReason::EvaluationBudget));
        }
        let (p_h, new_alpha) = decomposition.solve(*radius, *alpha);
        *alpha = new_alpha;
        let step = model.choose(&p_h, *radius);
        let x_new = DVector::from_vec(bounds.interior((&point.x + &step.p).as_slice(), 0.0));
        let step_norm = (&x_new - &point.x).norm();
        let scaled_norm = step.p_scaled.norm();
        if step_norm <= f64::EPSILON * point.x.norm() {
            return (None, Some(StopReason::Step));
        }
        let is_full = scaled_norm <= 0.95 * *radius;
        let least = match (is_full, rejected) {
            (_, true) => options.noise_tolerance,
            (true, false) => options.foreseen_tolerance,
            (false, false) => 0.0,
        };
        if step.predicted < least * point.cost {
            return (None, Some(StopReason::ChiSquareChange));
        }
        let shrink = |radius: &mut f64, alpha: &mut f64| {
            let new = 0.25 * scaled_norm;
            *alpha *= *radius / new;
            *radius = new;
        };

        let f_new = match evaluate(problem, &x_new, log) {
            Ok(f) => f,
            Err(failure) => {
                problem.rejected(x_new.as_slice());
                shrink(radius, alpha);
                match log.stop_after(&failure, options) {
                    None => continue,
                    stop => return (None, stop),
                }
            }
        };
        let trial = Trial::new(x_new, f_new);
        let missing = trial.cost - (point.cost - step.predicted);
        let correction = Correction {
            model: &model,
            solver: (&decomposition, *alpha),
            step: &step,
            is_straight: step.p_scaled == p_h,
            here: point,
            most_evaluations: options.max_evaluations,
        };
        let trial = match correction.lead(problem, trial, log) {
            Ok(trial) => trial,
            Err(stop) => return (None, Some(stop)),
        };
        let Trial { x: x_new, f: f_new, cost: cost_new } = trial;
        let step_norm = (&x_new - &point.x).norm();
        let actual = point.cost - cost_new;
        let ratio = agreement(actual, step.predicted);
        let reductions = (actual, step.predicted);
        let may_grow = ratio > GOOD;
        // A step that the region cut short says nothing of how far the minimum is; but where the region does not grow the next one is no
        // longer, and where it has grown a second one would gain more.
        let tolerance = match (is_full, rejected) {
            (false, false) if may_grow && !creeps => 0.0,
            (false, true) => options.noise_tolerance,
            _ => options.chi_square_tolerance,
        };
        let outcome = termination(
            reductions,
            tolerance * point.cost,
            (step_norm, point.x.norm()),
            options.step_tolerance,
        );
        let old_radius = *radius;
        if ratio < POOR {
            *radius = 0.25 * scaled_norm;
        } else if may_grow && !is_full {
            *radius *= 2.0;
        }
        *alpha *= old_radius / *radius;

        if actual <= 0.0 {
            problem.rejected(x_new.as_slice());
            if outcome.is_some() {
                return (None, outcome);
            }
            if missing > NOISY * missed && missing < JUMP * point.cost {
                return (None, Some(StopReason::ChiSquareChange));
            }
            (rejected, missed) = (true, missing);
            continue;
        }
        match differentiate(problem, &x_new, &f_new, log) {
            Ok(jacobian) => {
                let next = Point { x: x_new, f: f_new, jacobian, cost: cost_new };
                return (Some((next, step_norm)), outcome);
            }
            Err(failure) => {
                problem.rejected(x_new.as_slice());
                shrink(radius, alpha);
                if let stop @ Some(_) = log.stop_after(&failure, options) {
                    return (None, stop);
                }
            }
        }
    }
}

fn first_point<P: Problem + ?Sized>(problem: &mut P, x: Vec<f64>, log: &mut Log) -> Result<Point, FitError> {
    let fatal = |failure| match failure {
        EvaluationFailure::Failed(reason) => FitError::StartFailed(reason),
        EvaluationFailure::Interrupted => FitError::Interrupted,
    };
    let x = DVector::from_vec(x);
    let f = evaluate(problem, &x, log).map_err(fatal)?;
    let jacobian = differentiate(problem, &x, &f, log).map_err(fatal)?;
    let cost = 0.5 * f.norm_squared();
    Ok(Point { x, f, jacobian, cost })
}

pub(super) fn evaluate<P: Problem + ?Sized>(
    problem: &mut P,
    x: &DVector<f64>,
    log: &mut Log,
) -> Result<DVector<f64>, EvaluationFailure> {
    problem.prefetch(&[x.as_slice().to_vec()]);
    let result = problem.residual(x.as_slice()).and_then(|r| {
        if r.iter().all(|v| v.is_finite()) {
            Ok(DVector::from_vec(r))
        } else {
            Err(EvaluationFailure::Failed("a residual is not a finite number".to_owned()))
        }
    });
    log.evaluations += 1;
    log.note(result)
}

fn differentiate<P: Problem + ?Sized>(
    problem: &mut P,
    x: &DVector<f64>,
    f: &DVector<f64>,
    log: &mut Log,
) -> Result<DMatrix<f64>, EvaluationFailure> {
    let result = problem.jacobian(x.as_slice(), f.as_slice()).and_then(|j| {
        if j.shape() != (f.len(), x.len()) {
            let (rows, columns) = j.shape();
            let needed = (f.len(), x.len());
            Err(EvaluationFailure::Failed(format!("Jacobian is {rows} x {columns}, not {needed:?}")))
        } else if j.iter().all(|v| v.is_finite()) {
            Ok(j)
        } else {
            Err(EvaluationFailure::Failed("a derivative is not a finite number".to_owned()))
        }
    });
    log.jacobians += 1;
    log.note(result)
}

/// SVD of the Jacobian with the bounds' diagonal below it.
fn decompose(
    j_h: &DMatrix<f64>,
    diagonal: &DVector<f64>,
    f: &DVector<f64>,
    rank_tolerance: f64,
) -> Decomposition {
    let (m, n) = j_h.shape();
    let mut augmented = DMatrix::zeros(m + n, n);
    augmented.view_mut((0, 0), (m, n)).copy_from(j_h);
    for i in 0..n {
        augmented[(m + i, i)] = diagonal[i].max(0.0).sqrt();
    }
    let mut rhs = DVector::zeros(m + n);
    rhs.rows_mut(0, m).copy_from(f);
    Decomposition::new(augmented, &rhs, rank_tolerance)
}

fn initial_radius(point: &Point, bounds: &Bounds, scale: &DVector<f64>) -> f64 {
    let g = point.jacobian.tr_mul(&point.f);
    let (v, _) = coleman_li::scaling(&point.x, &g, bounds);
    let norm = DVector::from_fn(v.len(), |i, _| point.x[i] / (scale[i] * v[i].sqrt())).norm();
    if norm > 0.0 && norm.is_finite() { norm } else { 1.0 }
}

fn point_optimality(point: &Point, bounds: &Bounds) -> f64 {
    let g = point.jacobian.tr_mul(&point.f);
    let (v, _) = coleman_li::scaling(&point.x, &g, bounds);
    v.component_mul(&g).amax()
}

fn column_scale(jacobian: &DMatrix<f64>, scaling: Scaling, previous: Option<&DVector<f64>>) -> DVector<f64> {
    let column = |j: usize| match scaling {
        Scaling::Unit => 1.0,
        Scaling::Jacobian => {
            let norm = jacobian.column(j).norm();
            let own = if norm > 0.0 { 1.0 / norm } else { 1.0 };
            previous.map_or(own, |p| own.min(p[j]))
        }
    };
    DVector::from_fn(jacobian.ncols(), |j, _| column(j))
}

/// Actual over predicted reduction; 1 when both vanish.
pub(super) fn agreement(actual: f64, predicted: f64) -> f64 {
    if predicted > 0.0 {
        actual / predicted
    } else if actual == 0.0 && predicted == 0.0 {
        1.0
    } else {
        0.0
    }
}

/// chi^2 counts as settled when its change is small and either the quadratic model foresaw it, or foresaw no
/// more: with noise in the Jacobian the two need not agree on a change that means nothing.
fn termination(
    (actual, predicted): (f64, f64),
    small: f64,
    (step_norm, x_norm): (f64, f64),
    step_tolerance: f64,
) -> Option<StopReason> {
    let chi_square = actual.abs() < small && (agreement(actual, predicted) > 0.25 || predicted < small);
    let step = step_norm < step_tolerance * (step_tolerance + x_norm);
    match (chi_square, step) {
        (true, true) => Some(StopReason::ChiSquareChangeAndStep),
        (true, false) => Some(StopReason::ChiSquareChange),
        (false, true) => Some(StopReason::Step),
        (false, false) => None,
    }
}

impl Log {
    /// Whether a failure ends the fit.
    fn stop_after(&self, failure: &EvaluationFailure, options: &Options) -> Option<StopReason> {
        match failure {
            EvaluationFailure::Interrupted => Some(StopReason::StopRequested),
            EvaluationFailure::Failed(_) => (self.consecutive_failures >= options.max_consecutive_failures)
                .then_some(StopReason::TooManyFailures),
        }
    }

    fn note<T>(&mut self, result: Result<T, EvaluationFailure>) -> Result<T, EvaluationFailure> {
        match &result {
            Ok(_) => self.consecutive_failures = 0,
            Err(EvaluationFailure::Failed(reason)) => {
                self.consecutive_failures += 1;
                self.failures.push(reason.clone());
            }
            Err(EvaluationFailure::Interrupted) => {}
        }
        result
    }

    fn record(&mut self, point: &Point, reduction: f64, step_norm: f64, radius: f64, optimality: f64) {
        self.iterations.push(IterationRecord {
            iteration: self.iterations.len(),
            evaluations: self.evaluations,
            failures: self.failures.len(),
            chi_square: 2.0 * point.cost,
            reduction,
            step_norm,
            radius,
            optimality,
            x: point.x.as_slice().to_vec(),
        });
    }

    fn finish(self, point: Point, stop: StopReason) -> Solution {
        Solution {
            x: point.x.as_slice().to_vec(),
            residual: point.f.as_slice().to_vec(),
            jacobian: point.jacobian,
            chi_square: 2.0 * point.cost,
            stop,
            iterations: self.iterations,
            evaluations: self.evaluations,
            jacobians: self.jacobians,
            failures: self.failures,
        }
    }
}

#[cfg(test)]
#[path = "trust_region_tests.rs"]
mod tests;
