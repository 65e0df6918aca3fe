//! Newton iteration with line search for one implicit stage.

use super::broyden::Secants;
use super::linear::Singular;
use crate::outputs::Statistics;
use thiserror::Error;

const MAX_ITERATIONS: usize = 25;
const MAX_HALVINGS: usize = 6;
/// Corrections below this fraction of the unknowns' units no longer matter: one that cannot lower the
/// residual any more is rounding, and the iteration has converged.
const NEGLIGIBLE: f64 = 1e-7;
/// Armijo-like factor: a full step is taken unless the residual hardly falls.
const SUFFICIENT: f64 = 0.9;
/// A new tangent and its factors cost as much as this many corrections with old ones.
const CORRECTIONS: i32 = 5;

/// Why an iteration ended without a solution.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NewtonFailure {
    /// The starting point cannot be evaluated.
    #[error("element {0} is turned inside out, compacted or strained beyond the material's range")]
    Inadmissible(usize),
    /// The tangent is singular.
    #[error("the tangent is singular in iteration {0}")]
    Singular(usize),
    /// A state to step from that another discretisation made.
    #[error("the state belongs to another discretisation")]
    ForeignState,
    /// The set of nodes in contact keeps changing.
    #[error("the contact with the punch does not settle")]
    Contact,
    /// The residual did not fall below the tolerance.
    #[error("the scaled residual stays at {residual:.1e} after {iterations} iterations")]
    NotConverged {
        /// Iterations made.
        iterations: usize,
        /// Norm of the scaled residual.
        residual: f64,
    },
}

/// From where to where the residual's unconstrained part shall fall: an iterative solver need not do more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aim {
    /// Norm at present.
    pub norm: f64,
    /// Norm that is as good as none.
    pub tolerance: f64,
}

/// A system of equations with Dirichlet conditions; residual and tangent are dimensionless.
pub trait System {
    /// Residual at `x`, and the tangent's values where they are asked for; rows of constrained unknowns hold
    /// `(x - prescribed) / scale` and the identity. Returns the norm of the unconstrained part of the residual.
    ///
    /// # Errors
    /// The element that cannot be evaluated.
    fn evaluate(&mut self, x: &[f64], residual: &mut [f64], values: Option<&mut [f64]>)
    -> Result<f64, usize>;

    /// Solves the linear system in place for a correction; `correction` holds the residual.
    ///
    /// # Errors
    /// When the tangent is singular.
    fn correct(&mut self, values: &[f64], correction: &mut [f64], aim: Aim) -> Result<(), Singular>;

    /// Whether the last tangent's factors can be used again, by [`Self::correct_again`].
    const KEEPS_FACTORS: bool = false;

    /// The same as [`Self::correct`] with these factors, as far as they go.
    ///
    /// # Errors
    /// Where there are none.
    fn correct_again(&mut self, _correction: &mut [f64]) -> Result<(), Singular> {
        Err(Singular)
    }

    /// Units of the unknowns: a correction is the solution of the scaled system times these.
    fn scale(&self) -> &[f64];

    /// Where its work is counted.
    fn statistics(&mut self) -> &mut Statistics;
}

/// Vectors of the iteration, allocated once.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    residual: Vec<f64>,
    values: Vec<f64>,
    correction: Vec<f64>,
    trial: Vec<f64>,
    secants: Secants,
    /// Where the solution began.
    start: Vec<f64>,
    /// Whether a solution since the start was corrected by old factors.
    used_factors_again: bool,
}

impl Workspace {
    /// For `unknowns` and `entries` of the tangent.
    pub fn new(unknowns: usize, entries: usize) -> Self {
        let zeros = || vec![0.0; unknowns];
        let values = vec![0.0; entries];
        let secants = Secants::default();
        Self {
            residual: zeros(),
            values,
            correction: zeros(),
            trial: zeros(),
            secants,
            start: zeros(),
            used_factors_again: false,
        }
    }

    /// Values of the dimensionless tangent where it was evaluated last.
    pub fn tangent(&self) -> &[f64] {
        &self.values
    }

    /// Residual and tangent of a system; returns the norm.
    ///
    /// # Errors
    /// The element that cannot be evaluated.
    pub fn evaluate(&mut self, system: &mut impl System, x: &[f64]) -> Result<f64, usize> {
        system.evaluate(x, &mut self.residual, Some(&mut self.values))
    }
}

