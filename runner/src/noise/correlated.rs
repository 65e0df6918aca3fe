//! White and correlated part of a noise that was sampled at arbitrary times.
//!
//! `x(t) = m + n t + c(t) + w`: `m` and the drift `n` unknown, one pair for each record; `c` an Ornstein-Uhlenbeck process, which is AR(1) at
//! equal distances: `cov = sigma_c^2 exp(-|lag| / tau)`; `w` white. The likelihood is exact (Kalman filter, `m`
//! and `n` integrated out), so gaps and unequal distances need no care. Outliers are left out beforehand.

use crate::data::estimate::{Estimate, Quartiles, robust_deviation};
use nalgebra::{Matrix3, Vector3};

/// A stretch of noise: times (s) and values.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Record {
    /// Strictly increasing (s).
    pub time_s: Vec<f64>,
    /// Values, in any unit.
    pub values: Vec<f64>,
}

/// What the noise consists of, in the unit of the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseParts {
    /// Standard deviation of the white part.
    pub white: Estimate,
    /// The correlated part, if there is one beyond doubt.
    pub correlated: Option<Correlated>,
    /// With 95 % confidence the correlated part's standard deviation is below this, at any correlation time
    /// that the records can tell.
    pub correlated_below: f64,
    /// Samples used.
    pub samples: usize,
    /// Samples left out as outliers.
    pub outliers: usize,
}

/// A noise that is remembered for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correlated {
    /// Standard deviation.
    pub amplitude: Estimate,
    /// Time after which 1/e of it is remembered (s).
    pub time_s: Estimate,
}

/// Fewest samples of a record: its mean and its drift take two.
pub const FEWEST_IN_RECORD: usize = 5;
/// Fewest samples in all records that tell anything.
pub const FEWEST_SAMPLES: usize = 20;
/// A sample this many robust deviations from its record's line is an outlier.
const OUTLIER: f64 = 5.0;
/// Twice the gain in log likelihood that two more parameters, one of them a scanned time, reach by chance in
/// less than 1 of 200 cases.
const SIGNIFICANT: f64 = 12.0;
/// Twice the loss in log likelihood at the one-sided 95 % limit.
const LIMIT: f64 = 2.706;
/// Samples of all records that the likelihood looks at: more tell little and take long.
const MOST_SAMPLES: usize = 40_000;
/// Samples of a record that the autocorrelation looks at, in pairs.
const MOST_IN_RECORD: usize = 1500;
/// Fewest pairs of samples that tell a correlation.
const FEWEST_PAIRS: usize = 30;
/// Correlation times tried between the shortest and the longest that the records can tell.
const TIMES: usize = 24;

/// White and correlated part of some records; none if they are too few.
pub fn noise_parts(records: &[Record]) -> Option<NoiseParts> {
    let budget = MOST_SAMPLES / records.len().max(1);
    let records: Vec<Record> = records.iter().map(|r| thinned(r, budget)).collect();
    let cleaned: Vec<Record> =
        records.iter().map(without_outliers).filter(|r| r.values.len() >= FEWEST_IN_RECORD).collect();
    let count = |records: &[Record]| records.iter().map(|r| r.values.len()).sum::<usize>();
    let samples = count(&cleaned);
    let outliers =
        records.iter().filter(|r| r.values.len() >= FEWEST_IN_RECORD).map(|r| r.values.len()).sum::<usize>()
            - samples;
    if samples < FEWEST_SAMPLES {
        return None;
    }
    let likelihood = Likelihood { records: &cleaned, degrees: (samples - 2 * cleaned.len()) as f64 };
    let white = likelihood.at(0.0, 1.0);
    if white.variance <= 0.0 {
        return None;
    }
    let times = times(&cleaned);
    let mut best = (white.twice_log, 0.0, times[0]);
    let mut limit: f64 = 0.0;
    let mut peaks = Vec::with_capacity(times.len());
    for &time in &times {
        let (share, top) = likelihood.best_share(time);
        peaks.push((share, top, time));
        if top > best.0 {
            best = (top, share, time);
        }
    }
    for (share, top, time) in peaks {
        limit = limit.max(likelihood.share_limit(time, share, top));
    }
    let correlated = if best.0 - white.twice_log > SIGNIFICANT {
        Some(likelihood.refined(best.1, best.2).unwrap_or_else(|| likelihood.scanned(best.1, best.2)))
    } else {
        None
    };
    let sigma = white.variance.sqrt();
    let (white, correlated) = match correlated {
        Some((white, correlated)) => (white, Some(correlated)),
        None => (Estimate { value: sigma, sigma: sigma / (2.0 * likelihood.degrees).sqrt() }, None),
    };
    Some(NoiseParts { white, correlated, correlated_below: limit, samples, outliers })
}

