//! Exact intervals of a share (Clopper and Pearson).

use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF};

/// So many of so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Share {
    /// Those that are.
    pub hits: u64,
    /// All.
    pub of: u64,
}

impl Share {
    /// Counts one more.
    pub fn count(&mut self, hit: bool) {
        self.of += 1;
        self.hits += u64::from(hit);
    }

    /// Of some answers.
    pub fn of(answers: impl IntoIterator<Item = bool>) -> Self {
        let mut share = Self::default();
        answers.into_iter().for_each(|hit| share.count(hit));
        share
    }

    /// Of both.
    #[must_use]
    pub fn beside(self, other: Self) -> Self {
        Self { hits: self.hits + other.hits, of: self.of + other.of }
    }

    /// The share; none of nothing.
    pub fn value(self) -> Option<f64> {
        (self.of > 0).then(|| self.hits as f64 / self.of as f64)
    }

    /// 90 % interval, each end of which is a one-sided bound of 95 %.
    pub fn interval(self) -> (f64, f64) {
        const TAIL: f64 = 0.05;
        let quantile = |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(f64::NAN, |beta| beta.inverse_cdf(p));
        let (k, n) = (self.hits as f64, self.of as f64);
        let low = if self.hits == 0 { 0.0 } else { quantile(k, n - k + 1.0, TAIL) };
        let high = if self.hits == self.of { 1.0 } else { quantile(k + 1.0, n - k, 1.0 - TAIL) };
        (low, high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_the_tabulated_ones() {
        // What defines them: at its ends as many hits or more, as many or fewer, have a probability of 5 %.
        let share = Share { hits: 5, of: 20 };
        let (low, high) = share.interval();
        let choose = |k: i32| (1..=k).fold(1.0, |c, i| c * f64::from(21 - i) / f64::from(i));
        let mass = |p: f64, k: i32| choose(k) * p.powi(k) * (1.0 - p).powi(20 - k);
        let at_least: f64 = (5..=20).map(|k| mass(low, k)).sum();
        let at_most: f64 = (0..=5).map(|k| mass(high, k)).sum();
        assert!((at_least - 0.05).abs() < 1e-6 && (at_most - 0.05).abs() < 1e-6, "{at_least} {at_most}");
        let (low, high) = Share { hits: 0, of: 20 }.interval();
        assert!(low == 0.0 && (high - (1.0 - 0.05f64.powf(1.0 / 20.0))).abs() < 1e-4, "{high}");
        assert_eq!(Share::default().interval(), (0.0, 1.0));
    }
}