/// Iterates `x` to a residual norm below `tolerance`; returns the norms of all iterations.
///
/// Where a system keeps its factors, the corrections after that with a new tangent are made with the same factors as long as these
/// lead to the solution soon (simplified Newton iteration); where that fails, Newton's method begins anew with a tangent for each.
/// The system was evaluated last at the solution.
///
/// # Errors
/// The reason why there is no solution; `x` is then undefined.
pub fn solve<S: System>(
    system: &mut S,
    work: &mut Workspace,
    x: &mut [f64],
    tolerance: f64,
) -> Result<Vec<f64>, NewtonFailure> {
    work.start.copy_from_slice(x);
    work.used_factors_again = false;
    iterate(system, work, x, tolerance, S::KEEPS_FACTORS).or_else(|failure| {
        if !work.used_factors_again {
            return Err(failure);
        }
        x.copy_from_slice(&work.start);
        iterate(system, work, x, tolerance, false)
    })
}

/// One iteration from `x`, which may use factors again or not.
fn iterate<S: System>(
    system: &mut S,
    work: &mut Workspace,
    x: &mut [f64],
    tolerance: f64,
    may_use_factors_again: bool,
) -> Result<Vec<f64>, NewtonFailure> {
    let mut norm = work.evaluate(system, x).map_err(NewtonFailure::Inadmissible)?;
    let mut norms = vec![norm];
    // The starting point need not satisfy the Dirichlet conditions: the first correction imposes them.
    let mut constrained = false;
    for iteration in 0..MAX_ITERATIONS {
        if constrained && norm <= tolerance {
            return Ok(norms);
        }
        if may_use_factors_again && iteration > 0 {
            norm = work.evaluate(system, x).map_err(NewtonFailure::Inadmissible)?;
        }
        let Workspace { residual, values, correction, trial, secants, .. } = work;
        system.statistics().iterations += 1;
        correction.copy_from_slice(residual);
        system
            .correct(values, correction, Aim { norm, tolerance })
            .map_err(|_| NewtonFailure::Singular(iteration))?;
        let largest = correction.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let negligible = constrained && largest <= NEGLIGIBLE;
        if may_use_factors_again {
            secants.clear();
            secants.note(correction);
        }
        for (c, s) in correction.iter_mut().zip(system.scale()) {
            *c *= s;
        }
        if !correction.iter().all(|c| c.is_finite()) {
            return Err(NewtonFailure::Singular(iteration));
        }
        let mut step = 1.0;
        let mut halvings = 0;
        norm = loop {
            for ((t, x), c) in trial.iter_mut().zip(x.iter()).zip(correction.iter()) {
                *t = x - step * c;
            }
            // The next corrections may do without the tangent.
            let tangent = (!may_use_factors_again).then_some(&mut values[..]);
            let evaluated = system.evaluate(trial, residual, tangent);
            let last = halvings == MAX_HALVINGS;
            match evaluated {
                // The first, constraint-imposing step may raise the residual.
                Ok(n) if n.is_finite() && (n <= SUFFICIENT * norm || !constrained || n <= tolerance) => {
                    break n;
                }
                Ok(n) if n.is_finite() && last && n < norm => break n,
                Ok(n) if n.is_finite() && negligible => {
                    // What is read from the system shall be the solution's, not the trial's.
                    system.evaluate(x, residual, Some(values)).map_err(NewtonFailure::Inadmissible)?;
                    return Ok(norms);
                }
                Err(element) if last || !constrained => return Err(NewtonFailure::Inadmissible(element)),
                _ if last => {
                    return Err(NewtonFailure::NotConverged { iterations: iteration, residual: norm });
                }
                _ => {}
            }
            halvings += 1;
            step *= 0.5;
            secants.clear();
        };
        constrained = true;
        x.copy_from_slice(trial);
        norms.push(norm);
        if may_use_factors_again {
            norm = correct_again(system, work, x, &mut norms, tolerance)?;
        }
    }
    if norm <= tolerance {
        return Ok(norms);
    }
    Err(NewtonFailure::NotConverged { iterations: MAX_ITERATIONS, residual: norm })
}

/// Corrects `x` with the factors that there are, as long as they lead to the solution soon; returns the last norm.
fn correct_again(
    system: &mut impl System,
    work: &mut Workspace,
    x: &mut [f64],
    norms: &mut Vec<f64>,
    tolerance: f64,
) -> Result<f64, NewtonFailure> {
    let Workspace { residual, correction, trial, secants, used_factors_again, .. } = work;
    let mut norm = norms.last().copied().unwrap_or(f64::INFINITY);
    while norm > tolerance {
        correction.copy_from_slice(residual);
        system.correct_again(correction).map_err(|_| NewtonFailure::Singular(norms.len()))?;
        if !secants.improve(correction) {
            break;
        }
        secants.note(correction);
        system.statistics().iterations += 1;
        for (((t, x), c), scale) in trial.iter_mut().zip(x.iter()).zip(correction.iter()).zip(system.scale())
        {
            *t = x - scale * c;
        }
        match system.evaluate(trial, residual, None) {
            Ok(next) if next <= tolerance.max(SUFFICIENT * norm) => {
                let is_soon = leads_soon(norm, next, tolerance);
                norm = next;
                *used_factors_again = true;
                x.copy_from_slice(trial);
                norms.push(norm);
                if !is_soon {
                    break;
                }
            }
            _ => break,
        }
    }
    Ok(norm)
}

