//! Distances of samples from the line through their two neighbours, in units of the noise of one sample: what changes slowly, by a drift, a
//! relaxation or a difference between specimens, cancels from them.

/// Fewest distances that tell a deviation: of less most are kinks.
pub const FEWEST: usize = 20;

/// Distances from the second sample to the last but one, with their signs.
pub fn distances(time_s: &[f64], values: &[f64]) -> impl Iterator<Item = f64> {
    let distance =
        |(first, v): (usize, &[f64])| weights(time_s, first).iter().zip(v).map(|(w, v)| w * v).sum();
    values.windows(3).enumerate().map(distance)
}

/// Weights of three samples, from the `first` on, in the distance of the middle one.
pub fn weights(time_s: &[f64], first: usize) -> [f64; 3] {
    let t = &time_s[first..];
    let b = (t[1] - t[0]) / (t[2] - t[0]);
    let a = 1.0 - b;
    let norm = (1.0 + a * a + b * b).sqrt();
    [-a / norm, 1.0 / norm, -b / norm]
}
