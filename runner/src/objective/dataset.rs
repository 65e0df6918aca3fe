//! A measurement as part of the objective: its job, and the weight of each point.

use crate::data::noise::Noise;
use crate::data::phase::phases;
use crate::data::{DataError, Measurement, NoiseModel, Phase, Problem, protocol_of};
use crate::pool::{ForceCurve, Job};
use poropunch::motion::protocol::{Protocol, ProtocolError};
use std::collections::BTreeMap;
use std::sync::Arc;
use thiserror::Error;

/// A measurement with its motion and weights.
#[derive(Debug, Clone)]
pub struct Dataset {
    /// What was measured.
    pub measurement: Measurement,
    /// How uncertain it is.
    pub noise: Noise,
    /// Phase of each point.
    pub phases: Vec<Phase>,
    protocol: Arc<Protocol>,
    time_s: Arc<[f64]>,
    /// Divides the difference in force (N): deviation over the root of the phase's weight.
    scale_n: Vec<f64>,
}

/// How the points are weighed.
#[derive(Debug, Clone, Default)]
pub struct Weights {
    /// Which uncertainty.
    pub noise: NoiseModel,
    /// Number of specimens behind the spread, where the file does not hold them.
    pub specimens: Option<usize>,
    /// Weight of each phase; 1 where absent, 0 leaves the phase out.
    pub phases: BTreeMap<Phase, f64>,
}

/// A measurement that cannot be fitted.
#[derive(Debug, Clone, Error)]
pub enum DatasetError {
    /// Something about the file.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The motion.
    #[error(transparent)]
    Protocol(#[from] ProtocolError),
    /// The noise model needs what the file does not have.
    #[error("{0}")]
    Noise(String),
}

/// Differences count in mN where no noise is known.
const UNIT_N: f64 = 1e-3;

impl Dataset {
    /// Prepares a measurement for a sample of the given height.
    ///
    /// # Errors
    /// When the history starts inside the sample or pierces it, or the noise model does not fit the file.
    pub fn new(
        measurement: Measurement,
        weights: &Weights,
        sample_height_m: Option<f64>,
    ) -> Result<Self, DatasetError> {
        check_motion(&measurement, sample_height_m)?;
        let noise = weights.noise.of(&measurement, weights.specimens).map_err(DatasetError::Noise)?;
        let phases = phases(&measurement);
        let scale = |(i, phase): (usize, &Phase)| {
            let weight = weights.phases.get(phase).copied().unwrap_or(1.0);
            noise.sigma_n.get(i).copied().unwrap_or(UNIT_N) / weight.sqrt()
        };
        let scale_n = phases.iter().enumerate().map(scale).collect();
        let protocol = Arc::new(protocol_of(&measurement)?);
        let time_s = measurement.time_s.clone().into();
        Ok(Self { measurement, noise, phases, protocol, time_s, scale_n })
    }

    /// The run that predicts this measurement with the given parameter values (SI).
    pub fn job(&self, parameters: &BTreeMap<String, f64>) -> Job {
        Job {
            parameters: parameters.clone(),
            protocol: Arc::clone(&self.protocol),
            time_s: Arc::clone(&self.time_s),
        }
    }

    /// Appends `(model - measured) / scale` of each point.
    pub fn append_residuals(&self, curve: &ForceCurve, residuals: &mut Vec<f64>) {
        let forces = curve.force_n().iter().zip(&self.measurement.force_n);
        residuals.extend(forces.zip(&self.scale_n).map(|((model, measured), s)| (model - measured) / s));
    }

    /// Appends the change of each point's residual with the force's `derivatives`, each with its factor.
    pub fn append_slopes(&self, derivatives: &[(&[f64], f64)], column: &mut Vec<f64>) {
        column.extend(self.scale_n.iter().enumerate().map(|(i, scale)| {
            derivatives.iter().map(|(force_n, factor)| factor * force_n[i]).sum::<f64>() / scale
        }));
    }

    /// Weighted residuals of each point.
    pub fn residuals(&self, curve: &ForceCurve) -> Vec<f64> {
        let mut residuals = Vec::with_capacity(self.measurement.len());
        self.append_residuals(curve, &mut residuals);
        residuals
    }

    /// Number of points that count.
    pub fn weighted_points(&self) -> usize {
        self.scale_n.iter().filter(|s| s.is_finite()).count()
    }

    /// What divides each point's difference in force (N).
    pub fn scale_n(&self) -> &[f64] {
        &self.scale_n
    }
}

fn check_motion(m: &Measurement, sample_height_m: Option<f64>) -> Result<(), DataError> {
    let fail = |problem| DataError { file: m.file.clone(), line: None, column: None, problem };
    let start = m.displacement_m.first().copied().unwrap_or(0.0);
    if start > 0.0 {
        return Err(fail(Problem::StartsInside { start_mm: start * 1e3 }));
    }
    match sample_height_m {
        Some(height) if m.depth_m() >= height => {
            Err(fail(Problem::TooDeep { depth_mm: m.depth_m() * 1e3, height_mm: height * 1e3 }))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measurement() -> Measurement {
        Measurement {
            time_s: vec![0.0, 1.0, 2.0, 3.0, 4.0],
            displacement_m: vec![-1e-3, 0.0, 1e-3, 1e-3, 1e-3],
            force_n: vec![0.0, 0.0, 4e-3, 3e-3, 2e-3],
            spread_n: Some(vec![1e-4; 5]),
            ..Measurement::default()
        }
    }

    #[test]
    fn residuals_are_differences_over_deviation_with_the_phase_weight() {
        let phases = [(Phase::HoldLate, 4.0), (Phase::Approach, 0.0)].into();
        let weights = Weights { phases, specimens: None, noise: NoiseModel::Spread };
        let dataset = Dataset::new(measurement(), &weights, None).unwrap();
        let curve = ForceCurve { values: vec![vec![9.0, 9.0, 5e-3, 3e-3, 2.5e-3]], ..ForceCurve::default() };
        let r = dataset.residuals(&curve);
        let expected = [0.0, 0.0, 10.0, 0.0, 2.0 * 5.0];
        assert!(r.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{r:?}");
        assert_eq!(dataset.weighted_points(), 3);
    }

    #[test]
    fn without_noise_the_difference_is_in_mn() {
        let weights = Weights { noise: NoiseModel::None, ..Weights::default() };
        let dataset = Dataset::new(measurement(), &weights, None).unwrap();
        let curve = ForceCurve { values: vec![vec![0.0; 5]], ..ForceCurve::default() };
        assert_eq!(dataset.residuals(&curve)[2], -4.0);
    }

    #[test]
    fn histories_that_start_inside_or_pierce_the_sample_are_refused() {
        let weights = Weights::default();
        assert!(matches!(
            Dataset::new(measurement(), &weights, Some(1e-3)),
            Err(DatasetError::Data(DataError { problem: Problem::TooDeep { .. }, .. }))
        ));
        let mut inside = measurement();
        inside.displacement_m[0] = 1e-4;
        assert!(matches!(
            Dataset::new(inside, &weights, None),
            Err(DatasetError::Data(DataError { problem: Problem::StartsInside { .. }, .. }))
        ));
    }
}
