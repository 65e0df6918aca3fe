//! Runs in memory and on disk.

use super::key::{EngineId, Key};
use crate::pool::{ForceCurve, Job, Outcome, RunFailure, Simulator};
use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Marks an entry's file and the version of its layout.
const MAGIC: &[u8; 8] = b"ppunch01";
const HASH_LENGTH: usize = 32;

/// Runs that have ended, by key. Failures of the model are kept too: they are the same every time.
#[derive(Debug)]
pub struct Cache {
    engine: EngineId,
    directory: OnceLock<PathBuf>,
    memory: Mutex<Memory>,
    counts: Counts,
    trouble: Mutex<Option<String>>,
}

/// Memory that runs which are on disk too may take (bytes); beyond it they are read from disk again.
const MEMORY_BYTES: usize = 256 << 20;

#[derive(Debug, Default)]
struct Memory {
    runs: HashMap<Key, Outcome>,
    /// Size of the runs that are on disk too.
    bytes: usize,
}

impl Memory {
    fn insert(&mut self, key: Key, outcome: &Outcome, on_disk: bool) {
        let size = |curve: &ForceCurve| 8 * curve.time_s.len() * (2 + curve.values.len());
        if on_disk {
            self.bytes += outcome.as_ref().map_or(0, |curve| size(curve)) + 256;
        }
        if self.bytes > MEMORY_BYTES {
            *self = Self::default();
        }
        self.runs.insert(key, outcome.clone());
    }
}

#[derive(Debug, Default)]
struct Counts {
    runs: AtomicU64,
    failed: AtomicU64,
    memory_hits: AtomicU64,
    disk_hits: AtomicU64,
    corrupt: AtomicU64,
}

/// What the cache did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CacheStatistics {
    /// Runs that were made.
    pub runs: u64,
    /// Of these, runs in which the model failed.
    pub failed: u64,
    /// Runs spared because they were in memory.
    pub memory_hits: u64,
    /// Runs spared because they were on disk.
    pub disk_hits: u64,
    /// Entries on disk that were damaged, and made again.
    pub corrupt: u64,
}

impl Cache {
    /// A cache for one engine, in memory alone.
    pub fn new(engine: EngineId) -> Self {
        Self {
            engine,
            directory: OnceLock::new(),
            memory: Mutex::default(),
            counts: Counts::default(),
            trouble: Mutex::default(),
        }
    }

    /// From now on runs are kept in a directory, too (made with the first run, if it is not there); only the first that is given counts.
    ///
    /// # Errors
    /// When there cannot be a directory: the path leads through a file.
    pub fn keep_in(&self, directory: &Path) -> std::io::Result<()> {
        let existing = directory.ancestors().find(|path| path.exists());
        if existing.is_some_and(|path| !path.is_dir()) {
            return Err(std::io::ErrorKind::NotADirectory.into());
        }
        self.directory.get_or_init(|| directory.to_owned());
        Ok(())
    }

    /// Key of a job.
    pub fn key(&self, job: &Job) -> Key {
        Key::of(self.engine, job)
    }

    /// The outcome of an earlier run.
    pub fn get(&self, key: Key) -> Option<Outcome> {
        if let Some(outcome) = self.memory().runs.get(&key) {
            self.counts.memory_hits.fetch_add(1, Ordering::Relaxed);
            return Some(outcome.clone());
        }
        let outcome = self.load(key)?;
        self.counts.disk_hits.fetch_add(1, Ordering::Relaxed);
        self.memory().insert(key, &outcome, true);
        Some(outcome)
    }

    /// Keeps the outcome of a run, unless it would be different another time.
    pub fn put(&self, key: Key, outcome: &Outcome) {
        if matches!(outcome, Err(RunFailure::Cancelled)) {
            return;
        }
        self.counts.runs.fetch_add(1, Ordering::Relaxed);
        if outcome.is_err() {
            self.counts.failed.fetch_add(1, Ordering::Relaxed);
        }
        if matches!(outcome, Err(RunFailure::Engine(_))) {
            return;
        }
        let saved = self.save(key, outcome);
        self.memory().insert(key, outcome, matches!(saved, Ok(true)));
        if let Err(error) = saved {
            let mut trouble = self.trouble.lock().unwrap_or_else(PoisonError::into_inner);
            trouble.get_or_insert_with(|| error.to_string());
        }
    }

