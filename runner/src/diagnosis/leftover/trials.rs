//! The descriptions that are tried.

use super::Course;
use crate::data::cycle::Cycle;
use crate::data::measurement::{interpolated, median};
use crate::inference::fit::Fit;
use crate::noise::Observation;
use std::f64::consts::TAU;

/// A force below this part of the peak is no contact.
const NO_FORCE: f64 = 1e-3;
/// Largest number of places where a step is tried: as many as there are points, up to this.
const STEPS: usize = 400;
/// Largest number of periods that are tried.
const PERIODS: usize = 1000;
/// Number of periods of a ringing that are tried.
const RINGING: usize = 60;
/// Relative rates of the force's clock: a shift as long as a sample's step has another shape at the ramp's end than a shorter one.
const CLOCK_RATES: [f64; 8] = [-0.04, -0.02, -0.01, -0.005, 0.005, 0.01, 0.02, 0.04];
/// Parts of the largest depth within which a gap fades that is there at first touch.
const FADING: [f64; 5] = [1.0 / 32.0, 1.0 / 16.0, 0.125, 0.25, 0.5];
/// Parts of the peak above which a gap goes with the force; 0: with all of it.
const ABOVE: [f64; 4] = [0.0, 0.5, 0.75, 0.9];
/// Parts of a test's length in which a course of the clock comes to rest; the last one goes on.
const SETTLING: [f64; 5] = [1.0 / 32.0, 0.125, 0.5, 2.0, 1e3];

/// Some shapes over a test's points.
pub(super) type Shapes = dyn Fn(&Part<'_>) -> Vec<Vec<f64>>;

/// One description that is tried: shapes over a test's points, each of a free size in each test.
pub(super) struct Trial {
    pub course: Course,
    pub shapes: Box<Shapes>,
    /// How many descriptions of this kind are tried.
    pub kind: usize,
}

/// A test with the force that the fit computes.
pub(super) struct Part<'a> {
    observation: &'a Observation,
    /// Since the test began (s).
    time_s: Vec<f64>,
    depth_mm: Vec<f64>,
    force_mn: Vec<f64>,
    peak_mn: f64,
}

/// All tests.
pub(super) fn parts<'a>(observations: &'a [Observation], fit: &Fit) -> Vec<Part<'a>> {
    let mut before = 0;
    let part = |observation: &'a Observation| {
        let gap_mn = fit.gap_mn.rows(before, observation.len());
        before += observation.len();
        let force_mn: Vec<f64> =
            observation.force_mn().iter().zip(gap_mn.iter()).map(|(measured, gap)| measured - gap).collect();
        let start = observation.time_s.first().copied().unwrap_or(0.0);
        Part {
            observation,
            time_s: observation.time_s.iter().map(|t| t - start).collect(),
            depth_mm: observation.measurement.displacement_m.iter().map(|u| u.max(0.0) * 1e3).collect(),
            peak_mn: force_mn.iter().copied().fold(0.0, f64::max),
            force_mn,
        }
    };
    observations.iter().map(part).collect()
}

/// All descriptions.
pub(super) fn trials(parts: &[Part<'_>]) -> Vec<Trial> {
    let mut trials = vec![
        trial(Course::Depth, 1, |p| p.depth_mm.clone()),
        trial(Course::Rate, 1, |p| p.rate()),
        trial(Course::Contact, 1, |p| p.each(|i| f64::from(u8::from(p.is_in_contact(i))))),
    ];
    trials.extend(
        CLOCK_RATES.map(|rate| trial(Course::ClockRate, CLOCK_RATES.len(), move |p| p.faster_by(rate))),
    );
    trials.extend(SETTLING.map(|part| {
        let settling = move |p: &Part<'_>| p.each(|i| -(-p.time_s[i] / (part * p.length_s())).exp_m1());
        trial(Course::Clock, SETTLING.len(), settling)
    }));
    trials.extend(ABOVE.map(|part| {
        trial(Course::Force, ABOVE.len(), move |p| p.each(|i| (p.force_mn[i] - part * p.peak_mn).max(0.0)))
    }));
    trials.extend(FADING.map(|part| {
        let fading = move |p: &Part<'_>| {
            let deepest = p.depth_mm.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
            p.each(|i| p.force_mn[i] * (-p.depth_mm[i] / (part * deepest)).exp())
        };
        trial(Course::Touch, FADING.len(), fading)
    }));
    trials.extend(steps(parts));
    trials.extend(periods(parts));
    trials.extend(ringing(parts));
    trials
}

