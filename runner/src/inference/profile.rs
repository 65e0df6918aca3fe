//! Profile likelihood: how far a value can go before the best fit with it is worse by what the quantile allows.
//!
//! Every term and fitted parameter is, in its logarithm, linear in the optimiser's variables, `q = a'x + c`, and a fit with `q` given is
//! one of the other variables: `x_k = (q - c - sum a_j x_j) / a_k`. The priors of the variables that `q` is made of are left out, as in the
//! linearised interval; what specimens leave unknown of the common height, which no fit sees, is added in quadrature.

use super::fit::{Fit, options, problem_without_prior};
use super::parameter::FitParameter;
use super::setup::Setup;
use super::statistics::Statistics;
use super::unknowns::Unknowns;
use crate::fit::{Bounds, EvaluationFailure, Problem, minimise};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// A value whose interval is asked for.
#[derive(Debug, Clone)]
pub struct Target {
    /// What it is, with its bounds.
    pub parameter: FitParameter,
    /// `q` at the optimum: the parameter's own variable.
    pub at: f64,
    /// Change of it by the optimiser's variables.
    pub gradient: DVector<f64>,
}

impl Target {
    /// How far `q` may go down and up.
    pub(super) fn room(&self) -> [f64; 2] {
        let (low, high) = self.parameter.internal_bounds();
        [self.at - low, high - self.at]
    }

    /// Whether it is meant by a name: its own, or its symbol.
    pub fn is_called(&self, name: &str) -> bool {
        self.parameter.name == name || self.parameter.symbol == name
    }
}

/// Every term, and every fitted parameter that is none, at a point of the optimiser.
pub fn targets(unknowns: &Unknowns, x: &[f64]) -> Vec<Target> {
    let (terms, rows) = unknowns.terms();
    let at = &rows * DVector::from_column_slice(x);
    let mut all: Vec<Target> = terms
        .into_iter()
        .enumerate()
        .map(|(j, parameter)| Target { parameter, at: at[j], gradient: rows.row(j).transpose() })
        .collect();
    let values = unknowns.settings(x);
    for parameter in unknowns.free() {
        if all.iter().any(|t| t.parameter.name == parameter.name) {
            continue;
        }
        let value = values[&parameter.name];
        let mut gradient = DVector::zeros(x.len());
        unknowns.gradient(x, &parameter.name).iter().for_each(|(j, slope)| gradient[*j] = slope / value);
        all.push(Target { parameter: parameter.clone(), at: parameter.to_internal(value), gradient });
    }
    all
}

/// A profile: `q` relative to the optimum.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Profile {
    /// `q` and the rise of chi^2, ascending in `q`; the optimum included.
    pub points: Vec<(f64, f64)>,
    /// Ends of the 95 % interval; none where the bound comes first.
    pub ends: [Option<f64>; 2],
}

/// An end is found when the root of the rise is this near the quantile (relative).
const NEAR: f64 = 0.05;
/// Fits per side at most.
const MOST_FITS: usize = 6;

/// What is profiled around a fit.
pub struct Profiler<'a> {
    /// Engine, measurements, unknowns.
    pub setup: Setup<'a>,
    /// The fit.
    pub fit: &'a Fit,
    /// Its statistics.
    pub statistics: &'a Statistics,
    /// Largest number of evaluations of one fit.
    pub evaluations: usize,
}

