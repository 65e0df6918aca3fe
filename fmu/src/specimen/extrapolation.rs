//! Where the next stage begins to iterate: the parabola through the last three points in time.

use serde::{Deserialize, Serialize};

/// How the unknowns moved over the last two stages.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Extrapolation {
    /// Mean rate over the last stage (unit of the unknown per s).
    rate: Vec<f64>,
    /// Change of that rate since the stage before (per s^2).
    acceleration: Vec<f64>,
    /// Time from the stage before to the last one (s); 0 when there was none.
    interval: f64,
}

impl Extrapolation {
    /// Nothing has moved yet.
    pub fn at_rest(unknowns: usize) -> Self {
        Self { rate: vec![0.0; unknowns], acceleration: vec![0.0; unknowns], interval: 0.0 }
    }

    /// Numbers of rates and of their changes.
    pub fn lengths(&self) -> [usize; 2] {
        [self.rate.len(), self.acceleration.len()]
    }

    /// Moves `x` along the parabola to the time `ahead` (s) later.
    pub fn extrapolate(&self, x: &mut [f64], ahead: f64) {
        let between_midpoints = 0.5 * (self.interval + ahead);
        for ((x, rate), acceleration) in x.iter_mut().zip(&self.rate).zip(&self.acceleration) {
            *x += (rate + acceleration * between_midpoints) * ahead;
        }
    }

    /// Takes note of a stage that led from `from` to `to` within `interval` (s).
    pub fn note(&mut self, from: &[f64], to: &[f64], interval: f64) {
        let between_midpoints = 0.5 * (self.interval + interval);
        let known = self.interval > 0.0;
        for (k, (from, to)) in from.iter().zip(to).enumerate() {
            let rate = (to - from) / interval;
            self.acceleration[k] = if known { (rate - self.rate[k]) / between_midpoints } else { 0.0 };
            self.rate[k] = rate;
        }
        self.interval = interval;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabolas_are_continued_exactly() {
        let parabola = |t: f64| [1.0 + 2.0 * t - 3.0 * t * t];
        let mut trend = Extrapolation::at_rest(1);
        trend.note(&parabola(0.0), &parabola(0.3), 0.3);
        trend.note(&parabola(0.3), &parabola(1.0), 0.7);
        let mut x = parabola(1.0);
        trend.extrapolate(&mut x, 1.5);
        approx::assert_relative_eq!(x[0], parabola(2.5)[0], max_relative = 1e-14);
    }
}
