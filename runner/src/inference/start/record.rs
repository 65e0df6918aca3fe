//! What a start is read from: the first loading and hold of a test, thinned to some hundred rows of equal worth.

use super::prony::{self, Series};
use super::relaxation::History;
use super::rig::{Law, Rig};
use crate::data::measurement::median;
use crate::data::motion::sample_noise;
use crate::data::{Measurement, cycles, protocol_of};

/// Rows of the ramp.
const RAMP_ROWS: usize = 40;
/// Rows per decade of time since the end of the ramp.
const HOLD_ROWS: f64 = 12.0;
/// What the closed forms leave out at finite strain: as a part of the force in the ramp, where it grows with the depth,
const RAMP_FORM: f64 = 0.1;
/// and in the hold, where Ogden's branches do not relax exponentially (alpha of -3 to -13, a depth of half a radius: 10 % of a
/// branch's force seems to relax in a quarter of its time),
const HOLD_FORM: f64 = 2e-2;
/// and of the peak everywhere: the surface is not known exactly.
const PEAK_FORM: f64 = 2e-3;
/// Samples at the end of the ramp that tell the sampling interval.
const NEAR_PEAK: usize = 10;

/// The rows of one test.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Corners of the motion: times (s) and depths (m).
    pub path: Vec<(f64, f64)>,
    /// Times (s).
    pub time_s: Vec<f64>,
    /// Mean forces (N).
    pub force_n: Vec<f64>,
    /// Their deviations (N), with what the closed form leaves out.
    pub sigma_n: Vec<f64>,
    /// How many of them lie in the ramp.
    pub ramp_rows: usize,
    /// Duration of the ramp in the sample (s).
    pub ramp_s: f64,
    /// Depth of the hold (m).
    pub depth_m: f64,
    /// Shortest and longest relaxation time that it can show (s).
    pub times_s: (f64, f64),
}

impl Record {
    /// The rows of a measurement; none where no force rises.
    pub fn of(m: &Measurement) -> Option<Self> {
        let cycle = cycles(m).ok()?.into_iter().next()?;
        let path = protocol_of(m).ok()?.points().to_vec();
        let (start, peak, end) = (cycle.times.ramp_start_s, cycle.times.ramp_end_s, cycle.times.hold_end_s);
        let first = m.time_s.partition_point(|t| *t <= start);
        let last = m.time_s.partition_point(|t| *t <= end);
        let top = m.time_s.partition_point(|t| *t <= peak).clamp(first, last);
        let largest = m.force_n.get(first..last)?.iter().copied().fold(0.0, f64::max);
        if largest <= 0.0 || peak <= start {
            return None;
        }
        let near = &m.time_s[top.saturating_sub(NEAR_PEAK).max(first)..(top + NEAR_PEAK).min(last)];
        let mut steps: Vec<f64> = near.windows(2).map(|w| w[1] - w[0]).collect();
        let interval = if steps.is_empty() { peak - start } else { median(&mut steps) };
        let noise_n = force_noise(m);
        let mut record = Self {
            path,
            time_s: Vec::new(),
            force_n: Vec::new(),
            sigma_n: Vec::new(),
            ramp_rows: 0,
            ramp_s: peak - start,
            depth_m: cycle.depth_m,
            times_s: shown(interval, end - peak),
        };
        let row = |t: f64| match t - peak {
            since if since <= 0.0 => (0, (RAMP_ROWS as f64 * (t - start) / (peak - start)) as i64),
            since => (1, (HOLD_ROWS * (since / interval).max(1e-3).log10()).floor() as i64),
        };
        let mut from = first;
        while from < last {
            let this = row(m.time_s[from]);
            let next = (from..last).find(|&i| row(m.time_s[i]) != this).unwrap_or(last);
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            let force = mean(&m.force_n[from..next]);
            let form = if this.0 == 0 { RAMP_FORM } else { HOLD_FORM };
            let white = noise_n / ((next - from) as f64).sqrt();
            record.ramp_rows += usize::from(this.0 == 0);
            record.time_s.push(mean(&m.time_s[from..next]));
            record.force_n.push(force);
            record.sigma_n.push((form * force).hypot(PEAK_FORM * largest).hypot(white));
            from = next;
        }
        Some(record)
    }

    /// Its weighted forces, and the weighted columns of the equilibrium and of each relaxation time.
    pub fn system(&self, law: &Law, grid_s: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let history = History::new(&self.path, law, &self.time_s);
        let weighted =
            |column: Vec<f64>| column.iter().zip(&self.sigma_n).map(|(x, s)| x / s).collect::<Vec<f64>>();
        let mut columns = vec![weighted(history.elastic())];
        columns.extend(grid_s.iter().map(|tau| weighted(history.relaxed(*tau))));
        (weighted(self.force_n.clone()), columns)
    }

    /// The rows with deviations that account for what a series leaves unexplained of ramp and hold, each as a whole: a contact
    /// point, a lag or a large strain that spoil the ramp say nothing against the hold.
    #[must_use]
    pub fn widened(mut self, law: &Law, series: &Series) -> Self {
        let history = History::new(&self.path, law, &self.time_s);
        let mut model: Vec<f64> = history.elastic().iter().map(|f| f * series.equilibrium_pa).collect();
        for (tau, shear) in &series.branches {
            model.iter_mut().zip(history.relaxed(*tau)).for_each(|(f, r)| *f += shear * r);
        }
        for rows in [0..self.ramp_rows, self.ramp_rows..self.time_s.len()] {
            let misfits = rows.clone().map(|k| ((self.force_n[k] - model[k]) / self.sigma_n[k]).powi(2));
            let factor = (misfits.sum::<f64>() / rows.len().max(1) as f64).sqrt().max(1.0);
            self.sigma_n[rows].iter_mut().for_each(|sigma| *sigma *= factor);
        }
        self
    }

    /// The force law of a rig over its depths.
    pub fn law(&self, rig: &Rig) -> Law {
        rig.law(self.path.iter().fold(self.depth_m, |d, p| d.max(p.1)))
    }
}

/// Relaxation times between half a sampling interval and three holds; from a millisecond to a day.
fn shown(interval_s: f64, hold_s: f64) -> (f64, f64) {
    const SHORTEST: f64 = 1e-3;
    const LONGEST: f64 = 86_400.0;
    let shortest = (0.5 * interval_s).clamp(SHORTEST, 0.1 * LONGEST);
    (shortest, (3.0 * hold_s).min(LONGEST).max(10.0 * shortest))
}

/// Noise of a sample (N): from neighbouring differences, but not less than rounding leaves.
fn force_noise(m: &Measurement) -> f64 {
    let points: Vec<(f64, f64)> = m.time_s.iter().copied().zip(m.force_n.iter().copied()).collect();
    let mut values = m.force_n.clone();
    values.sort_by(f64::total_cmp);
    let steps = values.windows(2).map(|w| w[1] - w[0]).filter(|step| *step > 0.0);
    let rounding = steps.fold(f64::INFINITY, f64::min) / 12f64.sqrt();
    let rounding = if rounding.is_finite() { rounding } else { 0.0 };
    sample_noise(&points).max(rounding)
}

/// The grid of relaxation times that any of the records shows (s).
pub fn grid(records: &[Record]) -> Vec<f64> {
    let shortest = records.iter().map(|r| r.times_s.0).fold(f64::INFINITY, f64::min);
    let longest = records.iter().map(|r| r.times_s.1).fold(0.0, f64::max);
    prony::grid(shortest, longest)
}
