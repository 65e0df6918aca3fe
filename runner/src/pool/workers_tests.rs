//! The pool with simulators whose every step the test controls.

use super::*;
use poropunch::motion::protocol::Protocol;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Logs what it runs; a job with parameter `wait` steps until released or cancelled.
struct Scripted {
    log: Arc<Mutex<Vec<String>>>,
    release: Arc<AtomicBool>,
}

impl Simulator for Scripted {
    fn run(&mut self, job: &Job, cancelled: &dyn Fn() -> bool) -> Result<ForceCurve, RunFailure> {
        let name = job.parameters.keys().next().cloned().unwrap_or_default();
        self.log.lock().unwrap().push(name.clone());
        match name.as_str() {
            "panic" => panic!("scripted"),
            "fail" => return Err(RunFailure::Model("scripted".into())),
            "wait" => {
                while !self.release.load(Ordering::SeqCst) {
                    if cancelled() {
                        self.log.lock().unwrap().push("stopped".into());
                        return Err(RunFailure::Cancelled);
                    }
                    std::thread::sleep(Duration::from_millis(1));
                }
            }
            _ => {}
        }
        Ok(ForceCurve { values: vec![job.parameters.values().copied().collect()], ..ForceCurve::default() })
    }
}

struct Stage {
    pool: Pool,
    log: Arc<Mutex<Vec<String>>>,
    release: Arc<AtomicBool>,
    stop: Arc<AtomicBool>,
}

impl Stage {
    fn new(workers: usize) -> Self {
        let (log, release, stop) = (Arc::default(), Arc::default(), Arc::default());
        let simulator = || Scripted { log: Arc::clone(&log), release: Arc::clone(&release) };
        let simulators = (0..workers).map(|_| Box::new(simulator()) as Box<dyn Simulator>).collect();
        Self { pool: Pool::new(simulators, Arc::clone(&stop)), log, release, stop }
    }

    fn submit(&self, name: &str, priority: Priority) -> Run {
        let protocol = Arc::new(Protocol::new(vec![(0.0, 0.0)]).unwrap());
        let parameters = [(name.to_owned(), 7.0)].into();
        self.pool.submit(Job { parameters, protocol, time_s: Arc::from([0.0]) }, priority)
    }

    fn log(&self) -> Vec<String> {
        self.log.lock().unwrap().clone()
    }

    /// Waits until the log is at least this long.
    fn wait_for(&self, entries: usize) {
        let start = Instant::now();
        while self.log().len() < entries {
            assert!(start.elapsed() < Duration::from_secs(10), "log stays at {:?}", self.log());
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

#[test]
fn urgent_jobs_go_before_speculative_ones() {
    let stage = Stage::new(1);
    let first = stage.submit("wait", Priority::Urgent);
    stage.wait_for(1);
    let late = stage.submit("column", Priority::Speculative);
    let early = stage.submit("trial", Priority::Urgent);
    stage.release.store(true, Ordering::SeqCst);
    assert!(first.wait().is_ok() && early.wait().is_ok());
    assert_eq!(late.wait().unwrap().force_n(), [7.0]);
    assert_eq!(stage.log(), ["wait", "trial", "column"]);
}

#[test]
fn dropping_the_handle_skips_or_stops_the_run() {
    let stage = Stage::new(1);
    let running = stage.submit("wait", Priority::Urgent);
    let queued = stage.submit("never", Priority::Urgent);
    stage.wait_for(1);
    drop(queued);
    let shared = running.clone();
    drop(running);
    assert!(!shared.has_ended(), "one handle is left");
    drop(shared);
    let last = stage.submit("last", Priority::Urgent);
    assert!(last.wait().is_ok());
    assert_eq!(stage.log(), ["wait", "stopped", "last"]);
}

#[test]
fn failures_and_panics_are_answers_and_the_worker_lives_on() {
    let stage = Stage::new(1);
    assert_eq!(stage.submit("fail", Priority::Urgent).wait(), Err(RunFailure::Model("scripted".into())));
    assert!(matches!(stage.submit("panic", Priority::Urgent).wait(), Err(RunFailure::Engine(_))));
    assert!(stage.submit("ok", Priority::Urgent).wait().is_ok());
}

#[test]
fn stop_cancels_running_and_queued() {
    let stage = Stage::new(2);
    let runs: Vec<Run> = (0..5).map(|_| stage.submit("wait", Priority::Urgent)).collect();
    stage.wait_for(2);
    stage.stop.store(true, Ordering::SeqCst);
    assert!(runs.iter().all(|r| r.wait() == Err(RunFailure::Cancelled)));
    assert_eq!(stage.log().iter().filter(|l| *l == "wait").count(), 2);
}

#[test]
fn a_weak_run_is_found_only_while_wanted() {
    let run = Run::ended(Err(RunFailure::Cancelled));
    let weak = run.downgrade();
    assert!(weak.upgrade().is_some());
    drop(run);
    assert!(weak.upgrade().is_none());
}

#[test]
fn load_counts_runs_times_seconds() {
    let stage = Stage::new(2);
    let runs = [stage.submit("wait", Priority::Urgent), stage.submit("wait", Priority::Urgent)];
    stage.wait_for(2);
    let (from, start) = (stage.pool.run_seconds(), Instant::now());
    std::thread::sleep(Duration::from_millis(50));
    let mean = (stage.pool.run_seconds() - from) / start.elapsed().as_secs_f64();
    assert!((1.9..=2.01).contains(&mean), "{mean}");
    stage.release.store(true, Ordering::SeqCst);
    assert!(runs.iter().all(|r| r.wait().is_ok()));
}
