//! Numbers, references and bytes by chance, the same in every run.

/// Length of what stands before a state's payload, and of the checksum behind it.
const HEADER: usize = 36;
const CHECKSUM: usize = 16;

/// A sequence of numbers.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n
    }

    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    pub fn of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    pub fn real(&mut self) -> f64 {
        self.of(&[
            f64::NAN,
            f64::INFINITY,
            -1.0,
            0.0,
            1e300,
            1e-300,
            0.5,
            1.0,
            1e-4,
            1e-3,
            2e-3,
            10.0,
            1e-15,
            1e5,
        ])
    }

    /// A small number, -1 among them.
    pub fn whole(&mut self) -> i32 {
        self.below(6) as i32 - 1
    }

    /// A reference below `end`, or rarely one of nothing.
    pub fn reference(&mut self, end: usize) -> u32 {
        if self.one_in(20) { self.of(&[1000, u32::MAX]) } else { self.below(end) as u32 }
    }

    /// `n`, or rarely a count that is absurd.
    pub fn count(&mut self, n: usize) -> usize {
        if self.one_in(30) { self.of(&[1 << 17, 1 << 40, usize::MAX]) } else { n }
    }

    /// A size for a step (s). Steps through a whole test are another test's: with steps of a tenth of a millisecond inside they take
    /// minutes.
    pub fn size(&mut self) -> f64 {
        let size = match self.below(40) {
            0 => self.real(),
            1 => 0.1,
            _ => 1e-3,
        };
        if size.is_finite() { size.min(0.1) } else { size }
    }

    /// `time`, or rarely another.
    pub fn near(&mut self, time: f64) -> f64 {
        if self.one_in(50) { self.real() } else { time }
    }

    /// A serialised state, mostly with a change, of these mostly with the right checksum; and whether it has one.
    pub fn forged(&mut self, original: &[u8]) -> (Vec<u8>, bool) {
        let mut bytes = original.to_vec();
        if bytes.len() < HEADER + CHECKSUM + 8 || self.one_in(5) {
            return (bytes, false);
        }
        let payload = HEADER..bytes.len() - CHECKSUM;
        for _ in 0..=self.below(3) {
            // Settings stand at the beginning, the path's numbers at the end.
            let place = match self.below(3) {
                0 => HEADER + self.below(payload.len().min(1500)),
                1 => payload.end - 1 - self.below(payload.len().min(1500)),
                _ => self.below(bytes.len()),
            };
            let end = (place + 8).min(payload.end);
            match self.below(3) {
                0 => bytes[place] ^= 1 << self.below(8),
                1 if place < end => {
                    let number = self.real().to_le_bytes();
                    bytes[place..end].copy_from_slice(&number[..end - place]);
                }
                _ => bytes[place] = self.below(256) as u8,
            }
        }
        if !self.one_in(10) {
            let hash = blake3::hash(&bytes[..payload.end]);
            bytes[payload.end..].copy_from_slice(&hash.as_bytes()[..CHECKSUM]);
        }
        (bytes, true)
    }
}