/// Whether a few more corrections that each lower the residual as the last one did, from `before` to `norm`, end below the tolerance.
fn leads_soon(before: f64, norm: f64, tolerance: f64) -> bool {
    norm * (norm / before).powi(CORRECTIONS) <= tolerance
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `x = 0` with a residual that rounding keeps at 1e-8; knows where it was evaluated last.
    struct Rounded {
        evaluated: f64,
        statistics: Statistics,
    }

    impl System for Rounded {
        fn evaluate(
            &mut self,
            x: &[f64],
            residual: &mut [f64],
            values: Option<&mut [f64]>,
        ) -> Result<f64, usize> {
            self.evaluated = x[0];
            residual[0] = if x[0].abs() > 1e-6 { x[0] } else { 1e-8_f64.copysign(x[0]) };
            if let Some(values) = values {
                values[0] = 1.0;
            }
            Ok(residual[0].abs())
        }

        fn correct(&mut self, values: &[f64], correction: &mut [f64], _: Aim) -> Result<(), Singular> {
            correction[0] /= values[0];
            Ok(())
        }

        fn scale(&self) -> &[f64] {
            &[1.0]
        }

        fn statistics(&mut self) -> &mut Statistics {
            &mut self.statistics
        }
    }

    /// Reaction and tangent are read from the system and the workspace after the iteration.
    #[test]
    fn the_last_evaluation_is_that_of_the_solution() {
        let mut system = Rounded { evaluated: f64::NAN, statistics: Statistics::default() };
        let (mut work, mut x) = (Workspace::new(1, 1), [1.0]);
        solve(&mut system, &mut work, &mut x, 1e-12).unwrap();
        assert_eq!(system.statistics.iterations, 2, "the iteration must end by a negligible correction");
        assert_eq!(system.evaluated, x[0]);
    }

    /// `x + bend x^2 = 1` twice, coupled weakly; knows how often its tangent was factorised.
    struct Bent {
        bend: f64,
        factors: [f64; 2],
        factorisations: usize,
        statistics: Statistics,
    }

    impl System for Bent {
        fn evaluate(
            &mut self,
            x: &[f64],
            residual: &mut [f64],
            values: Option<&mut [f64]>,
        ) -> Result<f64, usize> {
            let row = |i: usize| x[i] + self.bend * x[i] * x[i] + 1e-2 * x[1 - i] * x[1 - i] - 1.0;
            (residual[0], residual[1]) = (row(0), row(1));
            if let Some(values) = values {
                values.copy_from_slice(&[1.0 + 2.0 * self.bend * x[0], 1.0 + 2.0 * self.bend * x[1]]);
            }
            Ok(residual[0].hypot(residual[1]))
        }

        fn correct(&mut self, values: &[f64], correction: &mut [f64], _: Aim) -> Result<(), Singular> {
            self.factorisations += 1;
            self.factors.copy_from_slice(values);
            self.correct_again(correction)
        }

        const KEEPS_FACTORS: bool = true;

        fn correct_again(&mut self, correction: &mut [f64]) -> Result<(), Singular> {
            correction.iter_mut().zip(self.factors).for_each(|(c, factor)| *c /= factor);
            Ok(())
        }

        fn scale(&self) -> &[f64] {
            &[1.0, 1.0]
        }

        fn statistics(&mut self) -> &mut Statistics {
            &mut self.statistics
        }
    }

    /// Iterations and factorisations until 1e-9, from a distance.
    fn solved(bend: f64, from: f64) -> (u64, usize) {
        let statistics = Statistics::default();
        let mut system = Bent { bend, factors: [f64::NAN; 2], factorisations: 0, statistics };
        let (mut work, mut x) = (Workspace::new(2, 2), [from, from]);
        let norms = solve(&mut system, &mut work, &mut x, 1e-9).unwrap();
        let mut residual = [0.0; 2];
        assert!(system.evaluate(&x, &mut residual, None).unwrap() <= 1e-9, "{norms:?}");
        (system.statistics.iterations, system.factorisations)
    }

    #[test]
    fn near_the_solution_one_factorisation_serves_all_corrections() {
        let (iterations, factorisations) = solved(0.1, 0.9);
        assert_eq!(factorisations, 1);
        assert!((3..=6).contains(&iterations), "{iterations}");
    }

    #[test]
    fn factors_that_lead_nowhere_soon_are_replaced() {
        let (iterations, factorisations) = solved(10.0, 5.0);
        assert!((2..iterations as usize).contains(&factorisations), "{factorisations} of {iterations}");
    }
}