fn trial(course: Course, kind: usize, shape: impl Fn(&Part<'_>) -> Vec<f64> + 'static) -> Trial {
    Trial { course, kind, shapes: Box::new(move |p| vec![shape(p)]) }
}

/// From each time on: one shift of the force, or one that relaxes as the force does after its ramp, as a shift of the depth would.
fn steps(parts: &[Part<'_>]) -> Vec<Trial> {
    let Some(finest) = parts.iter().max_by_key(|p| p.time_s.len()) else { return vec![] };
    let every = finest.time_s.len().div_ceil(STEPS);
    let places: Vec<f64> =
        finest.time_s.windows(2).step_by(every).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let start = finest.observation.time_s.first().copied().unwrap_or(0.0);
    let kind = 2 * places.len();
    let both = |&from: &f64| {
        let course = Course::Step { from_s: start + from };
        let shifted = move |p: &Part<'_>| p.each(|i| f64::from(u8::from(p.time_s[i] >= from)));
        let relaxing = move |p: &Part<'_>| {
            p.each(|i| if p.time_s[i] >= from { p.relaxed(p.time_s[i] - from) } else { 0.0 })
        };
        [trial(course, kind, shifted), trial(course, kind, relaxing)]
    };
    places.iter().flat_map(both).collect()
}

/// A sine and a cosine of each frequency, a quarter of a turn in the longest test apart, of periods up to twice its length.
fn periods(parts: &[Part<'_>]) -> Vec<Trial> {
    let shortest = parts.iter().map(|p| 4.0 * median_step(&p.time_s)).fold(f64::INFINITY, f64::min);
    let length_s = parts.iter().map(Part::length_s).fold(0.0, f64::max);
    let most = (4.0 * length_s / shortest) as usize;
    let every = most.div_ceil(PERIODS).max(1);
    let kind = (most / every).max(1);
    let waves = move |quarters: usize| {
        let period_s = 4.0 * length_s / quarters as f64;
        let shapes = move |p: &Part<'_>| {
            let turned = |of: fn(f64) -> f64| p.each(|i| of(TAU * p.time_s[i] / period_s));
            vec![turned(f64::sin), turned(f64::cos)]
        };
        Trial { course: Course::Period { period_s }, kind, shapes: Box::new(shapes) }
    };
    (2..=most).step_by(every).map(waves).collect()
}

/// A sine and a cosine of each period after every ramp's end, falling by half within a period.
fn ringing(parts: &[Part<'_>]) -> Vec<Trial> {
    let cycles = || parts.iter().flat_map(|p| p.observation.cycles.iter().map(move |c| (p, c)));
    let first_step = |(p, c): (&Part<'_>, &Cycle)| {
        let time_s = &p.observation.time_s;
        let after = time_s.partition_point(|t| *t <= c.times.ramp_end_s);
        time_s.get(after..=after + 1).map(|pair| pair[1] - pair[0])
    };
    let shortest = 4.0 * cycles().filter_map(first_step).fold(f64::INFINITY, f64::min);
    let longest = 0.25 * cycles().map(|(_, c)| c.hold_s()).fold(0.0, f64::max);
    let rings = move |period_s: f64| {
        let shapes = move |p: &Part<'_>| {
            let swung = |of: fn(f64) -> f64| {
                p.each(|i| match p.since_ramp(i) / period_s {
                    turns if turns.is_finite() => (-turns).exp2() * of(TAU * turns),
                    _ => 0.0,
                })
            };
            vec![swung(f64::sin), swung(f64::cos)]
        };
        Trial { course: Course::Ringing { period_s }, kind: RINGING, shapes: Box::new(shapes) }
    };
    between(shortest, longest).map(rings).collect()
}

impl Part<'_> {
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether the computed force is one of contact: pressure, or what adhesion pulls.
    pub fn is_in_contact(&self, point: usize) -> bool {
        self.force_mn[point].abs() > NO_FORCE * self.peak_mn
    }

    fn length_s(&self) -> f64 {
        self.time_s.last().copied().unwrap_or(0.0)
    }

    fn each(&self, at: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.time_s.len()).map(at).collect()
    }

    /// The computed force (mN) so long after the test began; between points on a line.
    fn force_at(&self, since_start_s: f64) -> f64 {
        interpolated(&self.time_s, &self.force_mn, since_start_s).unwrap_or(0.0)
    }

    /// Change of the force by a clock of it that runs faster by this part.
    fn faster_by(&self, rate: f64) -> Vec<f64> {
        self.each(|i| self.force_at(self.time_s[i] * (1.0 + rate)) - self.force_mn[i])
    }

    /// The force so long after the end of the first ramp; 0 where there is none.
    fn relaxed(&self, since_s: f64) -> f64 {
        let Some(first) = self.observation.cycles.first() else { return 0.0 };
        let end_s = first.times.ramp_end_s - self.observation.time_s[0];
        self.force_at(end_s + since_s.min(first.hold_s()))
    }

    fn rate(&self) -> Vec<f64> {
        let (t, u) = (&self.time_s, &self.depth_mm);
        self.each(|i| if i == 0 { 0.0 } else { (u[i] - u[i - 1]) / (t[i] - t[i - 1]) })
    }

    /// Time since the last end of a ramp (s); infinite before the first.
    fn since_ramp(&self, point: usize) -> f64 {
        let t = self.observation.time_s[point];
        let since = self.observation.cycles.iter().map(|c| t - c.times.ramp_end_s).filter(|s| *s >= 0.0);
        since.fold(f64::INFINITY, f64::min)
    }
}

/// The periods of a ringing; none where the data have no room for them.
fn between(shortest: f64, longest: f64) -> impl Iterator<Item = f64> {
    let count = if shortest > 0.0 && shortest < longest { RINGING } else { 0 };
    (0..count).map(move |k| shortest * (longest / shortest).powf(k as f64 / (RINGING - 1) as f64))
}

/// Infinite where there is no step.
fn median_step(time_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
    if steps.is_empty() { f64::INFINITY } else { median(&mut steps) }
}
