//! Newton iteration with line search, its linear systems solved only as accurately as it pays.

use super::linear::FrozenSolver;
use crate::outputs::Statistics;
use crate::solver::newton::{NewtonFailure, System};
use crate::solver::pattern::CscPattern;

const MAX_ITERATIONS: usize = 25;
const MAX_HALVINGS: usize = 6;
/// A full step is taken unless the residual hardly falls.
const SUFFICIENT: f64 = 0.9;
/// Loosest reduction of a linear residual.
const LOOSEST: f64 = 1e-2;

/// Vectors of the iteration, allocated once.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    residual: Vec<f64>,
    values: Vec<f64>,
    correction: Vec<f64>,
    trial: Vec<f64>,
}

impl Workspace {
    /// For `unknowns` and `entries` of the tangent.
    pub fn new(unknowns: usize, entries: usize) -> Self {
        let zeros = || vec![0.0; unknowns];
        Self { residual: zeros(), values: vec![0.0; entries], correction: zeros(), trial: zeros() }
    }
}

/// Iterates `x` to a residual norm below `tolerance`; returns the norms of all iterations.
///
/// `fixed` marks the constrained unknowns.
///
/// # Errors
/// The reason why there is no solution; `x` is then undefined.
#[allow(clippy::too_many_arguments)]
pub fn solve(
    system: &mut impl System,
    linear: &mut FrozenSolver,
    pattern: &CscPattern,
    fixed: &[bool],
    work: &mut Workspace,
    x: &mut [f64],
    tolerance: f64,
    statistics: &mut Statistics,
) -> Result<Vec<f64>, NewtonFailure> {
    let Workspace { residual, values, correction, trial } = work;
    let mut norm = system.evaluate(x, residual, values).map_err(NewtonFailure::Inadmissible)?;
    let mut norms = vec![norm];
    // The starting point need not satisfy the Dirichlet conditions: the first correction imposes them.
    let mut constrained = false;
    for iteration in 0..MAX_ITERATIONS {
        if constrained && norm <= tolerance {
            return Ok(norms);
        }
        statistics.iterations += 1;
        correction.copy_from_slice(residual);
        // The quadratic remainder is about ten times the squared norm: what is smaller need not be solved.
        let reduction = (3.0 * norm).clamp(1e-12, LOOSEST).max((0.2 * tolerance / norm).min(LOOSEST));
        linear
            .solve(pattern, values, fixed, correction, reduction, statistics)
            .map_err(|_| NewtonFailure::Singular(iteration))?;
        for (c, s) in correction.iter_mut().zip(system.scale()) {
            *c *= s;
        }
        if !correction.iter().all(|c| c.is_finite()) {
            return Err(NewtonFailure::Singular(iteration));
        }
        let (mut step, mut halvings) = (1.0, 0);
        norm = loop {
            for ((t, x), c) in trial.iter_mut().zip(x.iter()).zip(correction.iter()) {
                *t = x - step * c;
            }
            let last = halvings == MAX_HALVINGS;
            match system.evaluate(trial, residual, values) {
                // The first, constraint-imposing step may raise the residual.
                Ok(n) if n.is_finite() && (n <= SUFFICIENT * norm || !constrained || n <= tolerance) => {
                    break n;
                }
                Ok(n) if n.is_finite() && last && n < norm => break n,
                Err(element) if last || !constrained => return Err(NewtonFailure::Inadmissible(element)),
                _ if last => {
                    return Err(NewtonFailure::NotConverged { iterations: iteration, residual: norm });
                }
                _ => {}
            }
            halvings += 1;
            step *= 0.5;
        };
        constrained = true;
        x.copy_from_slice(trial);
        norms.push(norm);
    }
    if norm <= tolerance {
        return Ok(norms);
    }
    Err(NewtonFailure::NotConverged { iterations: MAX_ITERATIONS, residual: norm })
}
