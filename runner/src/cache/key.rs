//! The hash of everything that a run's result depends on.

use crate::pool::Job;
use std::fmt;

/// Hash of a run's inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Key([u8; 32]);

/// Identity of what evaluates the runs: FMU, how it is wired, and what of the processor may change last bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EngineId([u8; 32]);

impl EngineId {
    /// From the FMU's GUID, the bytes of its binary, a description of inputs, outputs and their units, and the vector instructions
    /// that the model may use: a cache that moves to another processor gives nothing that this one would not compute to the bit.
    pub fn new(guid: &str, binary: &[u8], wiring: &str, vector_instructions: &str) -> Self {
        let mut hash = Hasher::new("engine");
        hash.bytes(guid.as_bytes())
            .bytes(binary)
            .bytes(wiring.as_bytes())
            .bytes(vector_instructions.as_bytes());
        Self(hash.finish())
    }
}

impl Key {
    /// Key of a job on an engine. Parameters are sorted by name, so their order does not matter.
    pub fn of(engine: EngineId, job: &Job) -> Self {
        let mut hash = Hasher::new("run");
        hash.bytes(&engine.0).count(job.parameters.len());
        for (name, value) in &job.parameters {
            hash.bytes(name.as_bytes()).number(*value);
        }
        hash.count(job.protocol.points().len());
        for &(time, displacement) in job.protocol.points() {
            hash.number(time).number(displacement);
        }
        hash.count(job.time_s.len());
        for &time in job.time_s.iter() {
            hash.number(time);
        }
        Self(hash.finish())
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|b| write!(f, "{b:02x}"))
    }
}

/// Every field is preceded by its length, so that no two inputs give the same bytes.
pub(crate) struct Hasher(blake3::Hasher);

impl Hasher {
    /// Hashes of one kind never meet those of another.
    pub(crate) fn new(kind: &str) -> Self {
        let mut hasher = Self(blake3::Hasher::new());
        hasher.bytes(b"poropunch 1").bytes(kind.as_bytes());
        hasher
    }

    pub(crate) fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.count(bytes.len());
        self.0.update(bytes);
        self
    }

    pub(crate) fn count(&mut self, n: usize) -> &mut Self {
        self.0.update(&(n as u64).to_le_bytes());
        self
    }

    fn number(&mut self, value: f64) -> &mut Self {
        self.0.update(&value.to_bits().to_le_bytes());
        self
    }

    pub(crate) fn finish(&self) -> [u8; 32] {
        *self.0.finalize().as_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use poropunch::motion::protocol::Protocol;
    use std::sync::Arc;

    fn job(parameters: &[(&str, f64)], times: &[f64], depth: f64) -> Job {
        Job {
            parameters: parameters.iter().map(|(n, v)| ((*n).to_owned(), *v)).collect(),
            protocol: Arc::new(Protocol::new(vec![(0.0, 0.0), (1.0, depth)]).unwrap()),
            time_s: times.into(),
        }
    }

    #[test]
    fn every_input_changes_the_key_and_order_does_not() {
        let engine = EngineId::new("guid", b"binary", "wiring", "avx2");
        let base = Key::of(engine, &job(&[("a", 1.0), ("b", 2.0)], &[0.0, 1.0], 1e-3));
        assert_eq!(base, Key::of(engine, &job(&[("b", 2.0), ("a", 1.0)], &[0.0, 1.0], 1e-3)));
        let others = [
            Key::of(engine, &job(&[("a", 1.0), ("b", 2.0 + 1e-15)], &[0.0, 1.0], 1e-3)),
            Key::of(engine, &job(&[("a", 1.0), ("c", 2.0)], &[0.0, 1.0], 1e-3)),
            Key::of(engine, &job(&[("a", 1.0)], &[0.0, 1.0], 1e-3)),
            Key::of(engine, &job(&[("a", 1.0), ("b", 2.0)], &[0.0, 0.5], 1e-3)),
            Key::of(engine, &job(&[("a", 1.0), ("b", 2.0)], &[0.0, 1.0], 2e-3)),
            Key::of(
                EngineId::new("guid", b"binarz", "wiring", "avx2"),
                &job(&[("a", 1.0), ("b", 2.0)], &[0.0, 1.0], 1e-3),
            ),
            Key::of(
                EngineId::new("guidb", b"inary", "wiring", "avx2"),
                &job(&[("a", 1.0), ("b", 2.0)], &[0.0, 1.0], 1e-3),
            ),
            Key::of(
                EngineId::new("guid", b"binary", "wiring", "avx512"),
                &job(&[("a", 1.0), ("b", 2.0)], &[0.0, 1.0], 1e-3),
            ),
        ];
        assert!(others.iter().all(|k| *k != base));
    }
}
