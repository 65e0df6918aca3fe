//! How many runs were under way, on average.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Integrates the number of runs under way over time.
#[derive(Debug)]
pub struct Load {
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    running: usize,
    run_seconds: f64,
    since: Instant,
}

/// A run under way; counts until it is dropped.
#[derive(Debug)]
pub struct Running<'a>(&'a Load);

impl Default for Load {
    fn default() -> Self {
        Self { state: Mutex::new(State { running: 0, run_seconds: 0.0, since: Instant::now() }) }
    }
}

impl Load {
    /// Counts one more run.
    pub fn begin(&self) -> Running<'_> {
        self.change(|running| running + 1);
        Running(self)
    }

    /// Time integral of the number of runs under way since the start [s].
    pub fn run_seconds(&self) -> f64 {
        self.change(|running| running)
    }

    fn change(&self, running: impl FnOnce(usize) -> usize) -> f64 {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        state.run_seconds += state.running as f64 * now.duration_since(state.since).as_secs_f64();
        state.since = now;
        state.running = running(state.running);
        state.run_seconds
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        self.0.change(|running| running - 1);
    }
}
