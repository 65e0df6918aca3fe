//! Phases of a test, told from the displacement alone: for weights per phase and for reports.

use super::measurement::Measurement;
use clap::ValueEnum;

/// What the punch is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, ValueEnum)]
pub enum Phase {
    /// Above the surface.
    Approach,
    /// Moving into the sample.
    Ramp,
    /// Resting in the sample.
    Hold,
    /// Moving out of the sample.
    Unload,
}

/// A velocity below this part of the fastest is rest.
const REST: f64 = 1e-3;

/// Phase at each point: that of the interval which ends there.
pub fn phases(m: &Measurement) -> Vec<Phase> {
    let velocity: Vec<f64> = (1..m.len())
        .map(|i| (m.displacement_m[i] - m.displacement_m[i - 1]) / (m.time_s[i] - m.time_s[i - 1]))
        .collect();
    let fastest = velocity.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    let at = |i: usize| {
        let v = velocity[i.saturating_sub(1)];
        if m.displacement_m[i] <= 0.0 {
            Phase::Approach
        } else if v > REST * fastest {
            Phase::Ramp
        } else if v < -REST * fastest {
            Phase::Unload
        } else {
            Phase::Hold
        }
    };
    (0..m.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trapezoid_has_four_phases() {
        let m = Measurement {
            time_s: vec![0.0, 1.0, 2.0, 3.0, 10.0, 11.0, 12.0],
            displacement_m: vec![-1.0, 0.0, 1.0, 1.0, 1.0, 0.5, -1.0],
            ..Measurement::default()
        };
        use Phase::{Approach, Hold, Ramp, Unload};
        assert_eq!(phases(&m), [Approach, Approach, Ramp, Hold, Hold, Unload, Approach]);
    }
}
