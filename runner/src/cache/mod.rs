//! Runs that were made are never made again: a content-addressed store, in memory and on disk.
//!
//! A run's key is a hash of all that its result depends on. Entries are written whole or not at all, and
//! carry a checksum: a crash or a full disk at any time costs at most the run that was being written.

pub mod key;
pub mod store;

pub(crate) use key::Hasher;
pub use key::{EngineId, Key};
pub use store::{Cache, CacheStatistics, Recording};
