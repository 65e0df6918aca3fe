//! How many runs were under way, on average, and how many were cancelled.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Integrates the number of runs under way over time.
#[derive(Debug)]
pub struct Load {
    state: Mutex<State>,
    cancelled: AtomicU64,
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
        Self {
            state: Mutex::new(State { running: 0, run_seconds: 0.0, since: Instant::now() }),
            cancelled: AtomicU64::new(0),
        }
    }
}

impl Load {
    /// Counts one more run.
    pub fn begin(&self) -> Running<'_> {
        self.change(|running| running + 1);
        Running(self)
    }

    /// Counts a run that nobody wanted any more.
    pub fn cancel(&self) {
        self.cancelled.fetch_add(1, Ordering::Relaxed);
    }

    /// Number of runs that nobody wanted any more.
    pub fn cancelled(&self) -> u64 {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Time integral of the number of runs under way since the start (s).
    pub fn run_seconds(&self) -> f64 {
        self.change(|running| running)
    }

    /// Number of runs under way.
    pub fn running(&self) -> usize {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).running
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
