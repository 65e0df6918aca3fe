//! Displacement of the punch in time: piecewise linear, and the paper's test as a trapezoid.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A history that is not one.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProtocolError {
    /// No point at all.
    #[error("a protocol needs at least one point")]
    Empty,
    /// Not a finite number.
    #[error("point {index}: time {time} s and displacement {displacement} m must be finite numbers")]
    NotFinite {
        /// Number of the point, from 0.
        index: usize,
        /// Its time (s).
        time: f64,
        /// Its displacement (m).
        displacement: f64,
    },
    /// Time does not increase.
    #[error("point {index}: time {time} s does not come after {previous} s")]
    NotIncreasing {
        /// Number of the point, from 0.
        index: usize,
        /// Its time (s).
        time: f64,
        /// Time of the point before it (s).
        previous: f64,
    },
}

/// Piecewise linear displacement history; constant before the first and after the last point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Protocol {
    points: Vec<(f64, f64)>,
}

impl Protocol {
    /// From points (time (s), displacement (m)) with strictly increasing times.
    ///
    /// # Errors
    /// Names the first point that is not a number or not later than the one before it.
    pub fn new(points: Vec<(f64, f64)>) -> Result<Self, ProtocolError> {
        if points.is_empty() {
            return Err(ProtocolError::Empty);
        }
        for (index, &(time, displacement)) in points.iter().enumerate() {
            if !time.is_finite() || !displacement.is_finite() {
                return Err(ProtocolError::NotFinite { index, time, displacement });
            }
            if index > 0 && time <= points[index - 1].0 {
                return Err(ProtocolError::NotIncreasing { index, time, previous: points[index - 1].0 });
            }
        }
        Ok(Self { points })
    }

    /// Breakpoints: time (s), displacement (m).
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }

    /// Time of the first point (s).
    pub fn start_time(&self) -> f64 {
        self.points[0].0
    }

    /// Time of the last point (s).
    pub fn end_time(&self) -> f64 {
        self.points[self.points.len() - 1].0
    }

    /// Displacement (m) at a time (s).
    pub fn displacement(&self, time: f64) -> f64 {
        let after = self.points.partition_point(|&(t, _)| t <= time);
        match (after.checked_sub(1).map(|i| self.points[i]), self.points.get(after)) {
            (Some((t0, d0)), Some(&(t1, d1))) => d0 + (d1 - d0) * ((time - t0) / (t1 - t0)),
            (Some((_, last)), None) => last,
            (None, _) => self.points[0].1,
        }
    }

    /// Breakpoints strictly between two times (s).
    pub fn breakpoints_between(&self, from: f64, to: f64) -> &[(f64, f64)] {
        let first = self.points.partition_point(|&(t, _)| t <= from);
        let last = self.points.partition_point(|&(t, _)| t < to);
        &self.points[first..last.max(first)]
    }
}

/// The paper's test (design, section 1): approach, load, hold, unload, rest, return, rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Trapezoid {
    /// Height above the surface at the start (m).
    pub start_gap: f64,
    /// Velocity of loading (m/s).
    pub loading_rate: f64,
    /// Largest indentation (m).
    pub depth: f64,
    /// Hold at the largest indentation (s).
    pub hold: f64,
    /// Velocity of unloading and of the return (m/s).
    pub unloading_rate: f64,
    /// Height above the surface after unloading (m).
    pub retraction: f64,
    /// Rest at the retracted height (s).
    pub rest_after_retraction: f64,
    /// Height above the surface after the return (m).
    pub return_height: f64,
    /// Rest at the return height (s).
    pub rest_after_return: f64,
    /// Number of cycles.
    pub cycles: i32,
}

impl Default for Trapezoid {
    fn default() -> Self {
        Self::p2()
    }
}

impl Trapezoid {
    /// Protocol P1: loading at 1.0 mm/s. One cycle.
    pub fn p1() -> Self {
        Self { loading_rate: 1.0e-3, retraction: 3.8e-3, ..Self::p2() }
    }

