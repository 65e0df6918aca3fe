//! The way through a test: steps of the size that the wanted accuracy allows.

use crate::error::{Failure, MakerError};
use crate::history::History;
use crate::motion::Motion;
use crate::step::{Frame, Newton, Solved};
use crate::system::{Memory, Step, System, Unknowns};
use crate::time::Formula;

/// How steps are chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace {
    /// Error of a step in the force, over the greatest force so far.
    pub tolerance: f64,
    /// First travel after a kink of the motion, over the punch's radius.
    pub first_travel: f64,
    /// First step after a kink over the shortest relaxation time.
    pub first_time: f64,
    /// Share of backward Euler in the formula, the rest is BDF2's.
    pub first_order: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Self { tolerance: 5e-4, first_travel: 5e-4, first_time: 0.02, first_order: 0.0 }
    }
}

/// Growth of neighbouring steps; BDF2 is stable up to 2.4.
const GROWTH: f64 = 1.8;
/// Error of BDF2 over the distance from the parabola through the three last points, for steps that grow a little.
const ERROR_SHARE: f64 = 0.25;
/// Largest travel of a step over the punch's radius.
const TRAVEL: f64 = 0.06;
/// The same for a step in which contact begins or ends.
const KINK_TRAVEL: f64 = 0.003;
/// Steps, taken or not, after which a test is given up: a limit of work that is the same on every machine. Three cycles need 900.
const MOST_ATTEMPTS: usize = 3_000;
/// Steps of one piece of the motion that failed, after which a test is given up: where equilibrium comes and goes. Ten are common.
const MOST_FAILURES: usize = 40;

/// A test in progress.
pub struct Drive<'a> {
    system: &'a System,
    frame: Option<Frame>,
    pace: Pace,
    shortest_time: f64,
    stiffening: &'a dyn Fn(f64) -> f64,
    newton: Newton,
    x: Unknowns,
    last: Memory,
    before: Memory,
    spare: Memory,
    depth: f64,
    force: f64,
    greatest: f64,
    attempts: usize,
    history: History,
}

/// End of a step of the present piece.
struct Mark {
    time: f64,
    force: f64,
    depth: f64,
    surface: f64,
    x: Unknowns,
}

impl<'a> Drive<'a> {
    /// A specimen at rest; `stiffening` is the factor on all moduli by time (s).
    pub fn new(
        system: &'a System,
        frame: Option<Frame>,
        pace: Pace,
        shortest_time: f64,
        stiffening: &'a dyn Fn(f64) -> f64,
    ) -> Self {
        let (x, last) = system.rest();
        let (newton, history) = (Newton::default(), History::default());
        let (before, spare) = (last.clone(), last.clone());
        let greatest = system.force_unit() * 0.01;
        Self {
            system,
            frame,
            pace,
            shortest_time,
            stiffening,
            newton,
            x,
            last,
            before,
            spare,
            depth: 0.0,
            force: 0.0,
            greatest,
            attempts: 0,
            history,
        }
    }

    /// Follows the motion from first touch to its end.
    ///
    /// # Errors
    /// When a step cannot be solved.
    pub fn run(mut self, motion: &Motion) -> Result<History, MakerError> {
        let mut points = motion.points().to_vec();
        if points[0].1 > 0.0 {
            // A test that begins below the surface was lowered there before.
            points.insert(0, (points[0].0 - points[0].1 / (0.5 * self.system.punch_radius), 0.0));
        }
        let motion = &Motion::new(points.clone())?;
        self.history.push(points[0].0, 0.0);
        let mut touched = false;
        for pair in points.windows(2) {
            let ((mut from, start), (to, end)) = (pair[0], pair[1]);
            if !touched && end <= 0.0 {
                continue;
            }
            if !touched && start < 0.0 {
                from += (to - from) * -start / (end - start);
                self.history.push(from, 0.0);
                self.history.kink();
            }
            touched = true;
            self.piece(motion, from, to)?;
            self.history.kink();
        }
        Ok(self.history)
    }

