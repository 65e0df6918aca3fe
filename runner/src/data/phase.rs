//! Phases of a test, told from the displacement alone: for weights per phase and for reports.

use super::cycle::cycles_of;
use super::measurement::Measurement;
use super::motion::motion;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the punch is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Above the surface, before a loading.
    Approach,
    /// Moving into the sample.
    Ramp,
    /// Resting in the sample: the first hundredth of the hold, and less.
    HoldEarly,
    /// Resting in the sample: from a hundredth to a tenth of the hold.
    HoldMiddle,
    /// Resting in the sample: from a tenth of the hold to its end.
    HoldLate,
    /// Moving out of the sample, up to its undeformed surface.
    Unload,
    /// Above the surface, after an unloading.
    Recovery,
}

impl Phase {
    /// All phases, in the order of a cycle.
    pub const ALL: [Self; 7] = [
        Self::Approach,
        Self::Ramp,
        Self::HoldEarly,
        Self::HoldMiddle,
        Self::HoldLate,
        Self::Unload,
        Self::Recovery,
    ];

    /// Its name on the command line, in files and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Approach => "approach",
            Self::Ramp => "ramp",
            Self::HoldEarly => "hold-early",
            Self::HoldMiddle => "hold-middle",
            Self::HoldLate => "hold-late",
            Self::Unload => "unload",
            Self::Recovery => "recovery",
        }
    }

    /// The phases that a name means, in any case: one, or the three of the `hold`.
    pub fn named(name: &str) -> Option<&'static [Self]> {
        let name = name.to_lowercase();
        if name == "hold" {
            return Some(&Self::ALL[2..5]);
        }
        let at = Self::ALL.iter().position(|p| p.name() == name)?;
        Some(&Self::ALL[at..=at])
    }

    /// Third of the hold, in logarithmic time: the last three decades before its end have one each, so that
    /// the thirds do not depend on how soon after the ramp the first sample fell.
    pub fn of_hold(since_ramp_s: f64, hold_s: f64) -> Self {
        match since_ramp_s / hold_s {
            part if part <= 1e-2 => Self::HoldEarly,
            part if part <= 1e-1 => Self::HoldMiddle,
            _ => Self::HoldLate,
        }
    }
}

/// Phase at each point: that of the interval which ends there.
pub fn phases(m: &Measurement) -> Vec<Phase> {
    let motion = motion(&m.time_s, &m.displacement_m);
    let cycles = cycles_of(m, &motion);
    let at =
        |(&t, &d): (&f64, &f64)| match cycles.iter().rev().find(|c| t > c.times.start_s).or(cycles.first()) {
            Some(cycle) => cycle.phase_at(t),
            // No loading at all: the best that can be said.
            None if d <= 0.0 => Phase::Approach,
            None => Phase::HoldLate,
        };
    m.time_s.iter().zip(&m.displacement_m).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use Phase::{Approach, HoldEarly, HoldLate, HoldMiddle, Ramp, Recovery, Unload};

    fn measurement(points: &[(f64, f64)]) -> Measurement {
        let (time_s, displacement_m) = points.iter().copied().unzip();
        Measurement { time_s, displacement_m, ..Measurement::default() }
    }

    #[test]
    fn a_trapezoid_has_its_phases() {
        let m = measurement(&[
            (0.0, -1.0),
            (1.0, 0.0),
            (2.0, 1.0),
            (2.05, 1.0),
            (2.09, 1.0),
            (2.6, 1.0),
            (3.0, 1.0),
            (12.0, 1.0),
            (13.0, 0.5),
            (14.0, 0.0),
            (16.0, -1.0),
            (20.0, -1.0),
        ]);
        let hold = [HoldEarly, HoldEarly, HoldMiddle, HoldMiddle, HoldLate];
        let expected =
            [&[Approach, Approach, Ramp], &hold[..], &[Unload, Unload, Recovery, Recovery]].concat();
        assert_eq!(phases(&m), expected);
    }

    #[test]
    fn names_are_read_and_hold_means_its_thirds() {
        for phase in Phase::ALL {
            assert_eq!(Phase::named(phase.name()), Some(&[phase][..]));
        }
        assert_eq!(Phase::named("Hold"), Some(&[HoldEarly, HoldMiddle, HoldLate][..]));
        assert_eq!(Phase::named("dwell"), None);
    }
}
