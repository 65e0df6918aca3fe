//! What is minimised: residuals within bounds.

use nalgebra::DMatrix;
use thiserror::Error;

/// A residual or Jacobian that could not be computed. A value, not the end of the fit.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum EvaluationFailure {
    /// The model could not be evaluated at this point; the trust region shrinks.
    #[error("{0}")]
    Failed(String),
    /// The user asked to stop while the evaluation was under way; the fit ends at its best point.
    #[error("interrupted")]
    Interrupted,
}

impl EvaluationFailure {
    /// What was computed, or none where the model fails there.
    ///
    /// # Errors
    /// When the user asked to stop.
    pub fn or_none<T>(result: Result<T, Self>) -> Result<Option<T>, Self> {
        match result {
            Ok(computed) => Ok(Some(computed)),
            Err(Self::Failed(_)) => Ok(None),
            Err(Self::Interrupted) => Err(Self::Interrupted),
        }
    }
}

/// A least-squares problem `min |r(x)|^2` over `x`.
///
/// Sequence of calls per iteration: `prefetch([x])`, `residual(x)`, then either `jacobian(x, r)` when the
/// point is taken or `rejected(x)` when it is not. An implementor that evaluates eagerly starts the runs of
/// the Jacobian at `x` together with the residual's and cancels them in `rejected`.
pub trait Problem {
    /// Number of parameters, the length of `x`.
    fn dimension(&self) -> usize;

    /// Residuals at `x`, in units of their standard deviation if that is known.
    ///
    /// # Errors
    /// When the model fails there, or on the user's request to stop.
    fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure>;

    /// Derivatives `dr_i / dx_j` (rows: residuals) at `x`, where the residuals are `r`.
    ///
    /// # Errors
    /// As [`Problem::residual`]; the point is then treated as one where the model fails.
    fn jacobian(&mut self, x: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure>;

    /// Residuals at `x` and their derivatives.
    ///
    /// # Errors
    /// As [`Problem::residual`].
    fn with_jacobian(&mut self, x: &[f64]) -> Result<(Vec<f64>, DMatrix<f64>), EvaluationFailure> {
        let r = self.residual(x)?;
        let jacobian = self.jacobian(x, &r)?;
        Ok((r, jacobian))
    }

    /// These points' residuals will be asked for soon; runs may start now.
    fn prefetch(&mut self, _points: &[Vec<f64>]) {}

    /// Nothing more will be asked at `x`; runs for its Jacobian may be cancelled.
    fn rejected(&mut self, _x: &[f64]) {}
}

/// A fit that could not begin.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FitError {
    /// Vectors of different lengths.
    #[error("{what}: expected {expected} values, found {found}")]
    Dimension {
        /// What has the wrong length.
        what: &'static str,
        /// Length needed.
        expected: usize,
        /// Length given.
        found: usize,
    },
    /// A lower bound that is not below the upper one.
    #[error("parameter {index}: lower bound {lower} is not below upper bound {upper}")]
    Bounds {
        /// Position of the parameter.
        index: usize,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A start outside the bounds.
    #[error("parameter {index}: start {value} is outside [{lower}, {upper}]")]
    StartOutside {
        /// Position of the parameter.
        index: usize,
        /// Start value.
        value: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// The model failed at the start.
    #[error("the model fails at the start, so there is nothing to improve on ({0}); choose another start")]
    StartFailed(String),
    /// Stopped before anything was evaluated.
    #[error("stopped before the first evaluation was complete")]
    Interrupted,
    /// A parameter whose value, start or bounds cannot be used.
    #[error("{name}: {reason}")]
    Parameter {
        /// Name of the parameter.
        name: String,
        /// What is wrong, and what to do.
        reason: String,
    },
    /// A matrix or vector that is not finite.
    #[error("{0} contains a value that is not a finite number")]
    NotFinite(&'static str),
}

/// Box `lower <= x <= upper`; infinite where unbounded.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl Bounds {
    /// Bounds from two vectors of equal length with `lower < upper`.
    ///
    /// # Errors
    /// When lengths differ or a lower bound is not below the upper one (NaN included).
    pub fn new(lower: Vec<f64>, upper: Vec<f64>) -> Result<Self, FitError> {
        if lower.len() != upper.len() {
            return Err(FitError::Dimension {
                what: "upper bounds",
                expected: lower.len(),
                found: upper.len(),
            });
        }
        for (index, (&l, &u)) in lower.iter().zip(&upper).enumerate() {
            if l.is_nan() || u.is_nan() || l >= u {
                return Err(FitError::Bounds { index, lower: l, upper: u });
            }
        }
        Ok(Self { lower, upper })
    }

    /// No bounds on `n` parameters.
    pub fn none(n: usize) -> Self {
        Self { lower: vec![f64::NEG_INFINITY; n], upper: vec![f64::INFINITY; n] }
    }

    /// Lower bounds.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    /// Upper bounds.
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// Whether `x` lies within, bounds included.
    pub fn contain(&self, x: &[f64]) -> bool {
        x.iter().zip(self.lower.iter().zip(&self.upper)).all(|(x, (l, u))| l <= x && x <= u)
    }

    /// Checks a start.
    ///
    /// # Errors
    /// Names the first value outside its bounds or not a number.
    pub fn check_start(&self, x: &[f64]) -> Result<(), FitError> {
        if x.len() != self.lower.len() {
            return Err(FitError::Dimension { what: "start", expected: self.lower.len(), found: x.len() });
        }
        for (index, &value) in x.iter().enumerate() {
            let (lower, upper) = (self.lower[index], self.upper[index]);
            if !(value.is_finite() && lower <= value && value <= upper) {
                return Err(FitError::StartOutside { index, value, lower, upper });
            }
        }
        Ok(())
    }

    /// The point strictly inside nearest to `x`, at least `relative` of the bound's size (at most of the
    /// interval) away from it: the affine scaling is undefined on a bound.
    pub fn interior(&self, x: &[f64], relative: f64) -> Vec<f64> {
        let pull = |(i, &value): (usize, &f64)| {
            let (l, u) = (self.lower[i], self.upper[i]);
            let gap = |b: f64| (relative * b.abs().max(1.0)).min(0.25 * (u - l));
            let mut y = value;
            if y <= l || y - l < gap(l) {
                y = if relative > 0.0 { l + gap(l) } else { l.next_up() };
            }
            if y >= u || u - y < gap(u) {
                y = if relative > 0.0 { u - gap(u) } else { u.next_down() };
            }
            if y <= l || y >= u { 0.5 * (l + u) } else { y }
        };
        x.iter().enumerate().map(pull).collect()
    }
}
