//! The load cell along the path: what it reads of the force between the ends of the steps.

use super::lag;
use crate::outputs::{ForceSensitivity, Outputs};
use serde::{Deserialize, Serialize};

/// How a load cell reads; the default reads the force as it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoadCellParameters {
    /// Time constant of its low pass (s); 0 reads at once.
    pub lag: f64,
    /// Rate at which its zero drifts, from the test's start, in contact or not (N/s).
    pub drift_rate: f64,
    /// Whether the traction integral is read instead of the nodal force.
    pub reads_traction: bool,
    /// Whether the derivative of the reading by the time constant is computed.
    pub differentiates_lag: bool,
}

impl LoadCellParameters {
    /// What the cell reads at `time` (s) since the test's start for a force that its electronics get (N).
    pub fn drifted(&self, force: f64, time: f64) -> f64 {
        if self.drift_rate == 0.0 { force } else { force + self.drift_rate * time }
    }
}

/// A load cell in contact; its state is that at the start of the step that covers the present.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LoadCell {
    /// Time constant (s); 0 reads at once.
    lag: f64,
    /// Whether the traction integral is read instead of the nodal force.
    traction: bool,
    /// Time of the state (s).
    time: f64,
    /// Reading (N), and its derivatives where they are computed.
    reading: f64,
    derivatives: Vec<f64>,
    /// Derivative of the reading by the time constant (N/s), where it is computed.
    by_lag: Option<f64>,
}

impl LoadCell {
    /// A cell at rest at `time` (s).
    pub fn at_rest(parameters: &LoadCellParameters, time: f64) -> Self {
        let LoadCellParameters { lag, reads_traction: traction, .. } = *parameters;
        let by_lag = parameters.differentiates_lag.then_some(0.0);
        Self { lag, traction, time, reading: 0.0, derivatives: Vec::new(), by_lag }
    }

    /// Whether it reads the force of the same moment.
    pub fn is_immediate(&self) -> bool {
        self.lag == 0.0
    }

    /// The force that acts on it.
    pub fn felt(&self, outputs: &Outputs) -> f64 {
        if self.traction { outputs.force_traction } else { outputs.force_specimen }
    }

    /// Factors of the state and of values along the path, interpolated by `lagrange`, in the reading at `time`.
    fn response(&self, time: f64, lagrange: impl Fn(f64) -> Vec<f64>) -> (f64, Vec<f64>) {
        lag::response(self.lag, (self.time, time), lagrange)
    }

    /// Reading at `time`, the force's `values` interpolated by `lagrange`; for a cell with a lag.
    pub fn read(&self, time: f64, values: &[f64], lagrange: impl Fn(f64) -> Vec<f64>) -> f64 {
        let (kept, factors) = self.response(time, lagrange);
        kept * self.reading + factors.iter().zip(values).map(|(f, v)| f * v).sum::<f64>()
    }

    /// Derivatives of the reading at `time` in `force`, from those of the nodes.
    pub fn read_derivatives(
        &self,
        time: f64,
        nodes: &[&[ForceSensitivity]],
        lagrange: impl Fn(f64) -> Vec<f64>,
    ) -> Vec<f64> {
        let (kept, factors) = self.response(time, lagrange);
        let parameters = nodes.first().map_or(0, |node| node.len());
        (0..parameters)
            .map(|k| {
                let new: f64 = factors.iter().zip(nodes).map(|(f, node)| f * node[k].specimen).sum();
                kept * self.derivatives.get(k).unwrap_or(&0.0) + new
            })
            .collect()
    }

    /// Derivative of the reading at `time` by the time constant (N/s), where it is computed; for a cell with a lag.
    pub fn read_lag_derivative(
        &self,
        time: f64,
        values: &[f64],
        lagrange: impl Fn(f64) -> Vec<f64>,
    ) -> Option<f64> {
        let before = self.by_lag?;
        let kept = (-(time - self.time).max(0.0) / self.lag).exp();
        let (slope, factors) = lag::response_slope(self.lag, (self.time, time), lagrange);
        let new: f64 = factors.iter().zip(values).map(|(f, v)| f * v).sum();
        Some(kept * before + slope * self.reading + new)
    }

    /// Moves the state on to `time`.
    pub fn follow(
        &mut self,
        time: f64,
        values: &[f64],
        nodes: &[&[ForceSensitivity]],
        lagrange: impl Fn(f64) -> Vec<f64>,
    ) {
        if self.is_immediate() || time <= self.time {
            return;
        }
        let reading = self.read(time, values, &lagrange);
        self.by_lag = self.read_lag_derivative(time, values, &lagrange);
        self.derivatives = self.read_derivatives(time, nodes, &lagrange);
        (self.reading, self.time) = (reading, time);
    }
}
