//! The handle of a run: waits for it; dropping the last handle cancels it.

use super::job::{Outcome, RunFailure};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError, Weak};

/// A run that was submitted. Clones share the run.
#[derive(Debug)]
pub struct Run {
    slot: Arc<Slot>,
}

/// Where worker and waiters meet.
#[derive(Debug, Default)]
pub(super) struct Slot {
    outcome: Mutex<Option<Outcome>>,
    done: Condvar,
    waiters: AtomicUsize,
}

/// Remembers a run without wanting it.
#[derive(Debug, Clone)]
pub struct WeakRun(Weak<Slot>);

impl Run {
    /// A run that has already ended.
    pub fn ended(outcome: Outcome) -> Self {
        let run = Self::new();
        run.slot.complete(outcome);
        run
    }

    pub(super) fn new() -> Self {
        let slot = Arc::new(Slot::default());
        slot.waiters.store(1, Ordering::SeqCst);
        Self { slot }
    }

    pub(super) fn slot(&self) -> Arc<Slot> {
        Arc::clone(&self.slot)
    }

    /// Waits until the run has ended.
    pub fn wait(&self) -> Outcome {
        let mut outcome = self.slot.lock();
        loop {
            if let Some(outcome) = outcome.as_ref() {
                return outcome.clone();
            }
            outcome = self.slot.done.wait(outcome).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Whether the run has ended.
    pub fn has_ended(&self) -> bool {
        self.slot.lock().is_some()
    }

    /// To find the run again while somebody wants it.
    pub fn downgrade(&self) -> WeakRun {
        WeakRun(Arc::downgrade(&self.slot))
    }
}

impl Clone for Run {
    fn clone(&self) -> Self {
        self.slot.waiters.fetch_add(1, Ordering::SeqCst);
        Self { slot: Arc::clone(&self.slot) }
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        self.slot.waiters.fetch_sub(1, Ordering::SeqCst);
    }
}

impl WeakRun {
    /// The run, if it is still wanted: a run that lost its last handle may have been cancelled already.
    pub fn upgrade(&self) -> Option<Run> {
        let slot = self.0.upgrade()?;
        let join = |n: usize| (n > 0).then_some(n + 1);
        slot.waiters.fetch_update(Ordering::SeqCst, Ordering::SeqCst, join).ok()?;
        Some(Run { slot })
    }
}

impl Slot {
    pub(super) fn is_unwanted(&self) -> bool {
        self.waiters.load(Ordering::SeqCst) == 0
    }

    /// The first outcome counts.
    pub(super) fn complete(&self, outcome: Outcome) {
        self.lock().get_or_insert(outcome);
        self.done.notify_all();
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Option<Outcome>> {
        self.outcome.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The worker's end: whatever happens to the worker, the waiters are answered.
#[derive(Debug)]
pub(super) struct Promise(pub(super) Arc<Slot>);

impl Drop for Promise {
    fn drop(&mut self) {
        self.0.complete(Err(RunFailure::Cancelled));
    }
}