/// Not more samples than a budget: half of it in a row for short correlation times, half spread over the rest for
/// long ones.
fn thinned(record: &Record, budget: usize) -> Record {
    let (n, budget) = (record.values.len(), budget.max(2 * FEWEST_IN_RECORD));
    if n <= budget {
        return record.clone();
    }
    let row = budget / 2;
    let stride = (n - row).div_ceil(budget - row);
    let kept = || (0..row).chain((row..n).step_by(stride));
    Record {
        time_s: kept().map(|i| record.time_s[i]).collect(),
        values: kept().map(|i| record.values[i]).collect(),
    }
}

fn without_outliers(record: &Record) -> Record {
    if record.values.len() < 3 {
        return Record::default();
    }
    let rest = without_drift(record);
    let Some(q) = Quartiles::of(&rest) else { return Record::default() };
    // A load cell that shows few different numbers has no robust deviation.
    let reach = match OUTLIER * robust_deviation(&rest) {
        reach if reach > 0.0 => reach,
        _ => f64::INFINITY,
    };
    let points = record.time_s.iter().zip(&record.values).zip(rest);
    let near = points.filter(|(_, r)| (r - q.median).abs() <= reach).map(|((t, v), _)| (*t, *v));
    let (time_s, values) = near.unzip();
    Record { time_s, values }
}

/// From the distance of the closest tenth of the samples to half of the longest record, in equal ratios.
fn times(records: &[Record]) -> Vec<f64> {
    let mut steps: Vec<f64> = records.iter().flat_map(|r| r.time_s.windows(2).map(|w| w[1] - w[0])).collect();
    steps.sort_by(f64::total_cmp);
    let shortest = steps[steps.len() / 10];
    let length = |r: &Record| r.time_s.last().unwrap_or(&0.0) - r.time_s.first().unwrap_or(&0.0);
    let longest = (0.5 * records.iter().map(length).fold(0.0, f64::max)).max(2.0 * shortest);
    (0..TIMES).map(|i| shortest * (longest / shortest).powf(i as f64 / (TIMES - 1) as f64)).collect()
}

struct Likelihood<'a> {
    records: &'a [Record],
    degrees: f64,
}

/// Value of the likelihood, and the total variance that makes it largest.
struct Value {
    twice_log: f64,
    variance: f64,
}

