//! Results between the ends of the steps: interpolated from those of the last few, and read by the load cell.

use super::path::{NODES, Path};
use crate::outputs::{ForceSensitivity, Outputs};
use crate::specimen::State;
use serde::{Deserialize, Serialize};

/// Results at the end of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Node {
    pub(super) time: f64,
    /// Mean axial displacement of the surface under the punch (m).
    pub(super) level: f64,
    pub(super) outputs: Outputs,
    pub(super) sensitivities: Vec<ForceSensitivity>,
}

impl Node {
    pub(super) fn of(state: &State) -> Self {
        Self {
            time: state.time,
            level: state.touch.level,
            outputs: state.outputs,
            sensitivities: state.sensitivity.as_ref().map(|s| s.forces.clone()).unwrap_or_default(),
        }
    }
}

impl Path {
    /// What the load cell reads at a time the path has reached.
    pub(super) fn reading(&self, time: f64, outputs: &Outputs) -> f64 {
        if self.cell.is_immediate() {
            return self.cell.felt(outputs);
        }
        self.cell.read(time, &self.felt(), |t| self.weights(&self.nodes, t))
    }

    /// Forces on the load cell at the nodes.
    fn felt(&self) -> Vec<f64> {
        self.nodes.iter().map(|n| self.cell.felt(&n.outputs)).collect()
    }

    fn derivatives(&self) -> Vec<&[ForceSensitivity]> {
        self.nodes.iter().map(|n| n.sensitivities.as_slice()).collect()
    }

    /// Moves the load cell on to `time`, before the nodes change.
    pub(super) fn follow(&mut self, time: f64) {
        if self.cell.is_immediate() {
            return;
        }
        let mut cell = self.cell.clone();
        cell.follow(time, &self.felt(), &self.derivatives(), |t| self.weights(&self.nodes, t));
        self.cell = cell;
    }

    /// Difference between a new value and the one extrapolated from those of the last nodes.
    pub(super) fn misfit(&self, state: &State, value: f64, of: impl Fn(&Node) -> f64) -> Option<f64> {
        let known = &self.nodes[self.nodes.len().saturating_sub(NODES - 1)..];
        if known.len() < 2 {
            return None;
        }
        let extrapolated: f64 =
            self.weights(known, state.time).iter().zip(known).map(|(w, n)| w * of(n)).sum();
        Some((value - extrapolated).abs())
    }

    pub(super) fn interpolate(&self, time: f64) -> Outputs {
        let weights = self.weights(&self.nodes, time);
        let terms: Vec<_> = weights.iter().zip(&self.nodes).map(|(&w, n)| (w, &n.outputs)).collect();
        let mut outputs = Outputs::combine(&terms);
        outputs.viscous_dissipation_rate = outputs.viscous_dissipation_rate.max(0.0);
        outputs.porous_dissipation_rate = outputs.porous_dissipation_rate.max(0.0);
        let end = self.nodes.partition_point(|n| n.time < time).max(1);
        if let [.., before, after] = &self.nodes[..self.nodes.len().min(end + 1)] {
            let between = |of: fn(&Outputs) -> (f64, f64)| self.rising(before, after, time, of);
            outputs.viscous_dissipation = between(|o| (o.viscous_dissipation, o.viscous_dissipation_rate));
            outputs.porous_dissipation = between(|o| (o.porous_dissipation, o.porous_dissipation_rate));
        }
        outputs
    }

    /// A quantity that never falls, at a time between two nodes: Hermite's cubic through its values and rates, which
    /// `of` gives, with slopes limited so that it is monotone (Fritsch and Carlson).
    fn rising(&self, before: &Node, after: &Node, time: f64, of: fn(&Outputs) -> (f64, f64)) -> f64 {
        let root = |t: f64| (t - self.origin + self.first_step).max(0.0).sqrt();
        let ((from, rate_from), (to, rate_to)) = (of(&before.outputs), of(&after.outputs));
        let (start, end) = (root(before.time), root(after.time));
        let (rise, length) = ((to - from).max(0.0), end - start);
        let slope = |rate: f64, root: f64| (2.0 * root * rate * length).clamp(0.0, 3.0 * rise);
        let (a, b) = (slope(rate_from, start), slope(rate_to, end));
        let x = ((root(time) - start) / length).clamp(0.0, 1.0);
        from + x * (a + x * (3.0 * rise - 2.0 * a - b + x * (a + b - 2.0 * rise)))
    }

