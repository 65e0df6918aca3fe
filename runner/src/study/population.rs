//! What specimens have in common and how they differ: a hierarchical model of one value, and its restricted likelihood.
//!
//! ```text
//! y_s | eta_s ~ N(eta_s, v_s)         y_s = ln(value) of specimen s, v_s from its own likelihood
//! eta_s       ~ N(m_group(s), t^2)    t: spread between specimens, the same in all groups
//! ```
//! t maximises the restricted likelihood; means and differences have Student's t intervals with the variance scaled as Knapp and
//! Hartung (2003) do, and never less than t^2 and v say; the interval of t is that of its profile. The scatter of the y_s is not
//! used: it holds the v_s, too.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Rise of -2 ln(likelihood) at the ends of a 95 % profile interval: chi^2 of one degree of freedom.
const RISE: f64 = 3.841_458_820_694_124;
/// Power with which a difference is to be found, and the level of its test.
const POWER: f64 = 0.8;
const LEVEL: f64 = 0.05;

/// One specimen's value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observed {
    /// ln of its magnitude.
    pub ln_value: f64,
    /// Standard deviation of that, from the specimen's own likelihood.
    pub sigma: f64,
    /// Index of its group.
    pub group: usize,
}

/// An estimate with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Interval {
    /// Estimate.
    pub value: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

impl Interval {
    /// Whether a value lies inside.
    pub fn contains(&self, value: f64) -> bool {
        (self.lower..=self.upper).contains(&value)
    }

    /// Of another scale that rises with this one.
    #[must_use]
    pub fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        Self { value: f(self.value), lower: f(self.lower), upper: f(self.upper) }
    }
}

/// What a population is like in one value, in ln.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    /// Mean of each group; none for a group without specimens.
    pub means: Vec<Option<Interval>>,
    /// Specimens in each group.
    pub counts: Vec<usize>,
    /// Standard deviation between specimens of one group.
    pub spread: Interval,
    /// Variance of a specimen's own estimate, mean over specimens.
    pub own_variance: f64,
    covariance: Vec<f64>,
    freedom: f64,
}

/// The sums that everything is made of, at one spread.
struct Sums {
    weights: Vec<f64>,
    means: Vec<f64>,
    /// Weighted sum of squares around the means.
    squares: f64,
    /// -2 ln of the restricted likelihood, without constants.
    deviance: f64,
}

impl Sums {
    fn at(spread: f64, observed: &[Observed], groups: usize) -> Self {
        let (mut weights, mut first) = (vec![0.0; groups], vec![0.0; groups]);
        let mut deviance = 0.0;
        for o in observed {
            let variance = spread * spread + o.sigma * o.sigma;
            weights[o.group] += 1.0 / variance;
            first[o.group] += o.ln_value / variance;
            deviance += variance.ln();
        }
        let means: Vec<f64> = first.iter().zip(&weights).map(|(f, w)| f / w).collect();
        let square =
            |o: &Observed| (o.ln_value - means[o.group]).powi(2) / (spread * spread + o.sigma * o.sigma);
        let squares: f64 = observed.iter().map(square).sum();
        deviance += squares + weights.iter().filter(|w| **w > 0.0).map(|w| w.ln()).sum::<f64>();
        Self { weights, means, squares, deviance }
    }
}

impl Population {
    /// From at least two specimens more than there are groups with specimens: with fewer nothing is known of the spread.
    pub fn of(observed: &[Observed], groups: usize) -> Option<Self> {
        let mut counts = vec![0; groups];
        observed.iter().for_each(|o| counts[o.group] += 1);
        let freedom = observed.len().checked_sub(counts.iter().filter(|c| **c > 0).count())?;
        let is_usable = |o: &Observed| o.ln_value.is_finite() && o.sigma.is_finite() && o.sigma > 0.0;
        if freedom < 2 || !observed.iter().all(is_usable) {
            return None;
        }
        let deviance = |spread: f64| Sums::at(spread, observed, groups).deviance;
        let largest = largest(observed);
        let best = minimum(&deviance, largest);
        let limit = deviance(best) + RISE;
        let lower = if deviance(0.0) <= limit { 0.0 } else { crossing(&deviance, limit, 0.0, best) };
        let mut beyond = best.max(largest / 100.0);
        while deviance(beyond) <= limit && beyond < 1e3 {
            beyond *= 2.0;
        }
        let upper = crossing(&deviance, limit, beyond, best);

        let sums = Sums::at(best, observed, groups);
        // Less than 1 is luck: it must not make intervals narrower than the model says.
        let scale = (sums.squares / freedom as f64).max(1.0);
        let freedom = freedom as f64;
        let quantile = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(0.975);
        let covariance: Vec<f64> = sums.weights.iter().map(|w| scale / w).collect();
        let mean = |k: usize| -> Option<Interval> {
            let half = quantile * covariance[k].sqrt();
            let value = sums.means[k];
            (counts[k] > 0).then_some(Interval { value, lower: value - half, upper: value + half })
        };
        Some(Self {
            means: (0..groups).map(mean).collect(),
            spread: Interval { value: best, lower, upper },
            own_variance: observed.iter().map(|o| o.sigma * o.sigma).sum::<f64>() / observed.len() as f64,
            counts,
            covariance,
            freedom,
        })
    }

