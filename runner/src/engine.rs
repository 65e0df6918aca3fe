//! An FMU that answers jobs: the library loaded once, a pool of instances, and the cache before it.

use crate::cache::{Cache, EngineId, Key, Recording};
use crate::fmi::{FmiError, Fmu};
use crate::pool::run::WeakRun;
use crate::pool::wiring::{Names, Wiring, WiringError};
use crate::pool::{FmuSimulator, Job, Pool, Priority, Run, RunFailure, Simulator};
use crate::processor::vector_instructions;
use poropunch::motion::protocol::Protocol;
use poropunch::variables::sensitivities;
use std::collections::{BTreeMap, HashMap};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use thiserror::Error;

/// What an engine is made of.
#[derive(Debug, Clone, Default)]
pub struct EngineOptions {
    /// The FMU; poropunch's own when absent.
    pub fmu: Option<PathBuf>,
    /// Its variables.
    pub names: Names,
    /// Number of instances that run at a time; as many as there are cores when 0.
    pub workers: usize,
    /// Raised from outside to cancel everything.
    pub stop: Arc<AtomicBool>,
}

/// Why an engine cannot be made.
#[derive(Debug, Error)]
pub enum EngineError {
    /// The FMU cannot be loaded.
    #[error(transparent)]
    Fmu(#[from] FmiError),
    /// The FMU does not have the variables.
    #[error(transparent)]
    Wiring(#[from] WiringError),
    /// The FMU gives no instance.
    #[error("the FMU cannot be instantiated: {0}")]
    Instance(RunFailure),
    /// The cache's directory cannot be made.
    #[error("cannot make the directory of the run cache {directory}: {source}; choose another with --cache")]
    Cache {
        /// The directory.
        directory: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
}

/// Model identifier of poropunch's FMU.
const OWN: &str = "poropunch";

/// Answers jobs.
#[derive(Debug)]
pub struct Engine {
    wiring: Arc<Wiring>,
    model: String,
    own: bool,
    pool: Pool,
    cache: Arc<Cache>,
    pending: Mutex<HashMap<Key, WeakRun>>,
    stop: Arc<AtomicBool>,
}

impl Engine {
    /// Loads the FMU and starts the workers.
    ///
    /// # Errors
    /// When the FMU cannot be loaded or wired.
    pub fn new(options: &EngineOptions) -> Result<Self, EngineError> {
        let fmu = Arc::new(match &options.fmu {
            Some(path) => Fmu::open(path)?,
            None => Fmu::builtin()?,
        });
        let description = fmu.description();
        let wiring = Arc::new(Wiring::new(description, &options.names)?);
        let binary = std::fs::read(fmu.library()).unwrap_or_default();
        let id = EngineId::new(&description.guid, &binary, &wiring.identity(), vector_instructions());
        let cache = Arc::new(Cache::new(id));
        let model = description.model_name.clone();
        let own = description.model_identifier == OWN;
        let mut simulators: Vec<Box<dyn Simulator>> = Vec::new();
        for i in 0..worker_count(options.workers) {
            let simulator = FmuSimulator::new(&fmu, &wiring, &format!("{model} {i}"));
            let simulator = Box::new(simulator.map_err(EngineError::Instance)?);
            simulators.push(Box::new(Recording::new(simulator, Arc::clone(&cache))));
        }
        let pool = Pool::new(simulators, Arc::clone(&options.stop));
        let stop = Arc::clone(&options.stop);
        Ok(Self { wiring, model, own, pool, cache, pending: Mutex::default(), stop })
    }

    /// From now on runs are kept in a directory, too.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn keep_in(&self, directory: &Path) -> Result<(), EngineError> {
        let cannot = |source| EngineError::Cache { directory: directory.into(), source };
        self.cache.keep_in(directory).map_err(cannot)
    }

    /// Starts a run, or finds it in the cache or among those under way; returns at once.
    pub fn submit(&self, job: &Job, priority: Priority) -> Run {
        let key = self.cache.key(job);
        if let Some(outcome) = self.cache.get(key) {
            return Run::ended(outcome);
        }
        let mut pending = self.pending.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(run) = pending.get(&key).and_then(WeakRun::upgrade) {
            return run;
        }
        pending.retain(|_, run| run.upgrade().is_some_and(|r| !r.has_ended()));
        let run = self.pool.submit(job.clone(), priority);
        pending.insert(key, run.downgrade());
        run
    }

    /// Whether the FMU, which has derivatives of the force, computes them with these settings: some exclude them, e.g. the
    /// three-dimensional mesh.
    pub fn offers_derivatives(&self, settings: &BTreeMap<String, f64>) -> bool {
        if self.wiring.sensitivities.is_empty() {
            return true;
        }
        let mut parameters = settings.clone();
        parameters.insert(sensitivities::SWITCH.to_owned(), 1.0);
        // Above the surface nothing is to be computed.
        let Ok(protocol) = Protocol::new(vec![(0.0, -1e-2), (1e-3, -1e-2)]) else { return true };
        let job = Job { parameters, protocol: Arc::new(protocol), time_s: Arc::new([1e-3]) };
        !matches!(self.submit(&job, Priority::Urgent).wait(), Err(RunFailure::Model(_)))
    }

    /// The FMU's input, outputs and parameters.
    pub fn wiring(&self) -> &Wiring {
        &self.wiring
    }

    /// Name of the model in the FMU.
    pub fn model_name(&self) -> &str {
        &self.model
    }

    /// Whether it is poropunch's FMU, whose parameters the variable table knows.
    pub fn is_own(&self) -> bool {
        self.own
    }

    /// The cache, for its statistics.
    pub fn cache(&self) -> &Cache {
        &self.cache
    }

    /// The pool, for its load.
    pub fn pool(&self) -> &Pool {
        &self.pool
    }

    /// Whether the user asked to stop.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(std::sync::atomic::Ordering::Relaxed)
    }

    /// What a fit does after an accepted step: it goes on until the user asks to stop.
    pub fn going_on(&self) -> ControlFlow<()> {
        if self.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

fn worker_count(asked: usize) -> usize {
    if asked > 0 { asked } else { std::thread::available_parallelism().map_or(1, Into::into) }
}
