//! Cycles of a test: loading, hold, unloading, recovery; told from the displacement alone.

use super::error::{DataError, Problem};
use super::measurement::Measurement;
use super::motion::{Line, Motion, Stroke, motion};
use super::phase::Phase;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// What the punch does when in a cycle. All times in s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CycleTimes {
    /// Counted from 1.
    pub number: usize,
    /// Beginning (s).
    pub start_s: f64,
    /// The punch passes the undeformed surface (s).
    pub ramp_start_s: f64,
    /// The punch comes to rest in the sample (s).
    pub ramp_end_s: f64,
    /// The punch leaves its rest (s).
    pub hold_end_s: f64,
    /// The punch passes the undeformed surface outwards (s).
    pub surface_s: Option<f64>,
    /// The punch comes to rest outside (s).
    pub withdrawn_s: Option<f64>,
    /// End (s).
    pub end_s: f64,
}

/// One loading of the sample and what follows until the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycle {
    /// Its times. It begins with the file or with the stroke that loads the sample; a punch that starts below the surface passes it
    /// there; what the file does not show to its end ends with the file.
    pub times: CycleTimes,
    /// Displacement of the hold (m).
    pub depth_m: f64,
    /// Line through the ramp.
    pub ramp: Line,
    /// Line through the unloading.
    pub unload: Option<Line>,
    /// Times nearer to a kink than this belong to the phase before it (s).
    kink_tolerance_s: f64,
}

impl Cycle {
    /// Length of the hold (s).
    pub fn hold_s(&self) -> f64 {
        self.times.hold_end_s - self.times.ramp_end_s
    }

    /// Phase at a time of this cycle.
    pub fn phase_at(&self, time_s: f64) -> Phase {
        let until = |end: f64| time_s <= end + self.kink_tolerance_s;
        if time_s <= self.times.ramp_start_s {
            Phase::Approach
        } else if until(self.times.ramp_end_s) {
            Phase::Ramp
        } else if until(self.times.hold_end_s) {
            Phase::of_hold(time_s - self.times.ramp_end_s, self.hold_s())
        } else if until(self.times.surface_s.unwrap_or(f64::INFINITY)) {
            Phase::Unload
        } else {
            Phase::Recovery
        }
    }

    /// Indices of the points between two times, the ends included within the tolerance of the kinks.
    pub fn points(&self, time_s: &[f64], from_s: f64, to_s: f64) -> Range<usize> {
        let first = time_s.partition_point(|&t| t < from_s - self.kink_tolerance_s);
        let last = time_s.partition_point(|&t| t <= to_s + self.kink_tolerance_s);
        first..last.max(first)
    }
}

/// Cycles of a measurement.
///
/// # Errors
/// When the displacement jumps, or never moves into the sample.
pub fn cycles(m: &Measurement) -> Result<Vec<Cycle>, DataError> {
    let motion = motion(&m.time_s, &m.displacement_m);
    check_jumps(m, &motion)?;
    let cycles = cycles_of(m, &motion);
    if cycles.is_empty() {
        return Err(m.error(Problem::NoRamp));
    }
    Ok(cycles)
}

/// As [`cycles`], and none where the punch never moves into the sample.
pub(super) fn cycles_of(m: &Measurement, motion: &Motion) -> Vec<Cycle> {
    let strokes = &motion.strokes;
    let loads: Vec<usize> =
        (0..strokes.len()).filter(|&k| strokes[k].is_inwards() && strokes[k].to_m > 0.0).collect();
    let end_of_file = m.time_s.last().copied().unwrap_or(0.0);
    let cycle = |(i, &k): (usize, &usize)| {
        let load = &strokes[k];
        let next = loads.get(i + 1).map(|&n| &strokes[n]);
        let end_s = next.map_or(end_of_file, |n| n.start_s);
        let after = &strokes[k + 1..loads.get(i + 1).copied().unwrap_or(strokes.len())];
        let out = after.iter().find(|s| !s.is_inwards());
        let through = after.iter().find(|s| !s.is_inwards() && s.to_m <= 0.0);
        Cycle {
            times: CycleTimes {
                number: i + 1,
                start_s: if i == 0 { m.time_s.first().copied().unwrap_or(0.0) } else { load.start_s },
                ramp_start_s: surface_time(m, load).unwrap_or(load.start_s),
                ramp_end_s: load.end_s,
                hold_end_s: out.map_or(end_s, |s| s.start_s),
                surface_s: through.map(|s| surface_time(m, s).unwrap_or(s.end_s)),
                withdrawn_s: through.map(|s| s.end_s),
                end_s,
            },
            depth_m: load.to_m,
            ramp: load.line,
            unload: out.map(|s| s.line),
            // A sample of noisy displacement at a kink cannot be told to lie before or after it.
            kink_tolerance_s: 3.0 * motion.noise_m.max(1e-5 * load.to_m) / load.line.rate_m_per_s.abs(),
        }
    };
    loads.iter().enumerate().map(cycle).collect()
}

/// When a stroke passes the undeformed surface, between the last sample on its first side and the next.
fn surface_time(m: &Measurement, stroke: &Stroke) -> Option<f64> {
    let (t, d) = (&m.time_s, &m.displacement_m);
    let on_first_side = |i: &usize| if stroke.is_inwards() { d[*i] <= 0.0 } else { d[*i] > 0.0 };
    let i = (stroke.first..stroke.last).rev().find(on_first_side)?;
    // The stroke may begin between two samples: a rest at the surface is left only then.
    let crossing = t[i] - d[i] * (t[i + 1] - t[i]) / (d[i + 1] - d[i]);
    Some(crossing.max(stroke.start_s).clamp(t[i], t[i + 1]))
}