    /// How much larger (in ln) the mean of the second group is.
    pub fn difference(&self, first: usize, second: usize) -> Option<Interval> {
        let (a, b) = ((*self.means.get(first)?)?, (*self.means.get(second)?)?);
        let quantile = StudentsT::new(0.0, 1.0, self.freedom).ok()?.inverse_cdf(0.975);
        let half = quantile * (self.covariance[first] + self.covariance[second]).sqrt();
        let value = b.value - a.value;
        Some(Interval { value, lower: value - half, upper: value + half })
    }

    /// Specimens in each of two groups that find a difference (in ln) with a power of 80 % at a level of 5 %, two-sided: with the
    /// spread and the specimens' own variance as they are here.
    pub fn specimens_needed(&self, difference: f64) -> Option<usize> {
        let variance = self.spread.value.powi(2) + self.own_variance;
        needed(variance, difference)
    }
}

/// Specimens per group for a test by Student's t (the normal quantile of the power, as usual).
fn needed(variance: f64, difference: f64) -> Option<usize> {
    if !(difference.abs() > 0.0 && variance.is_finite()) {
        return None;
    }
    let power = Normal::new(0.0, 1.0).ok()?.inverse_cdf(POWER);
    let is_enough = |n: usize| {
        let Ok(t) = StudentsT::new(0.0, 1.0, 2.0 * n as f64 - 2.0) else { return false };
        let z = t.inverse_cdf(1.0 - LEVEL / 2.0) + power;
        n as f64 >= 2.0 * variance * (z / difference).powi(2)
    };
    // More than a million specimens are no plan.
    let (mut low, mut high) = (1, 2);
    while !is_enough(high) {
        (low, high) = (high, 2 * high);
        if high > 1 << 20 {
            return None;
        }
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if is_enough(middle) { high = middle } else { low = middle }
    }
    Some(high)
}

/// No spread is larger than the whole range of the values.
fn largest(observed: &[Observed]) -> f64 {
    let values = || observed.iter().map(|o| o.ln_value);
    let range = values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min);
    let own = observed.iter().map(|o| o.sigma).fold(f64::INFINITY, f64::min);
    range.max(1e-3 * own)
}

/// Place of the least value in [0, largest]: the restricted likelihood may have a hump at 0 beside the one inside, so a grid comes
/// first.
fn minimum(f: &impl Fn(f64) -> f64, largest: f64) -> f64 {
    const STEPS: usize = 200;
    let at = |k: usize| largest * (k as f64 / STEPS as f64).powi(2);
    let best = (0..=STEPS).min_by(|a, b| f(at(*a)).total_cmp(&f(at(*b)))).unwrap_or(0);
    let (mut low, mut high) = (at(best.saturating_sub(1)), at((best + 1).min(STEPS)));
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    for _ in 0..60 {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if f(a) <= f(b) { high = b } else { low = a }
    }
    let found = (low + high) / 2.0;
    // A minimum at the boundary is met by the search only to its last step.
    if f(0.0) <= f(found) || found < 1e-6 * largest { 0.0 } else { found }
}