impl Likelihood<'_> {
    /// With the variance free: correlated part's share of it, correlation time (s).
    fn at(&self, share: f64, time_s: f64) -> Value {
        let (mut log_det, mut square) = (0.0, 0.0);
        for record in self.records {
            let (l, s) = filter(record, 1.0 - share, share, time_s);
            log_det += l;
            square += s;
        }
        let variance = square / self.degrees;
        Value { twice_log: -log_det - self.degrees * variance.ln(), variance }
    }

    /// Share at which the likelihood is largest for a correlation time, and that likelihood.
    fn best_share(&self, time_s: f64) -> (f64, f64) {
        // Unimodal in the share for all practical purposes: a coarse scan, then golden section around its best.
        let coarse: Vec<f64> = [0.0, 1e-3, 0.01, 0.03, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 0.95, 0.999].to_vec();
        let values: Vec<f64> = coarse.iter().map(|&s| self.at(s, time_s).twice_log).collect();
        let k = (0..coarse.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
        let (mut a, mut b) = (coarse[k.saturating_sub(1)], coarse[(k + 1).min(coarse.len() - 1)]);
        for _ in 0..12 {
            const GOLDEN: f64 = 0.381_966_011_250_105;
            let (c, d) = (a + GOLDEN * (b - a), b - GOLDEN * (b - a));
            if self.at(c, time_s).twice_log > self.at(d, time_s).twice_log { b = d } else { a = c }
        }
        let middle = 0.5 * (a + b);
        let top = self.at(middle, time_s).twice_log;
        if top > values[k] { (middle, top) } else { (coarse[k], values[k]) }
    }

    /// Standard deviation of the correlated part at the upper limit of its share.
    fn share_limit(&self, time_s: f64, share: f64, top: f64) -> f64 {
        let (mut a, mut b) = (share, 0.9999);
        let loss = |s: f64| top - self.at(s, time_s).twice_log;
        if loss(b) > LIMIT {
            for _ in 0..14 {
                let middle = 0.5 * (a + b);
                if loss(middle) > LIMIT { b = middle } else { a = middle }
            }
        }
        (b * self.at(b, time_s).variance).sqrt()
    }

    /// Minus twice the log likelihood at the logarithms of white and correlated deviation and time.
    fn cost(&self, x: &Vector3<f64>) -> f64 {
        let (white, correlated) = ((2.0 * x[0]).exp(), (2.0 * x[1]).exp());
        let sum = |(l, s): (f64, f64)| l + s;
        self.records.iter().map(|r| sum(filter(r, white, correlated, x[2].exp()))).sum()
    }

    /// What the scan found, where the curvature tells no uncertainty: right to a factor.
    fn scanned(&self, share: f64, time_s: f64) -> (Estimate, Correlated) {
        let variance = self.at(share, time_s).variance;
        let rough = |value: f64| Estimate { value, sigma: value };
        let amplitude = rough((share * variance).sqrt());
        (rough(((1.0 - share) * variance).sqrt()), Correlated { amplitude, time_s: rough(time_s) })
    }

    /// Newton's method from the best of the scan; the curvature there is the uncertainty.
    fn refined(&self, share: f64, time_s: f64) -> Option<(Estimate, Correlated)> {
        let variance = self.at(share, time_s).variance;
        // A share of 0 or 1 has no logarithm.
        let share = share.clamp(1e-3, 0.999);
        let mut x =
            Vector3::new(0.5 * ((1.0 - share) * variance).ln(), 0.5 * (share * variance).ln(), time_s.ln());
        let mut cost = self.cost(&x);
        for _ in 0..25 {
            let (gradient, hessian) = self.derivatives(&x, cost);
            let step = hessian.cholesky().map_or(-0.1 * gradient.normalize(), |c| -c.solve(&gradient));
            let mut scale = (1.0 / step.amax().max(1e-300)).min(1.0);
            let mut moved = false;
            for _ in 0..12 {
                let trial = x + scale * step;
                let value = self.cost(&trial);
                if value < cost {
                    (x, cost, moved) = (trial, value, true);
                    break;
                }
                scale *= 0.5;
            }
            if !moved || scale * step.amax() < 1e-4 {
                break;
            }
        }
        let covariance = (0.5 * self.derivatives(&x, cost).1).try_inverse()?;
        let estimate = |i: usize| {
            let value = x[i].exp();
            Estimate { value, sigma: value * covariance[(i, i)].max(0.0).sqrt() }
        };
        let (white, correlated) = (estimate(0), Correlated { amplitude: estimate(1), time_s: estimate(2) });
        (covariance.diagonal().min() > 0.0).then_some((white, correlated))
    }

    /// Gradient and Hessian of the cost by central differences.
    fn derivatives(&self, x: &Vector3<f64>, cost: f64) -> (Vector3<f64>, Matrix3<f64>) {
        const STEP: f64 = 0.02;
        let shifted = |shifts: &[(usize, f64)]| {
            let mut y = *x;
            for &(i, by) in shifts {
                y[i] += by * STEP;
            }
            self.cost(&y)
        };
        let mut gradient = Vector3::zeros();
        let mut hessian = Matrix3::zeros();
        for i in 0..3 {
            let (up, down) = (shifted(&[(i, 1.0)]), shifted(&[(i, -1.0)]));
            gradient[i] = (up - down) / (2.0 * STEP);
            hessian[(i, i)] = (up - 2.0 * cost + down) / (STEP * STEP);
            for j in 0..i {
                let mixed = shifted(&[(i, 1.0), (j, 1.0)])
                    - shifted(&[(i, 1.0), (j, -1.0)])
                    - shifted(&[(i, -1.0), (j, 1.0)])
                    + shifted(&[(i, -1.0), (j, -1.0)]);
                hessian[(i, j)] = mixed / (4.0 * STEP * STEP);
                hessian[(j, i)] = hessian[(i, j)];
            }
        }
        (gradient, hessian)
    }
}

