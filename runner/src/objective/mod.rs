//! The least-squares problem: parameters -> runs -> weighted differences from the measurements.
//!
//! Eager: when the optimiser names a trial point, its runs start at once, and those of its finite-difference
//! Jacobian behind them at lower priority. If the point is taken, the Jacobian is already on its way; if it
//! is rejected, dropping the handles cancels what has not run.

pub mod dataset;
pub mod parameters;

mod jacobian_load;

pub use dataset::{Dataset, DatasetError, Weights};
pub use jacobian_load::JacobianLoad;
pub use parameters::{ParameterError, ParameterMap, Requests};

use crate::engine::Engine;
use crate::fit::{EvaluationFailure, Problem};
use crate::pool::{ForceCurve, Priority, Run, RunFailure};
use nalgebra::DMatrix;
use std::sync::Arc;

/// Differences between model and measurements as a function of the free parameters.
pub struct Objective<'a> {
    engine: &'a Engine,
    datasets: &'a [Dataset],
    parameters: &'a ParameterMap,
    /// Finite-difference step in the optimiser's variables (relative, for log parameters).
    step: f64,
    trial: Option<Trial>,
    screened: Vec<(Vec<f64>, Vec<Run>)>,
    load: JacobianLoad,
    failed: u64,
}

/// Runs of a point and of its Jacobian's columns.
struct Trial {
    x: Vec<f64>,
    runs: Vec<Run>,
    columns: Vec<Column>,
    load: jacobian_load::Window,
}

/// Runs of one shifted point.
struct Column {
    shift: f64,
    runs: Vec<Run>,
}

impl<'a> Objective<'a> {
    /// The problem of fitting `parameters` to `datasets` by runs of `engine`.
    pub fn new(engine: &'a Engine, datasets: &'a [Dataset], parameters: &'a ParameterMap, step: f64) -> Self {
        let (trial, screened) = (None, Vec::new());
        Self { engine, datasets, parameters, step, trial, screened, load: JacobianLoad::default(), failed: 0 }
    }

    /// How busy the pool was while Jacobians were formed.
    pub fn load(&self) -> JacobianLoad {
        self.load
    }

    /// Points at which the model failed.
    pub fn failed(&self) -> u64 {
        self.failed
    }

    /// One run per dataset.
    fn submit(&self, x: &[f64], priority: Priority) -> Vec<Run> {
        let values = self.parameters.settings(x);
        self.datasets.iter().map(|d| self.engine.submit(&d.job(&values), priority)).collect()
    }

    fn shifted(&self, x: &[f64], j: usize, shift: f64) -> Vec<Run> {
        let mut y = x.to_vec();
        y[j] += shift;
        self.submit(&y, Priority::Speculative)
    }

    /// Starts the runs of a point and of its Jacobian.
    fn begin(&self, x: &[f64]) -> Trial {
        let load = jacobian_load::Window::open(self.engine.pool());
        let runs = self.submit(x, Priority::Urgent);
        let (_, upper) = self.parameters.bounds();
        let column = |j: usize| {
            // Inwards at the upper bound, so that no run leaves the bounds.
            let shift = if x[j] + self.step <= upper[j] { self.step } else { -self.step };
            Column { shift, runs: self.shifted(x, j, shift) }
        };
        let columns = (0..x.len()).map(column).collect();
        Trial { x: x.to_vec(), runs, columns, load }
    }

    fn residuals(&self, runs: &[Run]) -> Result<Vec<f64>, EvaluationFailure> {
        let mut all = Vec::new();
        for (dataset, run) in self.datasets.iter().zip(runs) {
            dataset.append_residuals(&*wait(run)?, &mut all);
        }
        Ok(all)
    }

    fn column(&self, x: &[f64], r: &[f64], j: usize, column: &Column) -> Result<Vec<f64>, EvaluationFailure> {
        let (shift, shifted) = match self.residuals(&column.runs) {
            // The model may fail on one side only.
            Err(EvaluationFailure::Failed(_)) => {
                (-column.shift, self.residuals(&self.shifted(x, j, -column.shift))?)
            }
            other => (column.shift, other?),
        };
        Ok(shifted.iter().zip(r).map(|(a, b)| (a - b) / shift).collect())
    }
}

impl Problem for Objective<'_> {
    fn dimension(&self) -> usize {
        self.parameters.free().len()
    }

    fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
        // While starts are screened, their Jacobians are not wanted.
        if let Some(i) = self.screened.iter().position(|(p, _)| p == x) {
            let (_, runs) = self.screened.swap_remove(i);
            return self.residuals(&runs).inspect_err(|e| self.failed += u64::from(is_failure(e)));
        }
        let trial = self.begin(x);
        let result = self.residuals(&trial.runs);
        // A point that failed needs no Jacobian: dropping its columns cancels them.
        self.trial = result.is_ok().then_some(trial);
        result.inspect_err(|e| self.failed += u64::from(is_failure(e)))
    }

    fn jacobian(&mut self, x: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
        let trial = match self.trial.take() {
            Some(trial) if trial.x == x => trial,
            _ => self.begin(x),
        };
        let mut jacobian = DMatrix::zeros(r.len(), x.len());
        for (j, column) in trial.columns.iter().enumerate() {
            jacobian.column_mut(j).copy_from_slice(&self.column(x, r, j, column)?);
        }
        self.load.add(trial.load.close(self.engine.pool()));
        Ok(jacobian)
    }

    fn prefetch(&mut self, points: &[Vec<f64>]) {
        // One point is a trial: `residual` starts it together with its Jacobian.
        if points.len() > 1 {
            self.screened =
                points.iter().map(|p| (p.clone(), self.submit(p, Priority::Speculative))).collect();
        }
    }

    fn rejected(&mut self, _x: &[f64]) {
        self.trial = None;
    }
}

fn is_failure(failure: &EvaluationFailure) -> bool {
    matches!(failure, EvaluationFailure::Failed(_))
}

/// The curve of a run, or why the evaluation failed.
///
/// # Errors
/// When the run failed or was cancelled.
pub fn wait(run: &Run) -> Result<Arc<ForceCurve>, EvaluationFailure> {
    run.wait().map_err(|failure| match failure {
        RunFailure::Cancelled => EvaluationFailure::Interrupted,
        other => EvaluationFailure::Failed(other.to_string()),
    })
}
