//! The punch's motion.

use crate::error::MakerError;
use serde::{Deserialize, Serialize};

/// Piecewise linear displacement, positive into the sample, 0 at its nominal surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    points: Vec<(f64, f64)>,
}

impl Motion {
    /// From points (s, m).
    ///
    /// # Errors
    /// When there are fewer than two, a number is not finite, or time does not grow.
    pub fn new(points: Vec<(f64, f64)>) -> Result<Self, MakerError> {
        if points.len() < 2 || points.iter().any(|p| !p.0.is_finite() || !p.1.is_finite()) {
            return Err(MakerError::Invalid("a motion needs two points of finite numbers"));
        }
        if points.windows(2).any(|w| w[1].0 <= w[0].0) {
            return Err(MakerError::Invalid("the motion's times do not grow"));
        }
        Ok(Self { points })
    }

    /// The points (s, m).
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }

    /// Displacement (m) at a time (s); constant before the first and after the last point.
    pub fn at(&self, time: f64) -> f64 {
        let i = self.points.partition_point(|p| p.0 <= time);
        match (i.checked_sub(1).map(|i| self.points[i]), self.points.get(i)) {
            (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (time - a.0) / (b.0 - a.0),
            (Some(a), None) => a.1,
            (None, Some(b)) => b.1,
            (None, None) => 0.0,
        }
    }

    /// Every displacement changed by a function of time (s) and displacement (m).
    #[must_use]
    pub fn map(&self, change: impl Fn(f64, f64) -> f64) -> Self {
        Self { points: self.points.iter().map(|&(t, d)| (t, change(t, d))).collect() }
    }

    /// Also with points at these times (s), where they lie within.
    #[must_use]
    pub fn refined(&self, times: impl IntoIterator<Item = f64>) -> Self {
        let (from, to) = (self.points[0].0, self.points[self.points.len() - 1].0);
        let new = times.into_iter().filter(|&t| t > from && t < to).map(|t| (t, self.at(t)));
        let mut points: Vec<(f64, f64)> = self.points.iter().copied().chain(new).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|b, a| b.0 - a.0 < 1e-9);
        Self { points }
    }

    /// Greatest displacement (m).
    pub fn depth(&self) -> f64 {
        self.points.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_points_and_beyond() {
        let motion = Motion::new(vec![(0.0, -1e-4), (1.0, 1e-3), (2.0, 1e-3)]).unwrap();
        assert!((motion.at(0.5) - 4.5e-4).abs() < 1e-18 && motion.at(-1.0) == -1e-4 && motion.at(9.0) == 1e-3);
        assert_eq!(motion.refined([0.5, 1.0, 7.0]).points().len(), 4);
        assert!(Motion::new(vec![(0.0, 0.0), (0.0, 1.0)]).is_err());
    }
}
