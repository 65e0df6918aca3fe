//! One measured test, in SI units.

use super::error::{DataError, Problem};
use super::estimate::Quartiles;
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
    /// What makes it doubtful, for the first lines of every report.
    pub warnings: Vec<String>,
    /// Times (s), strictly increasing.
    pub time_s: Vec<f64>,
    /// Displacement of the punch, positive into the sample (m).
    pub displacement_m: Vec<f64>,
    /// Force (median of the specimens), positive into the sample (N); empty when only motion was asked for.
    pub force_n: Vec<f64>,
    /// Standard deviation of the force among specimens (N).
    pub spread_n: Option<Vec<f64>>,
    /// Quartiles of the force among specimens (N), where the file gives them or the specimens.
    pub quartiles_n: Option<Vec<(f64, f64)>>,
    /// Force of each specimen (N), one row per specimen.
    pub specimens_n: Vec<Vec<f64>>,
    /// Name of each specimen.
    pub specimen_names: Vec<String>,
    /// Line in the file of each point; empty for points that are not in a file.
    pub lines: Vec<u64>,
}

/// Stands between a file and what makes it doubtful.
pub const DOUBT: &str = ": doubtful: ";

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

    /// Its warnings with the file's name in front.
    pub fn doubts(&self) -> Vec<String> {
        self.warnings.iter().map(|w| format!("{}{DOUBT}{w}", self.file.display())).collect()
    }

    /// A complaint about the file as a whole.
    pub fn error(&self, problem: Problem) -> DataError {
        DataError { file: self.file.clone(), line: None, column: None, problem }
    }

    /// Forces of the specimens (N); of the one curve there is, where there are none.
    pub fn curves_n(&self) -> Vec<&[f64]> {
        if self.specimens_n.is_empty() {
            return vec![&self.force_n];
        }
        self.specimens_n.iter().map(Vec::as_slice).collect()
    }

    /// Median, standard deviation and quartiles of the specimens, where the file did not give them.
    pub(crate) fn summarise_specimens(&mut self) {
        if self.specimens_n.is_empty() || self.specimens_n.iter().any(|s| s.len() != self.len()) {
            self.specimens_n.clear();
            self.specimen_names.clear();
            return;
        }
        let at = |i: usize| -> Vec<f64> { self.specimens_n.iter().map(|s| s[i]).collect() };
        let all: Vec<Vec<f64>> = (0..self.len()).map(at).collect();
        if self.force_n.is_empty() {
            self.force_n = all.iter().map(|v| median(&mut v.clone())).collect();
            self.notes.push(format!("force is the median of {} specimens", self.specimens_n.len()));
        }
        if self.specimens_n.len() > 1 {
            self.spread_n.get_or_insert_with(|| all.iter().map(|v| standard_deviation(v)).collect());
            let quartiles = || all.iter().filter_map(|v| Quartiles::of(v)).map(|q| (q.q25, q.q75)).collect();
            self.quartiles_n.get_or_insert_with(quartiles);
        }
    }

    /// Whether the file says of itself that it was not measured: in words, or by poropunch's mark.
    pub fn is_synthetic(&self) -> bool {
        let says =
            |c: &String| c.to_lowercase().contains("synthetic") || c.starts_with("written by poropunch");
        self.comments.iter().any(says)
    }
}

/// Values over rising times, on a line between the points and constant beyond them; none where there is no point.
pub fn interpolated(time_s: &[f64], values: &[f64], at_s: f64) -> Option<f64> {
    let after = time_s.partition_point(|&t| t < at_s);
    if after == 0 || after >= time_s.len() {
        return values.get(after.min(time_s.len().checked_sub(1)?)).copied();
    }
    let part = (at_s - time_s[after - 1]) / (time_s[after] - time_s[after - 1]);
    Some(values[after - 1] + part * (values[after] - values[after - 1]))
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