    /// Derivatives of the force at a time the path has reached; empty when they are not computed.
    pub fn sensitivities(&self, time: f64) -> Vec<ForceSensitivity> {
        let parameters = self.nodes.last().map_or(0, |n| n.sensitivities.len());
        if parameters == 0 {
            return Vec::new();
        }
        let mut sum = vec![ForceSensitivity::default(); parameters];
        for (weight, node) in self.weights(&self.nodes, time).into_iter().zip(&self.nodes) {
            for (sum, at) in sum.iter_mut().zip(&node.sensitivities) {
                sum.force += weight * at.force;
                sum.specimen += weight * at.specimen;
                sum.fluid += weight * at.fluid;
            }
        }
        if !self.cell.is_immediate() {
            let lagging =
                self.cell.read_derivatives(time, &self.derivatives(), |t| self.weights(&self.nodes, t));
            sum.iter_mut().zip(lagging).for_each(|(sum, derivative)| sum.force = derivative);
        }
        sum
    }

    /// Derivative of the reading by the load cell's time constant at a time the path has reached (N/s); 0 unless it is computed.
    ///
    /// A short lag shifts the force by itself: at none the derivative is minus the force's rate just before.
    pub fn lag_derivative(&self, time: f64) -> f64 {
        if self.cell.is_immediate() {
            let rates = self.weight_rates(&self.nodes, time);
            return -rates.iter().zip(self.felt()).map(|(rate, force)| rate * force).sum::<f64>();
        }
        let derivative = self.cell.read_lag_derivative(time, &self.felt(), |t| self.weights(&self.nodes, t));
        derivative.unwrap_or_default()
    }

    /// Lagrange weights in the square root of the time since `origin`, in which both
    /// linear growth and seepage (square root of time) are polynomials; two nodes give a line in time.
    fn weights(&self, nodes: &[Node], time: f64) -> Vec<f64> {
        let x = self.abscissa(nodes, time);
        let known: Vec<f64> = nodes.iter().map(|n| self.abscissa(nodes, n.time)).collect();
        known
            .iter()
            .enumerate()
            .map(|(i, a)| {
                let others = known.iter().enumerate().filter(|(j, _)| *j != i);
                others.map(|(_, b)| (x - b) / (a - b)).product()
            })
            .collect()
    }

    /// Rates of these weights (1/s).
    fn weight_rates(&self, nodes: &[Node], time: f64) -> Vec<f64> {
        let x = self.abscissa(nodes, time);
        let rate = if nodes.len() > 2 { 0.5 / x.max(f64::EPSILON) } else { 1.0 };
        let known: Vec<f64> = nodes.iter().map(|n| self.abscissa(nodes, n.time)).collect();
        let others = |i: usize| known.iter().enumerate().filter(move |(j, _)| *j != i);
        // The product rule: one factor after the other.
        let slope = |(i, a): (usize, &f64)| {
            let but = |k: usize| {
                let rest = others(i).filter(move |(j, _)| *j != k);
                rest.map(|(_, b)| (x - b) / (a - b)).product::<f64>()
            };
            rate * others(i).map(|(k, b)| but(k) / (a - b)).sum::<f64>()
        };
        known.iter().enumerate().map(slope).collect()
    }

    /// What the weights are polynomials in.
    fn abscissa(&self, nodes: &[Node], time: f64) -> f64 {
        let since = time - self.origin;
        if nodes.len() > 2 { (since + self.first_step).max(0.0).sqrt() } else { since }
    }
}