impl Profiler<'_> {
    /// The rise of chi^2 at `x`, without the prior of what `target` is made of.
    fn rise(&self, target: &Target, x: &[f64]) -> Result<Option<f64>, EvaluationFailure> {
        let own = |j: usize| target.gradient[j] != 0.0;
        let square = |x: &[f64]| -> Result<f64, EvaluationFailure> {
            let r = problem_without_prior(self.setup, &self.statistics.covariance, &own).residual(x)?;
            Ok(r.iter().map(|r| r * r).sum())
        };
        match (square(x), square(&self.fit.solution.x)) {
            (Ok(there), Ok(here)) => Ok(Some(there - here)),
            (Err(EvaluationFailure::Interrupted), _) => Err(EvaluationFailure::Interrupted),
            _ => Ok(None),
        }
    }

    /// The likeliest point with `q` moved by `by`, as the linearised fit has it; within the bounds.
    pub(super) fn predicted(&self, target: &Target, by: f64) -> Vec<f64> {
        let along = self.statistics.of_variables() * &target.gradient;
        let variance = target.gradient.dot(&along);
        let (lower, upper) = self.setup.unknowns.bounds();
        let x = &self.fit.solution.x;
        let mut there: Vec<f64> =
            (0..x.len()).map(|j| (x[j] + by * along[j] / variance).clamp(lower[j], upper[j])).collect();
        // What the bounds took away is made up for by the variable that moves most.
        let k = main_variable(target);
        let moved: f64 = (0..x.len()).map(|j| target.gradient[j] * (there[j] - x[j])).sum();
        there[k] = (there[k] + (by - moved) / target.gradient[k]).clamp(lower[k], upper[k]);
        there
    }

    /// The profile to both sides by fits of everything else: exact, some ten fits.
    ///
    /// # Errors
    /// When the user asked to stop.
    pub fn profile(&self, target: &Target) -> Result<Profile, EvaluationFailure> {
        let quantile = self.statistics.quantile(&target.gradient);
        let linear = self.statistics.seen_half_width(&target.gradient);
        let mut found = Profile { points: vec![(0.0, 0.0)], ends: [None; 2] };
        for (k, side) in [-1.0, 1.0].into_iter().enumerate() {
            let room = target.room()[k];
            let (mut low, mut high) = ((0.0, 0.0), None::<(f64, f64)>);
            let mut by = linear.min(room);
            let mut start = None;
            for _ in 0..MOST_FITS {
                let Some((rise, x)) = self.fitted(target, side * by, start.take())? else {
                    // The model cannot be computed there: that is no end, but as far as one can go.
                    by = 0.5 * (low.0 + by);
                    continue;
                };
                start = Some(x);
                found.points.push((side * by, rise));
                let root = rise.max(0.0).sqrt();
                if (root / quantile - 1.0).abs() < NEAR {
                    found.ends[k] = Some(side * by);
                    break;
                }
                if root < quantile {
                    low = (by, root);
                    if by >= room {
                        break;
                    }
                } else {
                    high = Some((by, root));
                }
                by = next(low, high, quantile).min(room);
                found.ends[k] = high.map(|_| side * by);
            }
        }
        Ok(self.with_unseen(target, found))
    }

    /// Sorted, and with what no fit sees in its ends.
    pub(super) fn with_unseen(&self, target: &Target, mut found: Profile) -> Profile {
        found.points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let unseen = self.statistics.quantile(&target.gradient) * self.statistics.unseen(&target.gradient);
        for end in found.ends.iter_mut().flatten() {
            *end = end.signum() * end.hypot(unseen);
        }
        found
    }

    /// chi^2 of the best fit with `q` moved by `by`, over that of the best of all, and where it is.
    fn fitted(
        &self,
        target: &Target,
        by: f64,
        start: Option<Vec<f64>>,
    ) -> Result<Option<(f64, Vec<f64>)>, EvaluationFailure> {
        let start = start.unwrap_or_else(|| self.predicted(target, by));
        let own = |j: usize| target.gradient[j] != 0.0;
        let mut problem = Given {
            problem: problem_without_prior(self.setup, &self.statistics.covariance, &own),
            gradient: target.gradient.clone(),
            given: target.gradient.dot(&DVector::from_column_slice(&self.fit.solution.x)) + by,
            k: main_variable(target),
        };
        let (lower, upper) = self.setup.unknowns.bounds();
        let (lower, upper) = (problem.others(lower), problem.others(upper));
        let reduced: Vec<f64> = problem.others(&start);
        let bounded = match Bounds::new(lower, upper) {
            Ok(bounds) if !reduced.is_empty() => bounds,
            _ => return self.rise(target, &problem.all(&[])).map(|r| r.map(|rise| (rise, problem.all(&[])))),
        };
        let inside = bounded.interior(&reduced, 1e-10);
        let options = options(self.setup, self.evaluations);
        let go = &mut |_: &_| self.setup.engine.going_on();
        let Ok(found) = minimise(&mut problem, &inside, &bounded, &options, go) else {
            return if self.setup.engine.is_stopped() {
                Err(EvaluationFailure::Interrupted)
            } else {
                Ok(None)
            };
        };
        if self.setup.engine.is_stopped() {
            return Err(EvaluationFailure::Interrupted);
        }
        let x = problem.all(&found.x);
        Ok(self.rise(target, &x)?.map(|rise| (rise, x)))
    }
}