    /// The first reason why a run could not be written to disk (disk full, no permission); results are
    /// unaffected, but a resumed fit will have to make those runs again.
    pub fn trouble(&self) -> Option<String> {
        self.trouble.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// What the cache did so far.
    pub fn statistics(&self) -> CacheStatistics {
        let read = |c: &AtomicU64| c.load(Ordering::Relaxed);
        let c = &self.counts;
        CacheStatistics {
            runs: read(&c.runs),
            failed: read(&c.failed),
            memory_hits: read(&c.memory_hits),
            disk_hits: read(&c.disk_hits),
            corrupt: read(&c.corrupt),
        }
    }

    fn memory(&self) -> std::sync::MutexGuard<'_, Memory> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn path(&self, key: Key) -> Option<PathBuf> {
        self.directory.get().map(|d| d.join(format!("{key}.run")))
    }

    fn load(&self, key: Key) -> Option<Outcome> {
        let bytes = std::fs::read(self.path(key)?).ok()?;
        let outcome = decode(key, &bytes);
        if outcome.is_none() {
            self.counts.corrupt.fetch_add(1, Ordering::Relaxed);
        }
        outcome
    }

    /// Into a temporary file, to disk, then in place by renaming: whole or not at all. Whether there is a disk.
    fn save(&self, key: Key, outcome: &Outcome) -> std::io::Result<bool> {
        let (Some(path), Some(directory)) = (self.path(key), self.directory.get()) else { return Ok(false) };
        let bytes = encode(key, outcome).map_err(std::io::Error::other)?;
        std::fs::create_dir_all(directory)?;
        let mut file = tempfile::NamedTempFile::new_in(directory)?;
        file.write_all(&bytes)?;
        file.as_file().sync_data()?;
        file.persist(path)?;
        Ok(true)
    }
}

/// Layout: magic, blake3 of key and payload, payload.
fn encode(key: Key, outcome: &Outcome) -> Result<Vec<u8>, postcard::Error> {
    let plain: Result<&ForceCurve, &RunFailure> = outcome.as_ref().map(AsRef::as_ref);
    let payload = postcard::to_stdvec(&plain)?;
    Ok([MAGIC.as_slice(), checksum(key, &payload).as_bytes(), &payload].concat())
}

fn decode(key: Key, bytes: &[u8]) -> Option<Outcome> {
    let body = bytes.strip_prefix(MAGIC.as_slice())?;
    let (hash, payload) = body.split_at_checked(HASH_LENGTH)?;
    if hash != checksum(key, payload).as_bytes() {
        return None;
    }
    let plain: Result<ForceCurve, RunFailure> = postcard::from_bytes(payload).ok()?;
    Some(plain.map(Arc::new))
}

fn checksum(key: Key, payload: &[u8]) -> blake3::Hash {
    // With the key inside, an entry under another's name is as good as damaged.
    blake3::Hasher::new().update(key.to_string().as_bytes()).update(payload).finalize()
}

/// A simulator whose runs are kept as soon as they end.
pub struct Recording {
    inner: Box<dyn Simulator>,
    cache: Arc<Cache>,
}

impl Recording {
    /// Keeps the runs of `inner` in `cache`.
    pub fn new(inner: Box<dyn Simulator>, cache: Arc<Cache>) -> Self {
        Self { inner, cache }
    }
}

