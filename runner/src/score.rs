//! How well a curve meets a measurement, and the numbers the paper compares.

use crate::fit::Whitening;
use crate::noise::{Covariance, Observation};
use crate::pool::ForceCurve;
use nalgebra::DVector;

/// Peak and relaxation of a force history.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// Largest force (N).
    pub peak_n: f64,
    /// Time of the largest force (s).
    pub peak_time_s: f64,
    /// (peak - last force) / peak (-).
    pub relaxation: f64,
}

/// Model against measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Points.
    pub points: usize,
    /// Squared difference in units of its covariance (Eq. 16 in mN^2 when no noise is known).
    pub chi_square: f64,
    /// Root mean square difference in force (N).
    pub rms_n: f64,
    /// What was measured.
    pub measured: Shape,
    /// What the model gives.
    pub model: Shape,
}

impl Shape {
    /// Of forces (N) at times (s).
    pub fn of(time_s: &[f64], force_n: &[f64]) -> Self {
        let points = time_s.iter().copied().zip(force_n.iter().copied());
        let (peak_time_s, peak_n) = points.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
        let last = force_n.last().copied().unwrap_or_default();
        Self { peak_n, peak_time_s, relaxation: (peak_n - last) / peak_n }
    }
}

impl Score {
    /// Of a curve at the test's own times; `covariance` is that of the measured force minus this curve's.
    pub fn of(observation: &Observation, curve: &ForceCurve, covariance: &Covariance) -> Self {
        let m = &observation.measurement;
        let square: f64 = curve.force_n().iter().zip(&m.force_n).map(|(a, b)| (a - b).powi(2)).sum();
        Self {
            points: m.len(),
            chi_square: chi_square(observation, curve, covariance),
            rms_n: (square / m.len().max(1) as f64).sqrt(),
            measured: Shape::of(&m.time_s, &m.force_n),
            model: Shape::of(&curve.time_s, curve.force_n()),
        }
    }
}

/// Squared difference of a curve from what was measured, in units of its covariance.
pub fn chi_square(observation: &Observation, curve: &ForceCurve, covariance: &Covariance) -> f64 {
    let pairs = curve.force_n().iter().zip(&observation.measurement.force_n);
    let difference = pairs.map(|(model, measured)| (measured - model) * 1e3);
    covariance.apply(&DVector::from_iterator(observation.len(), difference)).norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peak_and_relaxation() {
        let shape = Shape::of(&[0.0, 1.0, 2.0], &[0.0, 10.0, 4.0]);
        assert_eq!(shape, Shape { peak_n: 10.0, peak_time_s: 1.0, relaxation: 0.6 });
    }
}
