//! The least-squares problem: parameters -> runs -> weighted differences from the measurements.
//!
//! Columns of the Jacobian come from the FMU's own derivatives of the force, where it has them, and from finite
//! differences elsewhere. Eager: when the optimiser names a trial point, its runs start at once, and those of its finite-difference
//! Jacobian behind them at lower priority. If the point is taken, the Jacobian is already on its way; if it
//! is rejected, dropping the handles cancels what has not run.

pub mod dataset;
pub mod parameters;

mod jacobian_load;

pub use dataset::{Dataset, DatasetError, Weights};
pub use jacobian_load::JacobianLoad;
pub use parameters::{Defaults, ParameterError, ParameterMap, Requests};

use crate::engine::Engine;
use crate::fit::{EvaluationFailure, Problem};
use crate::pool::{ForceCurve, Priority, Run, RunFailure};
use nalgebra::DMatrix;
use poropunch::variables::sensitivities;
use std::sync::Arc;

/// Differences between model and measurements as a function of the free parameters.
pub struct Objective<'a> {
    engine: &'a Engine,
    datasets: &'a [Dataset],
    parameters: &'a ParameterMap,
    /// Finite-difference step in the optimiser's variables (relative, for log parameters).
    step: f64,
    /// Which columns come from the FMU.
    exact: Vec<bool>,
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

/// How a column of the Jacobian is formed.
enum Column {
    /// From derivatives in the point's own runs.
    Exact,
    /// From the runs of one shifted point.
    Difference { shift: f64, runs: Vec<Run> },
}

impl<'a> Objective<'a> {
    /// The problem of fitting `parameters` to `datasets` by runs of `engine`. Parameters whose derivatives the
    /// engine records need no finite differences.
    pub fn new(engine: &'a Engine, datasets: &'a [Dataset], parameters: &'a ParameterMap, step: f64) -> Self {
        let recorded = &engine.wiring().sensitivities;
        let has = |j| parameters.slopes(parameters.start(), j).iter().all(|(p, _)| recorded.contains_key(*p));
        let exact = (0..parameters.free().len()).map(has).collect();
        let (trial, screened, load) = (None, Vec::new(), JacobianLoad::default());
        Self { engine, datasets, parameters, step, exact, trial, screened, load, failed: 0 }
    }

    /// Number of parameters whose derivatives come from the FMU.
    pub fn exact_columns(&self) -> usize {
        self.exact.iter().filter(|exact| **exact).count()
    }

    /// How busy the pool was while Jacobians were formed.
    pub fn load(&self) -> JacobianLoad {
        self.load
    }

    /// Points at which the model failed.
    pub fn failed(&self) -> u64 {
        self.failed
    }

    /// One run per dataset, with derivatives where they are wanted.
    fn submit(&self, x: &[f64], derivatives: bool, priority: Priority) -> Vec<Run> {
        let mut values = self.parameters.settings(x);
        if derivatives {
            values.insert(sensitivities::SWITCH.to_owned(), 1.0);
        }
        self.datasets.iter().map(|d| self.engine.submit(&d.job(&values), priority)).collect()
    }

    fn shifted(&self, x: &[f64], j: usize, shift: f64) -> Vec<Run> {
        let mut y = x.to_vec();
        y[j] += shift;
        self.submit(&y, false, Priority::Speculative)
    }

    /// Starts the runs of a point and of its Jacobian.
    fn begin(&self, x: &[f64]) -> Trial {
        let load = jacobian_load::Window::open(self.engine.pool());
        let runs = self.submit(x, self.exact_columns() > 0, Priority::Urgent);
        let (_, upper) = self.parameters.bounds();
        let column = |j: usize| {
            if self.exact[j] {
                return Column::Exact;
            }
            // Inwards at the upper bound, so that no run leaves the bounds.
            let shift = if x[j] + self.step <= upper[j] { self.step } else { -self.step };
            Column::Difference { shift, runs: self.shifted(x, j, shift) }
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

    fn column(&self, trial: &Trial, r: &[f64], j: usize) -> Result<Vec<f64>, EvaluationFailure> {
        match &trial.columns[j] {
            Column::Exact => self.exact_column(trial, j),
            Column::Difference { shift, runs } => self.difference(&trial.x, r, j, *shift, runs),
        }
    }

    fn exact_column(&self, trial: &Trial, j: usize) -> Result<Vec<f64>, EvaluationFailure> {
        let recorded = &self.engine.wiring().sensitivities;
        let slopes = self.parameters.slopes(&trial.x, j);
        let mut column = Vec::new();
        for (dataset, run) in self.datasets.iter().zip(&trial.runs) {
            let curve = wait(run)?;
            let derivatives: Vec<(&[f64], f64)> = slopes
                .iter()
                .map(|(name, slope)| (curve.values[recorded[*name]].as_slice(), *slope))
                .collect();
            dataset.append_slopes(&derivatives, &mut column);
        }
        Ok(column)
    }

    fn difference(
        &self,
        x: &[f64],
        r: &[f64],
        j: usize,
        shift: f64,
        runs: &[Run],
    ) -> Result<Vec<f64>, EvaluationFailure> {
        let (shift, shifted) = match self.residuals(runs) {
            // The model may fail on one side only.
            Err(EvaluationFailure::Failed(_)) => (-shift, self.residuals(&self.shifted(x, j, -shift))?),
            other => (shift, other?),
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
        for j in 0..x.len() {
            jacobian.column_mut(j).copy_from_slice(&self.column(&trial, r, j)?);
        }
        self.load.add(trial.load.close(self.engine.pool()));
        Ok(jacobian)
    }

    fn prefetch(&mut self, points: &[Vec<f64>]) {
        // One point is a trial: `residual` starts it together with its Jacobian.
        if points.len() > 1 {
            self.screened =
                points.iter().map(|p| (p.clone(), self.submit(p, false, Priority::Speculative))).collect();
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