impl Simulator for Recording {
    fn run(&mut self, job: &Job, cancelled: &dyn Fn() -> bool) -> Result<ForceCurve, RunFailure> {
        let outcome = self.inner.run(job, cancelled).map(Arc::new);
        self.cache.put(self.cache.key(job), &outcome);
        outcome.map(Arc::unwrap_or_clone)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use poropunch::motion::protocol::Protocol;

    fn engine() -> EngineId {
        EngineId::new("guid", b"binary", "", "")
    }

    fn kept_in(directory: &Path) -> Cache {
        let cache = Cache::new(engine());
        cache.keep_in(directory).unwrap();
        cache
    }

    fn job(value: f64) -> Job {
        let protocol = Arc::new(Protocol::new(vec![(0.0, 0.0)]).unwrap());
        Job { parameters: [("a".to_owned(), value)].into(), protocol, time_s: Arc::from([0.0]) }
    }

    fn curve() -> Outcome {
        let values = vec![vec![std::f64::consts::PI, -0.0, 5e-324]];
        Ok(Arc::new(ForceCurve { names: vec!["force".into()], values, ..ForceCurve::default() }))
    }

    #[test]
    fn entries_survive_the_process_bit_for_bit() {
        let directory = tempfile::tempdir().unwrap();
        let open = || kept_in(directory.path());
        let failure: Outcome = Err(RunFailure::Model("no convergence".into()));
        let cache = open();
        cache.put(cache.key(&job(1.0)), &curve());
        cache.put(cache.key(&job(2.0)), &failure);
        for cache in [cache, open()] {
            assert_eq!(cache.get(cache.key(&job(1.0))), Some(curve()));
            assert_eq!(cache.get(cache.key(&job(2.0))), Some(failure.clone()));
            assert_eq!(cache.get(cache.key(&job(3.0))), None);
        }
        let s = open().statistics();
        assert_eq!((s.runs, s.disk_hits), (0, 0));
    }

    #[test]
    fn the_directory_is_made_with_the_first_run() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out/cache");
        let cache = kept_in(&path);
        assert!(!folder.path().join("out").exists());
        cache.put(cache.key(&job(1.0)), &curve());
        assert!(path.is_dir() && cache.trouble().is_none());
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        assert!(Cache::new(engine()).keep_in(&file.join("cache")).is_err());
    }

    #[test]
    fn memory_is_bounded_by_what_is_on_disk() {
        let mut memory = Memory::default();
        let points = 1 << 20;
        let curve = ForceCurve { time_s: vec![0.0; points], ..ForceCurve::default() };
        let large: Outcome = Ok(Arc::new(curve));
        let cache = Cache::new(engine());
        let mut most = 0;
        for i in 0..40 {
            memory.insert(cache.key(&job(f64::from(i))), &large, true);
            most = most.max(memory.runs.len());
            assert!(memory.bytes <= MEMORY_BYTES);
        }
        assert!((8..=17).contains(&most), "{most}");
        // What is nowhere else stays.
        let mut memory = Memory::default();
        (0..40).for_each(|i| memory.insert(cache.key(&job(f64::from(i))), &large, false));
        assert_eq!(memory.runs.len(), 40);
    }

    #[test]
    fn what_may_end_differently_is_not_kept() {
        let cache = Cache::new(engine());
        let key = cache.key(&job(1.0));
        cache.put(key, &Err(RunFailure::Cancelled));
        cache.put(key, &Err(RunFailure::Engine("no memory".into())));
        assert_eq!(cache.get(key), None);
        assert_eq!((cache.statistics().runs, cache.statistics().failed), (1, 1));
    }

    #[test]
    fn a_damaged_entry_is_as_if_absent() {
        let directory = tempfile::tempdir().unwrap();
        let cache = kept_in(directory.path());
        let (key, other) = (cache.key(&job(1.0)), cache.key(&job(2.0)));
        cache.put(key, &curve());
        let path = cache.path(key).unwrap();
        let good = std::fs::read(&path).unwrap();
        let fresh = || kept_in(directory.path());
        for i in 0..good.len() {
            let mut bad = good.clone();
            bad[i] ^= 0x40;
            std::fs::write(&path, &bad).unwrap();
            assert_eq!(fresh().get(key), None, "byte {i} flipped");
            std::fs::write(&path, &good[..i]).unwrap();
            assert_eq!(fresh().get(key), None, "cut after {i} bytes");
        }
        std::fs::write(cache.path(other).unwrap(), &good).unwrap();
        let cache = fresh();
        assert_eq!(cache.get(other), None, "an entry of another run");
        assert_eq!(cache.statistics().corrupt, 1);
        cache.put(key, &curve());
        assert_eq!(fresh().get(key), Some(curve()), "written anew");
    }

    #[test]
    fn a_disk_that_takes_nothing_is_reported_and_not_fatal() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("cache");
        let cache = kept_in(&path);
        std::fs::write(&path, "").unwrap();
        let key = cache.key(&job(1.0));
        cache.put(key, &curve());
        assert!(cache.trouble().is_some());
        assert_eq!(cache.get(key), Some(curve()), "still in memory");
    }
}
