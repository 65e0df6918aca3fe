//! The force of one Prony term on a recorded motion: Boltzmann's superposition over the motion's own history.

use super::rig::Law;

/// Parts into which a moving piece of the path is divided.
const PARTS: usize = 64;

/// The path's force over shear modulus: times (s), and its elastic force (m^2) there; the times asked for are among them.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    time_s: Vec<f64>,
    elastic: Vec<f64>,
    asked: Vec<usize>,
}

impl History {
    /// Of a path (corners: time in s, depth in m) at increasing times (s).
    pub fn new(path: &[(f64, f64)], law: &Law, times: &[f64]) -> Self {
        let mut nodes: Vec<(f64, Option<usize>)> =
            times.iter().enumerate().map(|(k, t)| (*t, Some(k))).collect();
        for piece in path.windows(2) {
            let ((from, a), (to, b)) = (piece[0], piece[1]);
            let parts = if law.at(a) == law.at(b) { 1 } else { PARTS };
            nodes.extend((0..=parts).map(|k| (from + (to - from) * k as f64 / parts as f64, None)));
        }
        nodes.sort_by(|x, y| x.0.total_cmp(&y.0));
        let mut asked = vec![0; times.len()];
        for (place, node) in nodes.iter().enumerate() {
            if let Some(k) = node.1 {
                asked[k] = place;
            }
        }
        let elastic = nodes.iter().map(|(t, _)| law.at(depth_at(path, *t))).collect();
        Self { time_s: nodes.into_iter().map(|n| n.0).collect(), elastic, asked }
    }

    /// Elastic force over shear modulus (m^2) at the times asked for.
    pub fn elastic(&self) -> Vec<f64> {
        self.asked.iter().map(|k| self.elastic[*k]).collect()
    }

    /// `int exp(-(t - s) / tau) dF_elastic(s)` at the times asked for (m^2), exact where the elastic force is linear.
    pub fn relaxed(&self, tau_s: f64) -> Vec<f64> {
        let mut force = self.elastic[0];
        let mut all = vec![force];
        for k in 1..self.time_s.len() {
            let x = (self.time_s[k] - self.time_s[k - 1]) / tau_s;
            let mean = if x > 1e-8 { -(-x).exp_m1() / x } else { 1.0 };
            force = force * (-x).exp() + (self.elastic[k] - self.elastic[k - 1]) * mean;
            all.push(force);
        }
        self.asked.iter().map(|k| all[*k]).collect()
    }
}

/// Depth (m) on a path at a time (s), constant before and after it.
pub fn depth_at(path: &[(f64, f64)], time_s: f64) -> f64 {
    let k = path.partition_point(|p| p.0 <= time_s);
    match (k.checked_sub(1).map(|i| path[i]), path.get(k)) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (time_s - a.0) / (b.0 - a.0),
        (Some(a), None) => a.1,
        (None, b) => b.map_or(0.0, |b| b.1),
    }
}
