//! The descriptions that are tried.

use super::{Course, NO_FORCE};
use crate::data::cycle::Cycle;
use crate::inference::fit::Fit;
use crate::noise::Observation;
use nalgebra::DVector;
use std::f64::consts::TAU;

/// Places of a step, and periods, that are tried in each test.
const STEPS: usize = 40;
const PERIODS: usize = 60;

/// One description that is tried.
pub(super) struct Trial {
    pub course: Course,
    /// Test that it is seen in; none: in all alike.
    pub test: Option<usize>,
    /// In any unit, each of a free size.
    pub shapes: Vec<DVector<f64>>,
    /// How many descriptions of this kind are tried.
    pub kind: usize,
}

/// All of them.
pub(super) fn trials(observations: &[Observation], fit: &Fit) -> Vec<Trial> {
    let mut trials = Vec::new();
    let mut together: Vec<(Course, DVector<f64>)> = Vec::new();
    let mut before = 0;
    for (test, observation) in observations.iter().enumerate() {
        let part = Part { test, tests: observations.len(), observation, before, points: fit.gap_mn.len() };
        let simple = part.simple(fit);
        if test == 0 {
            together.extend(simple.iter().cloned());
        } else {
            together.iter_mut().zip(&simple).for_each(|((_, sum), (_, own))| *sum += own);
        }
        if observations.len() > 1 {
            trials.extend(simple.into_iter().map(|(course, shape)| part.trial(course, vec![shape], 1)));
        }
        trials.extend(part.steps());
        trials.extend(part.periods());
        trials.extend(part.ringing());
        before += observation.len();
    }
    let in_all = |(course, shape)| Trial { course, test: None, shapes: vec![shape], kind: 1 };
    trials.extend(together.into_iter().map(in_all));
    trials
}

/// A test among all of them.
struct Part<'a> {
    test: usize,
    tests: usize,
    observation: &'a Observation,
    /// Points of the tests before it.
    before: usize,
    /// Points of all.
    points: usize,
}

impl Part<'_> {
    /// A shape over this test's points; in the others nothing.
    fn shape(&self, at: impl Fn(usize) -> f64) -> DVector<f64> {
        let mut all = DVector::zeros(self.points);
        (0..self.observation.len()).for_each(|i| all[self.before + i] = at(i));
        all
    }

    fn trial(&self, course: Course, shapes: Vec<DVector<f64>>, in_each_test: usize) -> Trial {
        Trial { course, test: Some(self.test), shapes, kind: in_each_test * self.tests }
    }

    /// Courses without a time of their own.
    fn simple(&self, fit: &Fit) -> [(Course, DVector<f64>); 6] {
        let Self { observation: o, before, .. } = self;
        let (n, t) = (o.len(), &o.time_s);
        let force: Vec<f64> =
            o.force_mn().iter().zip(fit.gap_mn.rows(*before, n).iter()).map(|(m, g)| m - g).collect();
        let peak = force.iter().copied().fold(0.0, f64::max);
        let depth = |i: usize| o.measurement.displacement_m[i].max(0.0) * 1e3;
        let rate = |i: usize| if i == 0 { 0.0 } else { (depth(i) - depth(i - 1)) / (t[i] - t[i - 1]) };
        // Change of the force (mN/s); at the ends to one side.
        let change = |i: usize| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
            (force[b] - force[a]) / (t[b] - t[a])
        };
        [
            (Course::ClockRate, self.shape(|i| (t[i] - t[0]) * change(i))),
            (Course::Clock, self.shape(|i| t[i] - t[0])),
            (Course::Depth, self.shape(depth)),
            (Course::Rate, self.shape(rate)),
            (Course::Force, self.shape(|i| force[i])),
            (Course::Contact, self.shape(|i| f64::from(u8::from(force[i] > NO_FORCE * peak)))),
        ]
    }

    fn steps(&self) -> impl Iterator<Item = Trial> {
        (1..STEPS).map(|k| {
            let first = k * self.observation.len() / STEPS;
            let course = Course::Step { from_s: self.observation.time_s[first] };
            self.trial(course, vec![self.shape(|i| f64::from(u8::from(i >= first)))], STEPS)
        })
    }

    /// A sine and a cosine of each period.
    fn periods(&self) -> impl Iterator<Item = Trial> {
        let t = &self.observation.time_s;
        let (shortest, longest) = (4.0 * median_step(t), 0.5 * (t[t.len() - 1] - t[0]));
        periods(shortest, longest).filter(|p| p.is_finite() && *p > 0.0).map(move |period_s| {
            let angle = |i: usize| TAU * (t[i] - t[0]) / period_s;
            let shapes = vec![self.shape(|i| angle(i).sin()), self.shape(|i| angle(i).cos())];
            self.trial(Course::Period { period_s }, shapes, PERIODS)
        })
    }

    /// A sine and a cosine of each period after every ramp's end, falling by half within a period.
    fn ringing(&self) -> Vec<Trial> {
        let o = self.observation;
        let first = |c: &Cycle| {
            let after = o.time_s.partition_point(|t| *t <= c.times.ramp_end_s);
            o.time_s.get(after..=after + 1).map(|pair| pair[1] - pair[0])
        };
        let shortest = 4.0 * o.cycles.iter().filter_map(first).fold(f64::INFINITY, f64::min);
        let longest = 0.25 * o.cycles.iter().map(Cycle::hold_s).fold(0.0, f64::max);
        if shortest >= longest {
            return vec![];
        }
        let since = |t: f64| {
            let ends = o.cycles.iter().map(|c| t - c.times.ramp_end_s).filter(|since| *since >= 0.0);
            ends.fold(f64::INFINITY, f64::min)
        };
        let shape = |period_s: f64, of: fn(f64) -> f64| {
            self.shape(|i| match since(o.time_s[i]) / period_s {
                turns if turns.is_finite() => (-turns).exp2() * of(TAU * turns),
                _ => 0.0,
            })
        };
        let trial = |period_s| {
            let shapes = vec![shape(period_s, f64::sin), shape(period_s, f64::cos)];
            self.trial(Course::Ringing { period_s }, shapes, PERIODS)
        };
        periods(shortest, longest).map(trial).collect()
    }
}

/// The periods that are tried.
fn periods(shortest: f64, longest: f64) -> impl Iterator<Item = f64> {
    (0..PERIODS).map(move |k| shortest * (longest / shortest).powf(k as f64 / (PERIODS - 1) as f64))
}

fn median_step(time_s: &[f64]) -> f64 {
    crate::data::measurement::median(&mut time_s.windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>())
}
