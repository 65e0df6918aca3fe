//! Steps of a slave: whole ones, and to the first event or step of the integrator inside them.

use super::{Run, Slave, SlaveError, TIME_SLACK};
use crate::interface::recording::Recorder;
use crate::motion::protocol::Protocol;
use crate::motion::{Reached, Stops};
use crate::{Instance, StepError};

/// What is left of a communication step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leg {
    /// Where it begins (s).
    current: f64,
    /// How long it is (s).
    size: f64,
    /// Where it ends (s).
    end: f64,
    /// Where the punch is to be at its end (m).
    target: f64,
}

/// How far a leg was gone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Where the slave is now (s).
    pub time: f64,
    /// Whether that is the end of the leg.
    pub is_end: bool,
    /// What is there.
    pub reached: Reached,
}

impl Leg {
    /// Where it ends (s).
    pub fn end(&self) -> f64 {
        self.end
    }
}

impl Slave {
    /// From the communication point `current` over a step of `size` (s).
    ///
    /// # Errors
    /// When the slave is elsewhere, the size is not positive, or the model cannot make the step; nothing
    /// has changed then.
    pub fn step(&mut self, current: f64, size: f64) -> Result<(), SlaveError> {
        let mut leg = self.leg(current, size)?;
        self.go(&mut leg, Stops::default()).map(|_| ())
    }

    /// The same step, still to be gone: the inputs are those at its beginning.
    ///
    /// # Errors
    /// When the slave is elsewhere or the size is not positive.
    pub fn leg(&self, current: f64, size: f64) -> Result<Leg, SlaveError> {
        let run = self.run.as_ref().ok_or(SlaveError::NotInitialised)?;
        if !(size > 0.0 && size.is_finite()) {
            return Err(StepError::BadDuration(size).into());
        }
        let slack = TIME_SLACK * run.time.abs().max(1.0);
        if current.is_nan() || (current - run.time).abs() > slack {
            return Err(SlaveError::WrongTime { asked: current, actual: run.time });
        }
        let target = match &run.protocol {
            None => {
                let rate = self.derivative.unwrap_or(self.settings.displacement_rate);
                self.settings.displacement + rate * size
            }
            Some(protocol) => protocol.displacement(current - run.start_time + size),
        };
        Ok(Leg { current, size, end: current + size, target })
    }

    /// Whether the inputs move the punch.
    pub fn follows_inputs(&self) -> bool {
        self.run.as_ref().is_some_and(|run| run.protocol.is_none())
    }

    /// The inputs are now those at the end of the leg.
    pub fn aim(&self, leg: &mut Leg) {
        if self.follows_inputs() {
            leg.target = self.settings.displacement;
        }
    }

    /// Goes to the end of a leg, or to the first of what `stops` names; the leg is then what is left of it.
    ///
    /// # Errors
    /// When the model cannot make the step; nothing has changed then.
    pub fn go(&mut self, leg: &mut Leg, stops: Stops) -> Result<Progress, SlaveError> {
        let run = self.run.as_mut().ok_or(SlaveError::NotInitialised)?;
        let (part, reached) = match run.recorder.take() {
            None => run.go(leg, stops)?,
            Some(mut recorder) => {
                let made = run.go_recorded(&mut recorder, leg, stops);
                run.recorder = Some(recorder);
                made?
            }
        };
        let time = part.map_or(leg.end, |duration| leg.current + duration);
        run.time = time;
        (leg.current, leg.size) = (time, leg.end - time);
        if part.is_none() {
            self.derivative = None;
        }
        Ok(Progress { time, is_end: part.is_none(), reached })
    }

    /// When the built-in motion changes its velocity next (s).
    pub fn next_corner(&self) -> Option<f64> {
        let run = self.run.as_ref()?;
        let now = run.time - run.start_time;
        let slack = TIME_SLACK * now.abs().max(1.0);
        let corners = run.protocol.as_ref()?.breakpoints_between(now + slack, f64::INFINITY);
        corners.first().map(|(time, _)| run.start_time + time)
    }
}

/// Time gone (s) where a leg was not gone to its end, and what is there.
type Part = (Option<f64>, Reached);

impl Run {
    /// Along the protocol, or straight to the target.
    fn go(&mut self, leg: &Leg, stops: Stops) -> Result<Part, StepError> {
        if let Some(protocol) = &self.protocol {
            let from = leg.current - self.start_time;
            return follow(&mut self.instance, protocol, from, from + leg.size, stops);
        }
        self.instance.set_displacement(leg.target);
        let (made, reached) = self.instance.advance_until(leg.size, stops)?;
        Ok(((made < leg.size).then_some(made), reached))
    }

    /// The same with the frames that are due at its ends; without them the step is not made.
    fn go_recorded(&mut self, recorder: &mut Recorder, leg: &Leg, stops: Stops) -> Result<Part, SlaveError> {
        let velocity = (leg.target - self.instance.outputs().displacement) / leg.size;
        let pace = recorder.before_step(&mut self.instance, self.time, velocity)?;
        let state = self.instance.save();
        let moved = self.go(leg, stops).map_err(SlaveError::from);
        let recorded = moved.and_then(|part| {
            let end = part.0.map_or(leg.end, |duration| leg.current + duration);
            recorder.after_step(&mut self.instance, end)?;
            Ok(part)
        });
        recorded.inspect_err(|_| {
            recorder.undo(&pace);
            // Cannot fail: the state was saved by this very instance.
            let _ = self.instance.restore(&state);
        })
    }
}

/// Follows the protocol from one time to another, honouring the breakpoints between.
fn follow(
    instance: &mut Instance,
    protocol: &Protocol,
    from: f64,
    to: f64,
    stops: Stops,
) -> Result<Part, StepError> {
    // A breakpoint this close to an end of the step belongs to it, however long the step is.
    let slack = TIME_SLACK * (to - from).min(1.0);
    let inside = protocol.breakpoints_between(from + slack, to - slack);
    let before = (!inside.is_empty()).then(|| instance.save());
    let (mut time, mut last) = (from, Reached::End);
    for (end, displacement) in inside.iter().copied().chain([(to, protocol.displacement(to))]) {
        instance.set_displacement(displacement);
        let advanced = instance.advance_until(end - time, stops);
        let (made, reached) = advanced.inspect_err(|_| {
            if let Some(before) = &before {
                // Cannot fail: the state was saved by this very instance.
                let _ = instance.restore(before);
            }
        })?;
        if made < end - time {
            return Ok((Some(time + made - from), reached));
        }
        if end < to && (stops.events || stops.steps) {
            return Ok((Some(end - from), Reached::Corner));
        }
        (time, last) = (end, reached);
    }
    let is_corner = !protocol.breakpoints_between(to - slack, to + slack).is_empty();
    Ok((None, if is_corner { Reached::Corner } else { last }))
}
