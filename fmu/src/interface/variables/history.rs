//! A displacement history of the user's own, as parameters: only FMI 3.0 has arrays to give it.

use super::{SettingsError, VariableError};
use crate::motion::protocol::{Protocol, ProtocolError};
use serde::{Deserialize, Serialize};

/// Most points of a history: a day at nearly one a second; one is cheap, memory for absurd numbers is not.
pub const MOST_POINTS: u64 = 1 << 16;

/// From so many points on it is a motion.
const LEAST_MOTION: usize = 2;

/// Points between which the punch moves at constant velocity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct History {
    /// Times since the start of the run (s).
    pub(super) time: Vec<f64>,
    /// Displacements (m).
    pub(super) displacement: Vec<f64>,
}

impl Default for History {
    /// One point: no motion.
    fn default() -> Self {
        Self { time: vec![0.0], displacement: vec![0.0] }
    }
}

impl History {
    /// Number of points.
    pub fn points(&self) -> usize {
        self.time.len()
    }

    /// Makes it `points` long; what it held is lost.
    ///
    /// # Errors
    /// When there are none or too many.
    pub(super) fn resize(&mut self, points: u64) -> Result<(), VariableError> {
        if !(1..=MOST_POINTS).contains(&points) {
            let (name, value) = (super::ports::POINTS.to_owned(), points as f64);
            return Err(VariableError::OutOfRange {
                name,
                value,
                min: 1.0,
                max: MOST_POINTS as f64,
                unit: "",
            });
        }
        self.time = (0..points).map(|point| point as f64).collect();
        self.displacement = vec![0.0; self.time.len()];
        Ok(())
    }

    /// The motion, where there is one.
    ///
    /// # Errors
    /// Names the first point that does not come after the one before it.
    pub fn protocol(&self) -> Result<Option<Protocol>, ProtocolError> {
        if self.points() < LEAST_MOTION {
            return Ok(None);
        }
        let points = self.time.iter().copied().zip(self.displacement.iter().copied());
        Protocol::new(points.collect()).map(Some)
    }

    /// Displacement at the start (m), where there is a motion.
    pub fn start(&self) -> Option<f64> {
        (self.points() >= LEAST_MOTION).then(|| self.displacement[0])
    }

    /// Refuses what nobody could have set.
    pub(super) fn validate(&self) -> Result<(), SettingsError> {
        let numbers = || self.time.iter().chain(&self.displacement);
        let sound = self.time.len() == self.displacement.len()
            && (1..=MOST_POINTS).contains(&(self.time.len() as u64))
            && numbers().all(|number| number.is_finite());
        if sound { Ok(()) } else { Err(SettingsError::History) }
    }
}