    /// Protocol P2: loading at 1.6 mm/s. One cycle.
    pub fn p2() -> Self {
        Self {
            start_gap: 0.1e-3,
            loading_rate: 1.6e-3,
            depth: 1.0e-3,
            hold: 90.0,
            unloading_rate: 1.0e-3,
            retraction: 3.0e-3,
            rest_after_retraction: 60.0,
            return_height: 0.1e-3,
            rest_after_return: 60.0,
            cycles: 1,
        }
    }

    /// Time at the end of the first hold (s).
    pub fn end_of_first_hold(&self) -> f64 {
        (self.start_gap + self.depth) / self.loading_rate + self.hold
    }

    /// The history from approach to the end of the first hold, where the paper's fit ends.
    ///
    /// # Errors
    /// When a rate is zero or a value not a number.
    pub fn first_hold(&self) -> Result<Protocol, ProtocolError> {
        let all = self.protocol()?;
        let end = self.end_of_first_hold();
        let kept = all.points.iter().copied().take_while(|&(time, _)| time < end);
        Protocol::new(kept.chain([(end, self.depth)]).collect())
    }

    /// The whole history, starting at time 0. Legs of no duration leave no point.
    ///
    /// # Errors
    /// When a rate is zero or a value not a number.
    pub fn protocol(&self) -> Result<Protocol, ProtocolError> {
        let mut points = vec![(0.0, -self.start_gap)];
        let mut leg = |duration: f64, displacement: f64| {
            let (time, _) = points[points.len() - 1];
            // NaN passes, for `Protocol::new` to name.
            if duration > 0.0 || duration.is_nan() {
                points.push((time + duration, displacement));
            }
        };
        let mut height = self.start_gap;
        for _ in 0..self.cycles {
            leg((height + self.depth) / self.loading_rate, self.depth);
            leg(self.hold, self.depth);
            leg((self.depth + self.retraction) / self.unloading_rate, -self.retraction);
            leg(self.rest_after_retraction, -self.retraction);
            leg((self.retraction - self.return_height).abs() / self.unloading_rate, -self.return_height);
            leg(self.rest_after_return, -self.return_height);
            height = self.return_height;
        }
        Protocol::new(points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p1_has_the_times_of_the_paper() {
        let protocol = Trapezoid { cycles: 6, ..Trapezoid::p1() }.protocol().unwrap();
        // Seen in the measured histories: second loading starts at 219.6 s.
        let expected = [(0.0, -0.1e-3), (1.1, 1e-3), (91.1, 1e-3), (95.9, -3.8e-3), (155.9, -3.8e-3)];
        for (&(t, d), (te, de)) in protocol.points().iter().zip(expected) {
            approx::assert_relative_eq!(t, te, epsilon = 1e-12);
            approx::assert_relative_eq!(d, de, epsilon = 1e-15);
        }
        approx::assert_relative_eq!(protocol.displacement(219.6 + 0.1), 0.0, epsilon = 1e-9);
        assert_eq!(protocol.points().len(), 1 + 6 * 6);
    }

    #[test]
    fn interpolates_and_splits() {
        let p = Protocol::new(vec![(0.0, 0.0), (1.0, 2.0), (3.0, 0.0)]).unwrap();
        assert_eq!([-1.0, 0.5, 1.0, 2.0, 9.0].map(|t| p.displacement(t)), [0.0, 1.0, 2.0, 1.0, 0.0]);
        assert_eq!(p.breakpoints_between(0.0, 3.0), [(1.0, 2.0)]);
        assert_eq!(p.breakpoints_between(1.0, 3.0), []);
        assert!(matches!(
            Protocol::new(vec![(0.0, 0.0), (0.0, 1.0)]),
            Err(ProtocolError::NotIncreasing { index: 1, .. })
        ));
    }
}