/// Where the root of the rise, straight between what is known, passes the quantile.
fn next(low: (f64, f64), high: Option<(f64, f64)>, quantile: f64) -> f64 {
    match high {
        Some(high) => {
            let part = (quantile - low.1) / (high.1 - low.1).max(f64::MIN_POSITIVE);
            low.0 + part.clamp(0.05, 0.95) * (high.0 - low.0)
        }
        // Flat so far: at most three times as far.
        None => low.0 * (quantile / low.1.max(f64::MIN_POSITIVE)).clamp(1.2, 3.0),
    }
}

/// The variable that `q` depends on most.
pub(super) fn main_variable(target: &Target) -> usize {
    target.gradient.iamax()
}

/// A problem with `gradient' x = given`, as one of the variables but the `k`th.
pub(super) struct Given<P> {
    problem: P,
    gradient: DVector<f64>,
    given: f64,
    k: usize,
}

impl<P> Given<P> {
    /// Derivatives by the other variables, from those by all.
    pub(super) fn reduced(full: &DMatrix<f64>, gradient: &DVector<f64>, k: usize) -> DMatrix<f64> {
        let own = full.column(k) / gradient[k];
        let mut reduced = full.clone().remove_column(k);
        for (mut column, j) in reduced.column_iter_mut().zip((0..full.ncols()).filter(|&j| j != k)) {
            column -= &own * gradient[j];
        }
        reduced
    }

    fn others(&self, x: &[f64]) -> Vec<f64> {
        (0..x.len()).filter(|&j| j != self.k).map(|j| x[j]).collect()
    }

    fn all(&self, y: &[f64]) -> Vec<f64> {
        let mut x = y.to_vec();
        x.insert(self.k, 0.0);
        let rest: f64 = x.iter().zip(self.gradient.iter()).map(|(x, a)| x * a).sum();
        x[self.k] = (self.given - rest) / self.gradient[self.k];
        x
    }
}

impl<P: Problem> Problem for Given<P> {
    fn dimension(&self) -> usize {
        self.problem.dimension() - 1
    }

    fn residual(&mut self, y: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
        self.problem.residual(&self.all(y))
    }

    fn jacobian(&mut self, y: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
        let full = self.problem.jacobian(&self.all(y), r)?;
        Ok(Self::reduced(&full, &self.gradient, self.k))
    }

    fn rejected(&mut self, y: &[f64]) {
        self.problem.rejected(&self.all(y));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::Options;
    use std::ops::ControlFlow;

    /// `(x0 - 1, x1 - 2, x0 + x1 - 4)`.
    struct Plane;

    impl Problem for Plane {
        fn dimension(&self) -> usize {
            2
        }
        fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
            Ok(vec![x[0] - 1.0, x[1] - 2.0, x[0] + x[1] - 4.0])
        }
        fn jacobian(&mut self, _: &[f64], _: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
            Ok(DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 0.0, 1.0, 1.0, 1.0]))
        }
    }

    /// With `2 x0 + x1 = 5` the minimum of the squares lies where Lagrange's conditions hold: by hand at (1.5, 2).
    #[test]
    fn a_given_value_leaves_the_best_of_the_others() {
        let gradient = DVector::from_vec(vec![2.0, 1.0]);
        let mut problem = Given { problem: Plane, gradient, given: 5.0, k: 0 };
        let go = &mut |_: &_| ControlFlow::Continue(());
        let found = minimise(&mut problem, &[0.0], &Bounds::none(1), &Options::default(), go).unwrap();
        let x = problem.all(&found.x);
        // d/dx1 of (x0 - 1)^2 + (x1 - 2)^2 + (x0 + x1 - 4)^2 along (-1/2, 1).
        let slope = -0.5 * (x[0] - 1.0) + (x[1] - 2.0) + 0.5 * (x[0] + x[1] - 4.0);
        assert!(slope.abs() < 1e-6 && (2.0 * x[0] + x[1] - 5.0).abs() < 1e-12, "{x:?}");
    }

    #[test]
    fn the_next_value_is_where_the_root_of_the_rise_passes_the_quantile() {
        assert!((next((1.0, 1.0), Some((2.0, 3.0)), 2.0) - 1.5).abs() < 1e-12);
        assert_eq!(next((1.0, 1.0), None, 2.0), 2.0);
        assert_eq!(next((1.0, 0.01), None, 2.0), 3.0);
    }
}
