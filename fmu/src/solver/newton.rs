//! Newton iteration with line search for one implicit stage.

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
    /// Residual and tangent values at `x`; rows of constrained unknowns hold `(x - prescribed) / scale`
    /// and the identity. Returns the norm of the unconstrained part of the residual.
    ///
    /// # Errors
    /// The element that cannot be evaluated.
    fn evaluate(&mut self, x: &[f64], residual: &mut [f64], values: &mut [f64]) -> Result<f64, usize>;

    /// Solves the linear system in place for a correction; `correction` holds the residual.
    ///
    /// # Errors
    /// When the tangent is singular.
    fn correct(&mut self, values: &[f64], correction: &mut [f64], aim: Aim) -> Result<(), Singular>;

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
}

impl Workspace {
    /// For `unknowns` and `entries` of the tangent.
    pub fn new(unknowns: usize, entries: usize) -> Self {
        let zeros = || vec![0.0; unknowns];
        Self { residual: zeros(), values: vec![0.0; entries], correction: zeros(), trial: zeros() }
    }

    /// Values of the dimensionless tangent where the last iteration ended.
    pub fn tangent(&self) -> &[f64] {
        &self.values
    }
}

/// Iterates `x` to a residual norm below `tolerance`; returns the norms of all iterations.
///
/// # Errors
/// The reason why there is no solution; `x` is then undefined.
pub fn solve(
    system: &mut impl System,
    work: &mut Workspace,
    x: &mut [f64],
    tolerance: f64,
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
        system.statistics().iterations += 1;
        correction.copy_from_slice(residual);
        system
            .correct(values, correction, Aim { norm, tolerance })
            .map_err(|_| NewtonFailure::Singular(iteration))?;
        let largest = correction.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let negligible = constrained && largest <= NEGLIGIBLE;
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
            let evaluated = system.evaluate(trial, residual, values);
            let last = halvings == MAX_HALVINGS;
            match evaluated {
                // The first, constraint-imposing step may raise the residual.
                Ok(n) if n.is_finite() && (n <= SUFFICIENT * norm || !constrained || n <= tolerance) => {
                    break n;
                }
                Ok(n) if n.is_finite() && last && n < norm => break n,
                Ok(n) if n.is_finite() && negligible => {
                    // Tangent and reaction shall be those of the solution, not of the trial.
                    system.evaluate(x, residual, values).map_err(NewtonFailure::Inadmissible)?;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// `x = 0` with a residual that rounding keeps at 1e-8; knows where it was evaluated last.
    struct Rounded {
        evaluated: f64,
        statistics: Statistics,
    }

    impl System for Rounded {
        fn evaluate(&mut self, x: &[f64], residual: &mut [f64], values: &mut [f64]) -> Result<f64, usize> {
            self.evaluated = x[0];
            residual[0] = if x[0].abs() > 1e-6 { x[0] } else { 1e-8_f64.copysign(x[0]) };
            values[0] = 1.0;
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
}