/// A displacement that changes from one sample to the next far faster than in any stroke is not a motion.
fn check_jumps(m: &Measurement, motion: &Motion) -> Result<(), DataError> {
    const TIMES_FASTEST: f64 = 20.0;
    const FEWEST_SAMPLES: usize = 4;
    let sampled = motion.strokes.iter().filter(|s| s.line.samples >= FEWEST_SAMPLES);
    let fastest = sampled.map(|s| s.line.rate_m_per_s.abs()).fold(0.0, f64::max);
    let depth = m.depth_m();
    let jump = (1..m.len()).find(|&i| {
        let step = (m.displacement_m[i] - m.displacement_m[i - 1]).abs();
        let speed = step / (m.time_s[i] - m.time_s[i - 1]);
        fastest > 0.0 && step > (0.05 * depth).max(20.0 * motion.noise_m) && speed > TIMES_FASTEST * fastest
    });
    match jump {
        None => Ok(()),
        Some(i) => Err(DataError {
            line: m.lines.get(i).copied(),
            column: Some("displacement".into()),
            ..m.error(Problem::DisplacementJumps {
                from_mm: m.displacement_m[i - 1] * 1e3,
                to_mm: m.displacement_m[i] * 1e3,
                within_s: m.time_s[i] - m.time_s[i - 1],
            })
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;

    /// Three cycles: 1 mm at 1 mm/s, 10 s of hold, out to -1 mm, 5 s of rest; every 20 ms.
    fn test(noise_m: f64, seed: u64) -> Measurement {
        let mut random = Random::new(seed);
        let corners = [(0.0, -1e-4), (1.1, 1e-3), (11.1, 1e-3), (13.1, -1e-3), (18.1, -1e-3), (19.0, -1e-4)];
        let at = |t: f64| {
            let t = t % 24.0;
            let k = corners.partition_point(|c| c.0 < t).max(1);
            let (a, b) = (corners[k - 1], corners.get(k).copied().unwrap_or((24.0, -1e-4)));
            a.1 + (b.1 - a.1) * (t - a.0) / (b.0 - a.0)
        };
        let time_s: Vec<f64> = (0..3600).map(|i| 0.02 * f64::from(i)).collect();
        let displacement_m = time_s.iter().map(|&t| at(t) + noise_m * random.normal()).collect();
        Measurement { time_s, displacement_m, lines: (2..3602).collect(), ..Measurement::default() }
    }

    #[test]
    fn cycles_have_their_times_in_noise() {
        for seed in 0..5 {
            let m = test(1e-6, seed);
            let found = cycles(&m).unwrap();
            assert_eq!(found.len(), 3);
            for (i, c) in found.iter().enumerate() {
                let begin = 24.0 * i as f64;
                for (got, expected, within) in [
                    // Between two samples in noise: the surface is passed to within one of them.
                    (c.times.ramp_start_s, 0.1, 0.021),
                    (c.times.ramp_end_s, 1.1, 4e-3),
                    (c.times.hold_end_s, 11.1, 4e-3),
                    (c.times.surface_s.unwrap(), 12.1, 0.021),
                    (c.times.withdrawn_s.unwrap(), 13.1, 4e-3),
                ] {
                    assert!((got - begin - expected).abs() < within, "{got} {expected} in {c:?}");
                }
                assert!((c.depth_m - 1e-3).abs() < 1e-6 && (c.ramp.rate_m_per_s - 1e-3).abs() < 5e-6);
            }
        }
    }

    #[test]
    fn recovery_ends_where_the_next_approach_begins() {
        let m = test(0.0, 0);
        let phases = super::super::phase::phases(&m);
        let at = |t: f64| phases[(t / 0.02).round() as usize];
        assert_eq!(
            [at(0.06), at(0.5), at(11.6), at(12.5)],
            [Phase::Approach, Phase::Ramp, Phase::Unload, Phase::Recovery]
        );
        assert_eq!([at(23.0), at(24.06), at(24.5)], [Phase::Recovery, Phase::Approach, Phase::Ramp]);
    }

    #[test]
    fn a_jump_is_named_with_its_line() {
        let mut m = test(1e-6, 1);
        m.displacement_m[1000] = 2e-3;
        let error = cycles(&m).unwrap_err();
        assert_eq!((error.line, error.column.as_deref()), (Some(1002), Some("displacement")));
        assert!(matches!(error.problem, Problem::DisplacementJumps { .. }), "{error}");
    }

    #[test]
    fn steps_without_unloading_are_cycles() {
        let d = |i: usize| 1e-3 * [0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 1.0, -1.0, -1.0][i];
        let displacement_m = (0..11).map(d).collect();
        let m = Measurement {
            time_s: (0..11).map(f64::from).collect(),
            displacement_m,
            ..Measurement::default()
        };
        let found = cycles(&m).unwrap();
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].times.hold_end_s, found[0].times.surface_s), (4.0, None));
        assert_eq!(
            (found[1].times.ramp_end_s, found[1].times.hold_end_s, found[1].depth_m),
            (5.0, 7.0, 2e-3)
        );
        let resting = Measurement { displacement_m: vec![1e-3; 11], ..m };
        assert_eq!(cycles(&resting).unwrap_err().problem, Problem::NoRamp);
    }
}