    /// One straight piece of the motion.
    fn piece(&mut self, motion: &Motion, from: f64, to: f64) -> Result<(), MakerError> {
        let radius = self.system.punch_radius;
        let speed = ((motion.at(to) - motion.at(from)) / (to - from)).abs() / radius;
        let longest = if speed > 0.0 { TRAVEL / speed } else { f64::INFINITY };
        let first = if speed > 0.0 { self.pace.first_travel / speed } else { f64::INFINITY };
        let mut step = first.min(self.pace.first_time * self.shortest_time).min(to - from);
        let smallest = 1e-7 * step;
        let mut marks = vec![self.mark(from)];
        let mut failures = 0;
        while let Some(now) = marks.last()
            && to - now.time > 1e-9 * (to - from)
        {
            let time = now.time;
            step = step.min(longest);
            let left = to - time;
            // The last two steps share what is left.
            step = if step >= left { left } else { step.min(0.5 * left).max(smallest) };
            self.attempts += 1;
            if self.attempts > MOST_ATTEMPTS {
                return Err(MakerError::TooManySteps(MOST_ATTEMPTS));
            }
            match self.attempt(motion, &marks, time + step) {
                Ok((mark, solved, error)) => {
                    std::mem::swap(&mut self.before, &mut self.last);
                    std::mem::swap(&mut self.last, &mut self.spare);
                    (self.depth, self.force) = (solved.depth, solved.force);
                    self.x.clone_from(&mark.x);
                    self.history.push(mark.time, solved.force);
                    self.greatest = self.greatest.max(solved.force.abs());
                    marks.push(mark);
                    if marks.len() > 3 {
                        marks.remove(0);
                    }
                    step *= error.map_or(GROWTH, |e| (0.8 * e.max(1e-9).powf(-1.0 / 3.0)).clamp(0.3, GROWTH));
                }
                Err((reason, next)) => {
                    step *= next;
                    failures += usize::from(reason != Failure::TimeError);
                    if step < smallest || failures > MOST_FAILURES {
                        return Err(MakerError::NoConvergence { time_s: time, step_s: step, reason });
                    }
                }
            }
        }
        Ok(())
    }

    fn mark(&self, time: f64) -> Mark {
        Mark {
            time,
            force: self.force,
            depth: self.depth,
            surface: self.system.surface(&self.x),
            x: self.x.clone(),
        }
    }

    /// Tries a step; its error over the tolerance if it can be told, or how much smaller the next try should be.
    fn attempt(
        &mut self,
        motion: &Motion,
        marks: &[Mark],
        time: f64,
    ) -> Result<(Mark, Solved, Option<f64>), (Failure, f64)> {
        let now = &marks[marks.len() - 1];
        let step = time - now.time;
        let earlier = marks.len().checked_sub(2).map(|i| &marks[i]);
        let formula = match earlier {
            Some(earlier) => {
                Formula::second_order(step, now.time - earlier.time).with_first_order(self.pace.first_order)
            }
            None => Formula::first_order(step),
        };
        let mut x = now.x.clone();
        let mut guess = now.depth;
        let weights = extrapolation(marks, time);
        if marks.len() > 1 {
            x.iter_mut()
                .enumerate()
                .for_each(|(i, x)| *x = marks.iter().zip(&weights).map(|(m, w)| w * m.x[i]).sum());
            guess = marks.iter().zip(&weights).map(|(m, w)| w * m.depth).sum();
        }
        let equations =
            Step { formula, last: &self.last, before: &self.before, stiffening: (self.stiffening)(time) };
        let solved = self
            .newton
            .solve(
                self.system,
                self.frame.as_ref(),
                motion.at(time),
                guess,
                &mut x,
                &equations,
                &mut self.spare,
            )
            .map_err(|reason| (reason, 0.4))?;
        // Where contact begins or ends the force has a kink: a step over it is short.
        let touches = |m: &Memory| m.touches.iter().any(|t| t.closed);
        let travel = (motion.at(time) - motion.at(now.time)).abs();
        if touches(&self.last) != touches(&self.spare) && travel > KINK_TRAVEL * self.system.punch_radius {
            return Err((Failure::TimeError, 0.3));
        }
        let surface = self.system.surface(&x);
        let mark = Mark { time, force: solved.force, depth: solved.depth, surface, x };
        let error = (marks.len() == 3).then(|| {
            let guess =
                |value: fn(&Mark) -> f64| marks.iter().zip(&weights).map(|(m, w)| w * value(m)).sum::<f64>();
            let miss = |value: fn(&Mark) -> f64| value(&mark) - guess(value);
            let force = miss(|m| m.force) / self.greatest.max(solved.force.abs());
            let surface = miss(|m| m.surface) / (0.5 * self.system.punch_radius);
            ERROR_SHARE * force.abs().max(surface.abs()) / self.pace.tolerance
        });
        match error {
            Some(e) if e > 2.0 => Err((Failure::TimeError, (0.8 * e.powf(-1.0 / 3.0)).clamp(0.15, 0.7))),
            _ => Ok((mark, solved, error)),
        }
    }
}

/// Lagrange's weights of the marks for a time.
fn extrapolation(marks: &[Mark], time: f64) -> [f64; 3] {
    let mut weights = [1.0; 3];
    for (i, a) in marks.iter().enumerate() {
        for b in marks.iter().filter(|b| b.time != a.time) {
            weights[i] *= (time - b.time) / (a.time - b.time);
        }
    }
    weights
}