/// Where a function passes a limit, between a place outside and one inside.
fn crossing(f: &impl Fn(f64) -> f64, limit: f64, mut outside: f64, mut inside: f64) -> f64 {
    for _ in 0..80 {
        let middle = (outside + inside) / 2.0;
        if f(middle) > limit { outside = middle } else { inside = middle }
    }
    (outside + inside) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::Distribution;

    fn observed(values: &[(f64, f64, usize)]) -> Vec<Observed> {
        values.iter().map(|&(ln_value, sigma, group)| Observed { ln_value, sigma, group }).collect()
    }

    /// Goal: with equal variances the model is a two-sample t test.
    #[test]
    fn with_equal_sigmas_it_is_the_t_test() {
        let data = [(0.0, 0), (1.0, 0), (2.0, 0), (5.0, 1), (6.5, 1), (8.0, 1)];
        let sigma = 0.1;
        let p = Population::of(&observed(&data.map(|(y, g)| (y, sigma, g))), 2).unwrap();
        // Pooled variance of {0, 1, 2} and {5, 6.5, 8}: (2 + 4.5) / 4.
        let pooled: f64 = 6.5 / 4.0;
        approx::assert_relative_eq!(p.spread.value, (pooled - sigma * sigma).sqrt(), max_relative = 1e-6);
        let d = p.difference(0, 1).unwrap();
        // Quantile of Student's t with 4 degrees of freedom: 2.776445.
        approx::assert_relative_eq!(d.value, 5.5, max_relative = 1e-12);
        approx::assert_relative_eq!(
            d.upper - 5.5,
            2.776_445 * (pooled * 2.0 / 3.0).sqrt(),
            max_relative = 1e-5
        );
    }

    #[test]
    fn specimens_without_spread_have_none_and_uncertain_ones_count_less() {
        let p = Population::of(&observed(&[(0.0, 1.0, 0), (0.1, 1.0, 0), (-0.1, 1.0, 0)]), 1).unwrap();
        assert_eq!((p.spread.value, p.spread.lower), (0.0, 0.0));
        assert!(p.spread.upper > 0.3);
        let p =
            Population::of(&observed(&[(0.0, 0.01, 0), (0.1, 0.01, 0), (0.2, 0.01, 0), (50.0, 1e3, 0)]), 1);
        assert!((p.unwrap().means[0].unwrap().value - 0.1).abs() < 1e-3);
        assert_eq!(Population::of(&observed(&[(0.0, 0.1, 0), (1.0, 0.1, 1), (1.0, 0.1, 1)]), 2), None);
    }

    /// Goal: the textbook's number (Cohen 1988): 64 per group for half a standard deviation; 17 for a whole one.
    #[test]
    fn needed_specimens_are_cohens() {
        assert_eq!(needed(1.0, 0.5), Some(64));
        assert_eq!(needed(1.0, 1.0), Some(17));
        assert_eq!(needed(1.0, 0.0), None);
    }

    /// Goal: 95 % intervals hold the truth in 95 % of made populations, whatever share of the scatter is the specimens' own.
    /// Tolerance: 1000 populations, so 3 standard errors are 2.1 %; the mean's interval is never narrower than the model's, so it
    /// may hold more; the profile's is asymptotic, with some eight degrees of freedom it may hold some per cent less.
    #[test]
    fn intervals_hold_what_was_put_in() {
        const DRAWS: usize = 1000;
        let mut random = ChaCha8Rng::seed_from_u64(20);
        let normal = rand_distr::StandardNormal;
        for (spread, own) in [(0.3, 0.1), (0.2, 0.2), (0.1, 0.3)] {
            let (mut mean, mut difference, mut between) = (0, 0, 0);
            for _ in 0..DRAWS {
                let mut draw = || -> f64 { normal.sample(&mut random) };
                let one = |k: usize| {
                    let group = usize::from(k >= 6);
                    // Specimens are not equally well known.
                    let sigma = own * (0.5 + 0.1 * k as f64);
                    let ln_value = 7.0 + 0.5 * group as f64 + spread * draw() + sigma * draw();
                    Observed { ln_value, sigma, group }
                };
                let specimens: Vec<Observed> = (0..12).map(one).collect();
                let p = Population::of(&specimens, 2).unwrap();
                mean += usize::from(p.means[0].unwrap().contains(7.0));
                difference += usize::from(p.difference(0, 1).unwrap().contains(0.5));
                between += usize::from(p.spread.contains(spread));
            }
            let part = |n: usize| n as f64 / DRAWS as f64;
            println!("spread {spread}, own {own}: {} {} {}", part(mean), part(difference), part(between));
            assert!((0.929..=0.99).contains(&part(mean)), "{spread} {own}: mean {}", part(mean));
            assert!((0.929..=0.99).contains(&part(difference)), "{spread} {own}: {}", part(difference));
            assert!((0.91..=0.995).contains(&part(between)), "{spread} {own}: spread {}", part(between));
        }
    }
}
