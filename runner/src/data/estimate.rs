//! Values with their uncertainty, and the order statistics that a table of specimens needs.

use super::measurement::median;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A value and its standard uncertainty, in the same unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Estimate {
    /// Best value.
    pub value: f64,
    /// Standard deviation of the value.
    pub sigma: f64,
}

impl Estimate {
    /// In another unit: both numbers times `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { value: self.value * factor, sigma: self.sigma * factor.abs() }
    }
}

/// Median and quartiles of the specimens; all three the same for a single one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quartiles {
    /// Median.
    pub median: f64,
    /// Lower quartile.
    pub q25: f64,
    /// Upper quartile.
    pub q75: f64,
    /// Number of values.
    pub count: usize,
}

impl Quartiles {
    /// Of some values; none of no values.
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |p: f64| quantile(&sorted, p);
        Some(Self { median: at(0.5)?, q25: at(0.25)?, q75: at(0.75)?, count: sorted.len() })
    }

    /// In another unit.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            median: self.median * factor,
            q25: self.q25 * factor,
            q75: self.q75 * factor,
            count: self.count,
        }
    }
}

/// Quantile of sorted values, linear between them (type 7 of Hyndman and Fan, the one of NumPy and R).
fn quantile(sorted: &[f64], p: f64) -> Option<f64> {
    let position = p * sorted.len().checked_sub(1)? as f64;
    let below = position.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    Some(sorted[below] + (position - below as f64) * (sorted[above] - sorted[below]))
}

/// Deviation of normal values about zero from the median of their sizes, of which there must be one and which are put in order.
pub fn deviation_of_sizes(sizes: &mut [f64]) -> f64 {
    const DEVIATION_OVER_MEDIAN: f64 = 1.482_602_2;
    DEVIATION_OVER_MEDIAN * median(sizes)
}

/// Median absolute deviation from the median, as the standard deviation of a normal distribution.
pub fn robust_deviation(values: &[f64]) -> f64 {
    let Some(q) = Quartiles::of(values) else { return 0.0 };
    let mut sizes: Vec<f64> = values.iter().filter(|v| v.is_finite()).map(|v| (v - q.median).abs()).collect();
    deviation_of_sizes(&mut sizes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_those_of_numpy() {
        // numpy.percentile([1, 2, 4, 8, 16, 32], [25, 50, 75])
        let q = Quartiles::of(&[32.0, 1.0, 8.0, 2.0, 16.0, 4.0]).unwrap();
        assert_eq!((q.q25, q.median, q.q75, q.count), (2.5, 6.0, 14.0, 6));
        assert_eq!(Quartiles::of(&[]), None);
        assert_eq!(Quartiles::of(&[3.0]).unwrap().q75, 3.0);
    }

    #[test]
    fn robust_deviation_ignores_an_outlier() {
        assert!((robust_deviation(&[1.0, 2.0, 3.0, 4.0, 1e9]) - 1.482_602_2).abs() < 1e-12);
    }
}
