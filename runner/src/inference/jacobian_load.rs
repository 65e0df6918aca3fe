//! How many runs were under way while Jacobians were formed.

use crate::pool::Pool;
use std::time::Instant;

/// Runs under way, integrated over the time in which Jacobians were formed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JacobianLoad {
    run_seconds: f64,
    seconds: f64,
}

impl JacobianLoad {
    /// Mean number of runs under way; `None` when no Jacobian took measurable time (all from the cache).
    pub fn mean(&self) -> Option<f64> {
        (self.seconds > 0.0 && self.run_seconds > 0.0).then(|| self.run_seconds / self.seconds)
    }

    /// Of two that ran side by side: each saw the runs of both.
    #[must_use]
    pub(super) fn beside(self, other: Self) -> Self {
        if other.seconds > self.seconds { other } else { self }
    }

    pub(super) fn add(&mut self, (run_seconds, seconds): (f64, f64)) {
        self.run_seconds += run_seconds;
        self.seconds += seconds;
    }
}

/// From the submission of a Jacobian's runs to the end of the last.
pub(super) struct Window {
    run_seconds: f64,
    start: Instant,
}

impl Window {
    pub(super) fn open(pool: &Pool) -> Self {
        Self { run_seconds: pool.run_seconds(), start: Instant::now() }
    }

    /// Run-seconds and seconds since it was opened.
    pub(super) fn close(&self, pool: &Pool) -> (f64, f64) {
        (pool.run_seconds() - self.run_seconds, self.start.elapsed().as_secs_f64())
    }
}
