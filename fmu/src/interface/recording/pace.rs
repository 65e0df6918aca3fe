//! When a frame is due.

use serde::{Deserialize, Serialize};

/// Travel of the punch from frame to frame over its radius.
const TRAVEL: f64 = 0.05;
/// The time since the last corner grows by this factor from frame to frame.
const GROWTH: f64 = 1.5;
/// In a corner the punch's velocity changes by this part of the largest one so far.
const CORNER: f64 = 0.5;
/// The first frame after a corner comes when the punch could have travelled this part of its radius.
const FIRST: f64 = 0.02;
/// Relative slack of times and travels.
const SLACK: f64 = 1e-9;

/// Which communication points become frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Frames {
    /// Where something changes: along the travel, at its corners, and ever wider apart while the punch rests.
    #[default]
    Adaptive,
    /// All of them.
    EveryStep,
}

/// Whether and where fields are written.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FieldSettings {
    /// Path of the .pvd file; nothing is written when it is empty.
    pub path: String,
    /// Which communication points become frames.
    pub frames: Frames,
    /// Least simulated time between two frames (s); corners and the end do not wait.
    pub interval: f64,
}

/// What decides over the next frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pace {
    frames: Frames,
    interval: f64,
    punch_radius: f64,
    /// Time (s) and displacement (m) of the last frame.
    last: (f64, f64),
    /// Time of the last corner (s) and the velocity after it (m/s).
    corner: (f64, f64),
    /// Largest velocity so far (m/s).
    fastest: f64,
}

impl Pace {
    /// At the start, which is a frame.
    pub fn new(settings: &FieldSettings, punch_radius: f64, time: f64, displacement: f64) -> Self {
        let (frames, interval) = (settings.frames, settings.interval);
        Self { frames, interval, punch_radius, last: (time, displacement), corner: (time, 0.0), fastest: 0.0 }
    }

    /// Takes note of the `velocity` (m/s) of the step that begins; whether its beginning must be a frame.
    pub fn turns(&mut self, time: f64, displacement: f64, velocity: f64) -> bool {
        self.fastest = self.fastest.max(velocity.abs());
        if (velocity - self.corner.1).abs() <= CORNER * self.fastest {
            return false;
        }
        self.corner = (time, velocity);
        self.frames == Frames::Adaptive && displacement > 0.0 && self.is_new(time)
    }

    /// Forgets the turn of a step that failed; `before` is from before it. A frame of its beginning stays.
    pub fn unturn(&mut self, before: &Self) {
        (self.corner, self.fastest) = (before.corner, before.fastest);
    }

    /// Whether the end of a step is a frame.
    pub fn is_due(&self, time: f64, displacement: f64) -> bool {
        let since = time - self.last.0;
        if since < self.interval * (1.0 - SLACK) {
            return false;
        }
        match self.frames {
            Frames::EveryStep => true,
            Frames::Adaptive => {
                // Above the surface nothing depends on where the punch is.
                let travel = (displacement.max(0.0) - self.last.1.max(0.0)).abs();
                let first = FIRST * self.punch_radius / self.fastest;
                let aged = GROWTH * (self.last.0 - self.corner.0).max(0.0) + first;
                travel >= TRAVEL * self.punch_radius * (1.0 - SLACK) || time - self.corner.0 >= aged
            }
        }
    }

    /// Whether no frame shows `time` yet.
    pub fn is_new(&self, time: f64) -> bool {
        time - self.last.0 > SLACK * time.abs().max(1.0)
    }

    /// A frame was written.
    pub fn note(&mut self, time: f64, displacement: f64) {
        self.last = (time, displacement);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Protocol;

    /// Times of the frames of a protocol communicated every `step` seconds.
    fn frames(settings: &FieldSettings, protocol: &Protocol, times: &[f64]) -> Vec<f64> {
        let at = |t| protocol.displacement(t);
        let mut pace = Pace::new(settings, 2e-3, times[0], at(times[0]));
        let mut shown = vec![times[0]];
        for pair in times.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            if pace.turns(from, at(from), (at(to) - at(from)) / (to - from)) {
                pace.note(from, at(from));
                shown.push(from);
            }
            if pace.is_due(to, at(to)) {
                pace.note(to, at(to));
                shown.push(to);
            }
        }
        shown
    }

    fn times(step: f64, end: f64) -> Vec<f64> {
        (0..=(end / step).round() as usize).map(|k| k as f64 * step).collect()
    }

    #[test]
    fn a_test_gives_a_small_series_with_its_peak() {
        let points = vec![(0.0, -1e-4), (0.7, 1e-3), (90.7, 1e-3), (94.7, -3e-3), (154.7, -3e-3)];
        let protocol = Protocol::new(points).unwrap();
        let shown = frames(&FieldSettings::default(), &protocol, &times(0.01, 154.7));
        assert!(shown.windows(2).all(|w| w[0] < w[1]), "{shown:?}");
        assert!((30..70).contains(&shown.len()), "{}", shown.len());
        for corner in [0.7, 90.7] {
            assert!(shown.iter().any(|t| (t - corner).abs() < 1e-9), "{corner} s is missing in {shown:?}");
        }
        let within = |from, to| shown.iter().filter(|t| (from..to).contains(*t)).count();
        assert!((8..20).contains(&within(0.0, 0.7)) && (12..25).contains(&within(0.71, 90.0)), "{shown:?}");
    }

    /// A measured hold is never quite at rest.
    #[test]
    fn noise_makes_no_frames() {
        let points: Vec<_> = (0..4000)
            .map(|k| {
                let time = 0.02 * f64::from(k);
                let noise = 5e-7 * f64::from(k * 7919 % 13 - 6) / 6.0;
                (time, (1.6e-3 * (time - 2.0).max(0.0) - 1e-4).min(1e-3) + noise)
            })
            .collect();
        let all: Vec<f64> = points.iter().map(|p| p.0).collect();
        let shown = frames(&FieldSettings::default(), &Protocol::new(points).unwrap(), &all);
        assert!(shown.len() < 60, "{}: {shown:?}", shown.len());
    }

    #[test]
    fn every_step_or_at_an_interval() {
        let protocol = Protocol::new(vec![(0.0, 0.0), (1.0, 1e-3)]).unwrap();
        let mut settings = FieldSettings { frames: Frames::EveryStep, ..Default::default() };
        assert_eq!(frames(&settings, &protocol, &times(0.1, 1.0)).len(), 11);
        settings.interval = 0.25;
        let shown = frames(&settings, &protocol, &times(0.05, 1.0));
        assert_eq!(shown.len(), 5, "{shown:?}");
    }
}
