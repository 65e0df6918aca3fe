//! What an `fmi2Component` points at.

use crate::logger::Logger;
use crate::phase::Phase;
use poropunch::cosimulation::{Slave, SlaveState};
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
    /// What the last `fmi2GetString` pointed at: it must live until the next call.
    pub texts: Vec<CString>,
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
        }
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
