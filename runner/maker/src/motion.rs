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
        let (from, to) = self.span();
        let new = times.into_iter().filter(|&t| t > from && t < to).map(|t| (t, self.at(t)));
        let mut points: Vec<(f64, f64)> = self.points.iter().copied().chain(new).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|b, a| b.0 - a.0 < 1e-9);
        Self { points }
    }

    /// First and last time (s).
    pub fn span(&self) -> (f64, f64) {
        (self.points[0].0, self.points[self.points.len() - 1].0)
    }

    /// With a swing of this amplitude (m), frequency (Hz) and decay (s) after every end of a loading ramp.
    #[must_use]
    pub fn with_overshoot(&self, length: f64, frequency: f64, decay_s: f64) -> Self {
        let ends = self.points.windows(3).filter(|w| w[1].1 > w[0].1 && w[1].1 >= w[2].1 && w[1].1 > 0.0);
        let ends: Vec<(f64, f64)> = ends.map(|w| (w[1].0, w[2].0)).collect();
        let grid = ends.iter().flat_map(|&(from, to)| {
            let steps = (12.0 * frequency * 4.0 * decay_s).ceil() as usize;
            (1..=steps).map(move |i| from + i as f64 / (12.0 * frequency)).filter(move |t| *t < to)
        });
        self.refined(grid).map(|t, d| {
            let swing = ends.iter().find(|(from, to)| t > *from && t < *to).map_or(0.0, |(from, _)| {
                let since = t - from;
                (-since / decay_s).exp() * (std::f64::consts::TAU * frequency * since).sin()
            });
            d + length * swing
        })
    }

    /// As it passes through play (m) that is taken up in the direction of loading at the start.
    #[must_use]
    pub fn with_play(&self, length: f64) -> Self {
        let mut points: Vec<(f64, f64)> = vec![self.points[0]];
        let mut behind = self.points[0].1;
        for pair in self.points.windows(2) {
            let ((from, a), (to, b)) = (pair[0], pair[1]);
            // The punch rests until the play is taken up, then follows.
            let end = behind.clamp(b, b + length);
            let begin = if b > a { behind } else { behind - length };
            let taken = if b == a { 0.0 } else { ((begin - a) / (b - a)).clamp(0.0, 1.0) };
            if taken > 1e-9 && taken < 1.0 - 1e-9 {
                points.push((from + taken * (to - from), behind));
            }
            points.push((to, end));
            behind = end;
        }
        Self { points }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_points_and_beyond() {
        let motion = Motion::new(vec![(0.0, -1e-4), (1.0, 1e-3), (2.0, 1e-3)]).unwrap();
        assert!(
            (motion.at(0.5) - 4.5e-4).abs() < 1e-18 && motion.at(-1.0) == -1e-4 && motion.at(9.0) == 1e-3
        );
        assert_eq!(motion.refined([0.5, 1.0, 7.0]).points().len(), 4);
        assert!(Motion::new(vec![(0.0, 0.0), (0.0, 1.0)]).is_err());
    }

    #[test]
    fn play_holds_the_punch_after_a_reversal() {
        let motion =
            Motion::new(vec![(0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (3.0, 1.0)]).unwrap().with_play(0.1);
        assert!((motion.at(1.0) - 1.0).abs() < 1e-12 && (motion.at(1.05) - 1.0).abs() < 1e-12);
        assert!((motion.at(1.5) - 0.6).abs() < 1e-12 && (motion.at(2.0) - 0.1).abs() < 1e-12);
        assert!((motion.at(2.05) - 0.1).abs() < 1e-12 && (motion.at(2.5) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn overshoot_follows_the_ramp_and_dies_out() {
        let motion = Motion::new(vec![(0.0, -1e-4), (1.0, 1e-3), (90.0, 1e-3)]).unwrap();
        let swung = motion.with_overshoot(1e-5, 5.0, 0.2);
        assert!((swung.at(1.05) - 1e-3) > 5e-6 && (swung.at(1.0) - 1e-3).abs() < 1e-12);
        assert!((swung.at(5.0) - 1e-3).abs() < 1e-6);
    }
}