/// Log determinant and weighted sum of squares of a record, its mean and drift integrated out: Kalman filter of
/// the values and, with the same gains, of the constant 1 and of the time.
fn filter(record: &Record, white: f64, correlated: f64, time_s: f64) -> (f64, f64) {
    let (mut state, mut variance) = ([0.0; 3], correlated);
    let (mut log_det, mut product) = (0.0, [[0.0; 3]; 3]);
    let (start, end) =
        (record.time_s.first().copied().unwrap_or(0.0), record.time_s.last().copied().unwrap_or(0.0));
    let mut before = start;
    // Values relative to the first: the mean may be large.
    let origin = record.values.first().copied().unwrap_or(0.0);
    for (&t, &value) in record.time_s.iter().zip(&record.values) {
        let kept = (-(t - before) / time_s).exp();
        before = t;
        variance = correlated + kept * kept * (variance - correlated);
        let total = variance + white;
        let gain = variance / total;
        // Time from -1 to 1, so that constant and drift hardly mix.
        let measured = [value - origin, 1.0, 2.0 * (t - start) / (end - start) - 1.0];
        let mut innovation = [0.0; 3];
        for k in 0..3 {
            innovation[k] = measured[k] - kept * state[k];
            state[k] = kept * state[k] + gain * innovation[k];
        }
        variance *= 1.0 - gain;
        log_det += total.ln();
        for i in 0..3 {
            for j in 0..=i {
                product[i][j] += innovation[i] * innovation[j] / total;
            }
        }
    }
    let [[yy, ..], [y1, ones, _], [yt, mixed, times]] = product;
    let determinant = ones * times - mixed * mixed;
    let explained = (times * y1 * y1 - 2.0 * mixed * y1 * yt + ones * yt * yt) / determinant;
    (log_det + determinant.ln(), yy - explained)
}

/// Correlation of the records' values against their distance in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Autocorrelation {
    /// Mean distance of the pairs (s).
    pub lag_s: f64,
    /// Mean product over the variance (-).
    pub correlation: f64,
    /// Number of pairs.
    pub pairs: usize,
}

/// In bins of equal ratio of the lag, up to a third of the longest record. Each record counts from its own line;
/// what that takes from independent samples is given back.
pub fn autocorrelation(records: &[Record], bins: usize) -> Vec<Autocorrelation> {
    let thin = |r: &Record| without_outliers(&thinned(r, MOST_IN_RECORD));
    let records: Vec<Record> =
        records.iter().map(thin).filter(|r| r.values.len() >= FEWEST_IN_RECORD).collect();
    if records.is_empty() || bins == 0 {
        return vec![];
    }
    let times = times(&records);
    let (low, high) = (0.7 * times[0], times[times.len() - 1] * (2.0 / 3.0));
    let mut sums = vec![(0.0, 0.0, 0.0, 0_usize); bins];
    let (mut square, mut count) = (0.0, 0.0);
    for r in &records {
        let x = without_drift(r);
        square += x.iter().map(|v| v * v).sum::<f64>();
        count += x.len() as f64 - 2.0;
        let n = x.len() as f64;
        let mean = r.time_s.iter().sum::<f64>() / n;
        let spread: f64 = r.time_s.iter().map(|t| (t - mean).powi(2)).sum();
        for i in 0..x.len() {
            for j in i + 1..x.len() {
                let lag = r.time_s[j] - r.time_s[i];
                if lag >= high {
                    break;
                }
                let bin = ((lag / low).ln() / (high / low).ln() * bins as f64).floor();
                if let Some(sum) = (bin >= 0.0).then(|| sums.get_mut(bin as usize)).flatten() {
                    // Minus this times the variance is the mean product of independent samples about their line.
                    let taken = 1.0 / n + (r.time_s[i] - mean) * (r.time_s[j] - mean) / spread;
                    *sum = (sum.0 + lag, sum.1 + x[i] * x[j], sum.2 + taken, sum.3 + 1);
                }
            }
        }
    }
    let variance = square / count;
    let mean = |(lag, product, taken, n): &(f64, f64, f64, usize)| Autocorrelation {
        lag_s: lag / *n as f64,
        correlation: (product / variance + taken) / *n as f64,
        pairs: *n,
    };
    sums.iter().filter(|s| s.3 >= FEWEST_PAIRS).map(mean).collect()
}

/// Values from the straight line through them.
fn without_drift(record: &Record) -> Vec<f64> {
    let n = record.values.len() as f64;
    let (t0, x0) = (record.time_s.iter().sum::<f64>() / n, record.values.iter().sum::<f64>() / n);
    let square: f64 = record.time_s.iter().map(|t| (t - t0).powi(2)).sum();
    let points = || record.time_s.iter().zip(&record.values);
    let slope = points().map(|(t, x)| (t - t0) * (x - x0)).sum::<f64>() / square;
    points().map(|(t, x)| x - x0 - slope * (t - t0)).collect()
}

#[cfg(test)]
#[path = "correlated_tests.rs"]
mod tests;
