//! A profile from few runs: the model is computed with its derivatives where the linearised interval ends, and between such points
//! its force is the cubic that has the values and slopes of both (Hermite), its Jacobian the mean of theirs.
//!
//! Everything else is then refitted by algebra: at `q` the other variables take one Gauss-Newton step from the linearised path. An end
//! that falls between two points is computed in its turn, until what was foreseen is what is found.

use super::profile::{Given, Profile, Profiler, Target, main_variable};
use crate::fit::subproblem::Decomposition;
use crate::fit::{EvaluationFailure, Problem};
use crate::inference::problem::ForceProblem;
use crate::pool::{Priority, Run};
use nalgebra::{DMatrix, DVector};

/// Runs per side at most.
const MOST_RUNS: usize = 4;
/// Between points whose roots of the rise are below and at most this many quantiles above, the cubic is good enough for an end.
const BRACKETED: f64 = 2.0;
/// Points of the curve between two runs.
const BETWEEN: usize = 6;

/// The model at a point of the linearised path.
struct Node {
    /// `q`, relative to the optimum.
    by: f64,
    x: DVector<f64>,
    /// Measured minus model (mN).
    gap_mn: DVector<f64>,
    jacobian_mn: DMatrix<f64>,
}

impl Profiler<'_> {
    /// The profile to both sides by a few runs of the model with derivatives.
    ///
    /// # Errors
    /// When the user asked to stop.
    pub fn swift(&self, target: &Target) -> Result<Profile, EvaluationFailure> {
        let quantile = self.statistics.quantile(&target.gradient);
        let linear = self.statistics.seen_half_width(&target.gradient);
        let mut found = Profile { points: vec![(0.0, 0.0)], ends: [None; 2] };
        for (k, side) in [-1.0, 1.0].into_iter().enumerate() {
            let room = target.room()[k];
            let mut nodes = vec![Node {
                by: 0.0,
                x: DVector::from_column_slice(&self.fit.solution.x),
                gap_mn: self.fit.gap_mn.clone(),
                jacobian_mn: self.fit.jacobian_mn.clone(),
            }];
            let least = self.refitted(target, &nodes[0], &nodes[0], 0.0);
            let mut by = linear.min(room);
            for _ in 0..MOST_RUNS {
                let Some(node) = self.node(target, side * by)? else {
                    // The model cannot be computed there: nearer, as far as one can go.
                    by = 0.5 * (by + nodes.iter().map(|n| n.by.abs()).fold(0.0, f64::max));
                    continue;
                };
                let rise = self.refitted(target, &node, &node, 0.0) - least;
                let at = nodes.partition_point(|n| n.by.abs() < by);
                nodes.insert(at, node);
                let curve = self.curve(target, &nodes, least);
                let end = crossing(&curve, quantile * quantile);
                found.ends[k] = end;
                let root = rise.max(0.0).sqrt() / quantile;
                if (end.is_some() && root < BRACKETED) || (end.is_none() && by >= room) {
                    break;
                }
                // Too far beyond the end, or not there yet: where the root of the rise, straight from the optimum, would be.
                by = end.map_or_else(|| (by * (1.1 / root).clamp(1.3, 3.0)).min(room), f64::abs);
            }
            found.points.extend(self.curve(target, &nodes, least).into_iter().skip(1));
        }
        Ok(self.with_unseen(target, found))
    }

    /// Starts the runs at the ends of the linearised interval.
    pub fn prefetch(&self, target: &Target) -> Vec<Run> {
        let linear = self.statistics.seen_half_width(&target.gradient);
        let at = |(side, room): (f64, f64)| {
            let x = self.predicted(target, side * linear.min(room));
            self.setup.submit(&x, &[], true, Priority::Speculative)
        };
        [-1.0, 1.0].into_iter().zip(target.room()).flat_map(at).collect()
    }

    /// The model where the linearised path has moved `q` by `by`; none where it cannot be computed.
    fn node(&self, target: &Target, by: f64) -> Result<Option<Node>, EvaluationFailure> {
        let x = self.predicted(target, by);
        let mut problem = ForceProblem::new(self.setup, &[]);
        let computed = EvaluationFailure::or_none(problem.with_jacobian(&x))?;
        Ok(computed.map(|(r, jacobian_mn)| {
            let gap_mn = -DVector::from_vec(r);
            Node { by, x: DVector::from_vec(x), gap_mn, jacobian_mn }
        }))
    }

    /// `q` and the rise of chi^2 from the optimum outwards.
    fn curve(&self, target: &Target, nodes: &[Node], least: f64) -> Vec<(f64, f64)> {
        let mut curve = vec![(nodes[0].by, 0.0)];
        for pair in nodes.windows(2) {
            for i in 1..=BETWEEN {
                let part = i as f64 / BETWEEN as f64;
                let rise = self.refitted(target, &pair[0], &pair[1], part) - least;
                curve.push((pair[0].by + part * (pair[1].by - pair[0].by), rise));
            }
        }
        curve
    }

    /// chi^2 a part of the way from one node to the next, everything but `q` refitted.
    fn refitted(&self, target: &Target, a: &Node, b: &Node, part: f64) -> f64 {
        let step = &b.x - &a.x;
        let (t, u) = (part, 1.0 - part);
        let (slope_a, slope_b) = (-(&a.jacobian_mn * &step), -(&b.jacobian_mn * &step));
        let gap = &a.gap_mn * (u * u * (1.0 + 2.0 * t))
            + slope_a * (t * u * u)
            + &b.gap_mn * (t * t * (3.0 - 2.0 * t))
            - slope_b * (t * t * u);
        let jacobian = &a.jacobian_mn * u + &b.jacobian_mn * t;
        let x = &a.x + step * t;
        let prior_of = |j: usize| target.gradient[j] == 0.0;
        let (design, rest) = self.statistics.stacked(&self.fit.prior, &x, (&jacobian, &gap), &prior_of);
        let reduced = Given::<()>::reduced(&design, &target.gradient, main_variable(target));
        if reduced.ncols() == 0 {
            return rest.norm_squared();
        }
        rest.norm_squared() - Decomposition::linear(reduced, &rest).taken_up()
    }
}

/// Where a curve first passes a level, straight between its points in the root of the rise.
fn crossing(curve: &[(f64, f64)], level: f64) -> Option<f64> {
    let root = |rise: f64| rise.max(0.0).sqrt();
    let pair = curve.windows(2).find(|w| w[1].1 >= level)?;
    let ((a, low), (b, high)) = (pair[0], pair[1]);
    let part = (level.sqrt() - root(low)) / (root(high) - root(low)).max(f64::MIN_POSITIVE);
    Some(a + part.clamp(0.0, 1.0) * (b - a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_crossed_at_its_quantile() {
        let curve: Vec<(f64, f64)> = (0..10).map(|i| (f64::from(i), 0.25 * f64::from(i * i))).collect();
        assert!((crossing(&curve, 3.8416).unwrap() - 3.92).abs() < 1e-12);
        assert_eq!(crossing(&curve, 100.0), None);
    }
}
