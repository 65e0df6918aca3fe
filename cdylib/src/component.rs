//! What an `fmi2Component` or `fmi3Instance` points at.

use crate::fmi3::Modes;
use crate::guard::Outcome;
use crate::logger::Logger;
use crate::phase::Phase;
use poropunch::cosimulation::{Slave, SlaveState, TIME_SLACK};
use std::collections::BTreeMap;
use std::ffi::CString;
use std::sync::atomic::{AtomicUsize, Ordering};

/// One instance with its life cycle.
pub struct Component {
    /// The model.
    pub slave: Slave,
    /// Life cycle.
    pub phase: Phase,
    /// Experiment set by the master: start time and, where defined, stop time (s).
    pub experiment: (f64, Option<f64>),
    /// End of the last successful step (s).
    pub last_time: f64,
    /// Messages.
    pub logger: Logger,
    /// Saved states by handle: only what is in here can be restored or freed.
    pub states: BTreeMap<usize, Saved>,
    /// What the last GetString pointed at: it must live until the next call.
    pub texts: Vec<CString>,
    /// What the master of FMI 3.0 wants; none for FMI 2.0.
    pub modes: Option<Modes>,
}

/// A saved state with its place in the life cycle.
#[derive(Clone)]
pub struct Saved {
    /// State of the model.
    pub slave: SlaveState,
    /// Life cycle.
    pub phase: Phase,
    /// Experiment.
    pub experiment: (f64, Option<f64>),
    /// End of the last successful step (s).
    pub last_time: f64,
}

impl Component {
    /// A fresh instance.
    pub fn new(logger: Logger) -> Self {
        Self {
            slave: Slave::new(),
            phase: Phase::Instantiated,
            experiment: (0.0, None),
            last_time: 0.0,
            logger,
            states: BTreeMap::new(),
            texts: Vec::new(),
            modes: None,
        }
    }

    /// Start and stop time (s). The tolerance is not used, as is logged: `solver.tolerance` is a parameter.
    pub fn set_experiment(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Outcome {
        if !start.is_finite() || stop.is_some_and(|stop| stop.is_nan() || stop < start) {
            return Err(format!("start time {start} s and stop time {stop:?} s are no interval"));
        }
        if let Some(tolerance) = tolerance {
            self.logger.event(|| {
                format!(
                    "the tolerance {tolerance} of the experiment is not used: solver.tolerance is a parameter"
                )
            });
        }
        self.experiment = (start, stop);
        Ok(())
    }

    /// Parameters and inputs may still be set until the end of the initialisation.
    pub fn begin_initialisation(&mut self) -> Outcome {
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// Builds the model.
    pub fn initialise(&mut self) -> Outcome {
        // Left so by a failure or a panic.
        self.phase = Phase::Error;
        self.slave.initialise(self.experiment.0).map_err(|e| e.to_string())?;
        self.last_time = self.experiment.0;
        let has_events = self.modes.as_ref().is_some_and(|modes| modes.events);
        self.phase = if has_events { Phase::Event } else { Phase::StepComplete };
        self.logger.event(|| format!("initialised at {} s", self.experiment.0));
        Ok(())
    }

    /// Refuses a step that ends after the stop time.
    pub fn check_end(&self, end: f64) -> Outcome {
        match self.experiment.1 {
            Some(stop) if end > stop + TIME_SLACK * stop.abs().max(1.0) => {
                Err(format!("the step ends at {end} s, after the stop time {stop} s"))
            }
            _ => Ok(()),
        }
    }

    /// Ends the simulation with the last frame of the fields, where they are written.
    pub fn terminate(&mut self) -> Outcome {
        self.slave.finish().map_err(|e| e.to_string())?;
        self.phase = Phase::Terminated;
        self.logger.event(|| "terminated".to_owned());
        Ok(())
    }

    /// As after instantiation; saved states and logging stay.
    pub fn reset(&mut self) {
        self.slave.reset();
        self.phase = Phase::Instantiated;
        self.experiment = (0.0, None);
        self.last_time = 0.0;
    }

    /// The present state.
    pub fn save(&self) -> Saved {
        Saved {
            slave: self.slave.save(),
            phase: self.phase,
            experiment: self.experiment,
            last_time: self.last_time,
        }
    }

    /// Back to a saved state.
    pub fn restore(&mut self, saved: &Saved) -> Result<(), String> {
        let reachable = match saved.phase {
            Phase::Configuration => self.modes.is_some(),
            Phase::Event => self.modes.as_ref().is_some_and(|modes| modes.events),
            _ => true,
        };
        if !reachable {
            return Err(format!("an instance like this one is never in state {:?}", saved.phase));
        }
        self.slave.restore(&saved.slave).map_err(|e| e.to_string())?;
        self.phase = saved.phase;
        self.experiment = saved.experiment;
        self.last_time = saved.last_time;
        Ok(())
    }

    /// Keeps a state and returns its handle, unique among all components.
    pub fn keep(&mut self, saved: Saved) -> usize {
        static NEXT: AtomicUsize = AtomicUsize::new(1);
        let handle = NEXT.fetch_add(1, Ordering::Relaxed);
        self.states.insert(handle, saved);
        handle
    }
}

impl Saved {
    /// Life cycle, experiment, then the slave's own format.
    pub fn to_bytes(&self) -> Result<Vec<u8>, String> {
        let (start, stop) = self.experiment;
        let mut bytes = vec![self.phase as u8, u8::from(stop.is_some())];
        for number in [start, stop.unwrap_or(0.0), self.last_time] {
            bytes.extend(number.to_le_bytes());
        }
        self.slave.to_bytes(&bytes).map_err(|e| e.to_string())
    }

    /// Reads what [`Saved::to_bytes`] wrote, from bytes that may be anything.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let (slave, prefix) = SlaveState::from_bytes(bytes).map_err(|e| e.to_string())?;
        let number = |i: usize| {
            let at = 2 + 8 * i;
            let field = prefix.get(at..at + 8).and_then(|b| b.try_into().ok());
            field.map(f64::from_le_bytes).ok_or("the saved life cycle is cut short")
        };
        let phases = [
            Phase::Instantiated,
            Phase::Initialization,
            Phase::StepComplete,
            Phase::Error,
            Phase::Terminated,
            Phase::Configuration,
            Phase::Event,
        ];
        let [phase, has_stop, ..] = prefix[..] else { return Err("the saved life cycle is missing".into()) };
        let phase = *phases.get(usize::from(phase)).ok_or("the saved life cycle is unknown")?;
        let stop = if has_stop == 1 { Some(number(1)?) } else { None };
        let (start, last_time) = (number(0)?, number(2)?);
        if !(start.is_finite() && last_time.is_finite()) || stop.is_some_and(f64::is_nan) {
            return Err("the saved times are no numbers".into());
        }
        Ok(Self { slave, phase, experiment: (start, stop), last_time })
    }
}
