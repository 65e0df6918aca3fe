//! The worker threads and their two queues.

use super::job::{ForceCurve, Job, RunFailure};
use super::load::Load;
use super::run::{Promise, Run};
use crossbeam_channel::{Receiver, Sender, select_biased, unbounded};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

/// Runs jobs one after the other; each worker has its own.
pub trait Simulator: Send {
    /// Runs one job, asking between steps whether to stop.
    ///
    /// # Errors
    /// When the model fails or the run was cancelled; the simulator can be used again.
    fn run(&mut self, job: &Job, cancelled: &dyn Fn() -> bool) -> Result<ForceCurve, RunFailure>;
}

/// Which queue a job waits in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Priority {
    /// Somebody waits for it now.
    Urgent,
    /// Probably needed soon.
    Speculative,
}

/// Worker threads that run jobs.
#[derive(Debug)]
pub struct Pool {
    urgent: Option<Sender<Task>>,
    speculative: Option<Sender<Task>>,
    workers: Vec<JoinHandle<()>>,
    load: Arc<Load>,
    closing: Arc<AtomicBool>,
}

#[derive(Debug)]
struct Task {
    job: Job,
    promise: Promise,
}

impl Pool {
    /// One worker per simulator. Raising `stop` from outside (Ctrl-C) cancels every run.
    pub fn new(simulators: Vec<Box<dyn Simulator>>, stop: Arc<AtomicBool>) -> Self {
        let (urgent, urgent_tasks) = unbounded();
        let (speculative, speculative_tasks) = unbounded();
        let load = Arc::new(Load::default());
        let closing = Arc::new(AtomicBool::new(false));
        let spawn = |simulator| {
            let (first, second) = (urgent_tasks.clone(), speculative_tasks.clone());
            let (load, stops) = (Arc::clone(&load), [Arc::clone(&stop), Arc::clone(&closing)]);
            std::thread::spawn(move || work(simulator, &first, &second, &load, &stops))
        };
        let workers = simulators.into_iter().map(spawn).collect();
        Self { urgent: Some(urgent), speculative: Some(speculative), workers, load, closing }
    }

    /// Number of workers.
    pub fn size(&self) -> usize {
        self.workers.len()
    }

    /// Number of workers that nobody has anything for.
    pub fn idle(&self) -> usize {
        let waiting: usize = [&self.urgent, &self.speculative].into_iter().flatten().map(Sender::len).sum();
        self.size().saturating_sub(self.load.running() + waiting)
    }

    /// Queues a job and returns at once.
    pub fn submit(&self, job: Job, priority: Priority) -> Run {
        let run = Run::new();
        let task = Task { job, promise: Promise(run.slot()) };
        let queue = match priority {
            Priority::Urgent => &self.urgent,
            Priority::Speculative => &self.speculative,
        };
        // A queue without workers gives the task back; dropping it answers `Cancelled`.
        queue.as_ref().map(|q| q.send(task));
        run
    }

    /// Number of runs that were cancelled, before or after they began.
    pub fn cancelled(&self) -> u64 {
        self.load.cancelled()
    }

    /// Time integral of the number of runs under way since the start (s).
    pub fn run_seconds(&self) -> f64 {
        self.load.run_seconds()
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        self.closing.store(true, Ordering::SeqCst);
        self.urgent = None;
        self.speculative = None;
        for worker in self.workers.drain(..) {
            // A worker that panicked has answered its waiters; there is nothing to add.
            let _ = worker.join();
        }
    }
}

fn work(
    mut simulator: Box<dyn Simulator>,
    urgent: &Receiver<Task>,
    speculative: &Receiver<Task>,
    load: &Load,
    stops: &[Arc<AtomicBool>],
) {
    loop {
        let next = select_biased! {
            recv(urgent) -> task => task,
            recv(speculative) -> task => task,
        };
        let Ok(Task { job, promise }) = next else { return };
        let cancelled = || stops.iter().any(|s| s.load(Ordering::Relaxed)) || promise.0.is_unwanted();
        if cancelled() {
            load.cancel();
            continue;
        }
        let _running = load.begin();
        let result = catch_unwind(AssertUnwindSafe(|| simulator.run(&job, &cancelled)));
        let died = || Err(RunFailure::Engine("the run ended in a panic (a bug in the runner)".into()));
        if matches!(result, Ok(Err(RunFailure::Cancelled))) {
            load.cancel();
        }
        promise.0.complete(result.unwrap_or_else(|_| died()).map(Arc::new));
    }
}

#[cfg(test)]
#[path = "workers_tests.rs"]
mod tests;
