//! One measured test, in SI units.

use std::path::PathBuf;

/// Force against time and displacement of one test, or the median of several specimens.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measurement {
    /// Name of the test: the file's name without extension.
    pub name: String,
    /// Where it was read from.
    pub file: PathBuf,
    /// Comment lines of the file, without `#`: its provenance.
    pub comments: Vec<String>,
    /// What was read leniently, for the user to check.
    pub notes: Vec<String>,
    /// Times (s), strictly increasing.
    pub time_s: Vec<f64>,
    /// Displacement of the punch, positive into the sample (m).
    pub displacement_m: Vec<f64>,
    /// Force (median of the specimens), positive into the sample (N); empty when only motion was asked for.
    pub force_n: Vec<f64>,
    /// Standard deviation of the force among specimens (N).
    pub spread_n: Option<Vec<f64>>,
    /// Force of each specimen (N), one row per specimen.
    pub specimens_n: Vec<Vec<f64>>,
}

impl Measurement {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Largest displacement (m).
    pub fn depth_m(&self) -> f64 {
        self.displacement_m.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether the file says of itself that it was not measured.
    pub fn is_synthetic(&self) -> bool {
        self.comments.iter().any(|c| c.to_lowercase().contains("synthetic"))
    }
}

/// Median of some values, which must not be empty or NaN.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n % 2 == 1 { values[n / 2] } else { 0.5 * (values[n / 2 - 1] + values[n / 2]) }
}

/// Standard deviation of a sample (divided by n - 1); 0 for a single value.
pub fn standard_deviation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    (square / (n - 1.0).max(1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_and_deviation() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(standard_deviation(&[1.0, 3.0]), 2f64.sqrt());
        assert_eq!(standard_deviation(&[7.0]), 0.0);
    }
}
