//! What a fit returns: the point, why it stopped, and how it got there.

use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Why the iteration ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// The scaled gradient is small: a stationary point.
    Gradient,
    /// chi^2 no longer changes, and the quadratic model is trustworthy.
    ChiSquareChange,
    /// The step is small against the parameters.
    Step,
    /// chi^2 and the step are both small.
    ChiSquareChangeAndStep,
    /// The allowed number of evaluations is used up.
    EvaluationBudget,
    /// The user asked to stop.
    StopRequested,
    /// Too many evaluations in a row failed.
    TooManyFailures,
}

impl StopReason {
    /// Whether a minimum was found, to the tolerances asked for.
    pub fn converged(self) -> bool {
        matches!(self, Self::Gradient | Self::ChiSquareChange | Self::Step | Self::ChiSquareChangeAndStep)
    }
}

impl fmt::Display for StopReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gradient => "converged: the gradient of chi^2 vanishes",
            Self::ChiSquareChange => "converged: chi^2 no longer decreases",
            Self::Step => "converged: the parameters no longer move",
            Self::ChiSquareChangeAndStep => "converged: neither chi^2 nor the parameters change",
            Self::EvaluationBudget => "not converged: the evaluation budget is used up",
            Self::StopRequested => "not converged: stopped on request",
            Self::TooManyFailures => "not converged: too many evaluations in a row failed",
        })
    }
}

/// State after one iteration (the start is iteration 0).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct IterationRecord {
    /// Number of accepted steps so far.
    pub iteration: usize,
    /// Residual evaluations so far, failed ones included; those inside a Jacobian not.
    pub evaluations: usize,
    /// Failed evaluations so far, failed Jacobians included.
    pub failures: usize,
    /// Sum of squared residuals.
    pub chi_square: f64,
    /// Decrease of chi^2 by this iteration.
    pub reduction: f64,
    /// Length of this iteration's step in x.
    pub step_norm: f64,
    /// Trust radius after it, in scaled variables.
    pub radius: f64,
    /// Largest component of the bound-scaled gradient.
    pub optimality: f64,
    /// The point.
    pub x: Vec<f64>,
}

/// The best point found, with everything that its statistics need.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The point.
    pub x: Vec<f64>,
    /// Residuals there.
    pub residual: Vec<f64>,
    /// Jacobian there (rows: residuals).
    pub jacobian: DMatrix<f64>,
    /// Sum of squared residuals.
    pub chi_square: f64,
    /// Why the iteration ended.
    pub stop: StopReason,
    /// Start and every accepted step.
    pub iterations: Vec<IterationRecord>,
    /// Residual evaluations, failed ones included; those inside a Jacobian not.
    pub evaluations: usize,
    /// Jacobians formed.
    pub jacobians: usize,
    /// Reasons of failed evaluations, in order.
    pub failures: Vec<String>,
}

impl Solution {
    /// One that nothing had to be done for.
    #[cfg(test)]
    pub fn at_once(x: Vec<f64>, residual: Vec<f64>, jacobian: DMatrix<f64>) -> Self {
        Self {
            chi_square: residual.iter().map(|r| r * r).sum(),
            x,
            residual,
            jacobian,
            stop: StopReason::Gradient,
            iterations: vec![],
            evaluations: 1,
            jacobians: 1,
            failures: vec![],
        }
    }

    /// Accepted steps.
    pub fn iteration_count(&self) -> usize {
        self.iterations.last().map_or(0, |r| r.iteration)
    }

    /// Puts the iterations of the fit that this one went on from in front; counting goes on.
    pub fn go_on_from(&mut self, earlier: Vec<IterationRecord>) {
        let before = earlier.last().map_or(0, |r| r.iteration);
        self.iterations.iter_mut().for_each(|r| r.iteration += before);
        self.iterations.splice(0..0, earlier);
    }
}
