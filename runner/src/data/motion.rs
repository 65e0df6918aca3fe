//! Strokes and rests of the punch, from samples of its displacement alone.
//!
//! The samples may be noisy and their distances unequal. A polyline through them (Ramer, Douglas, Peucker)
//! with a tolerance above the noise tells moving from resting; a line through the middle of each stroke,
//! extended to the rests beside it, tells when the stroke began and ended to a fraction of a sample.

use super::estimate::{Quartiles, deviation_of_sizes};
use super::history::corners;
use super::neighbours::{FEWEST, distances};

/// A piece slower than this part of the fastest stroke is rest: an actuator that settles is not moving.
const REST: f64 = 0.02;
/// A movement smaller than this part of the depth is not a stroke: overshoot, settling, creep of the actuator.
const STROKE: f64 = 0.05;
/// Samples within this many standard deviations of the noise lie on a line.
const NOISE_REACH: f64 = 5.0;
/// ... or within this part of the depth.
const LEAST_TOLERANCE: f64 = 2e-3;

/// Neighbours that differ by more than this part of the largest displacement are kinks: no stage is that noisy.
const LARGEST_NOISE: f64 = 0.02;
/// So many samples of a rest tell its level beside a stroke: an actuator may creep over a long rest.
const NEAR: usize = 25;

/// What the punch does, as strokes with rests (of any length, also none) between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Standard deviation of the noise of a displacement sample (m).
    pub noise_m: f64,
    /// Movements in the order of time.
    pub strokes: Vec<Stroke>,
}

/// A movement in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Last sample before it.
    pub first: usize,
    /// First sample after it.
    pub last: usize,
    /// Time at which it begins (s).
    pub start_s: f64,
    /// Time at which it ends (s).
    pub end_s: f64,
    /// Displacement at its beginning (m).
    pub from_m: f64,
    /// Displacement at its end (m).
    pub to_m: f64,
    /// Line through its middle.
    pub line: Line,
}

impl Stroke {
    /// Whether it goes into the sample.
    pub fn is_inwards(&self) -> bool {
        self.to_m > self.from_m
    }
}

/// A straight line `mid + rate (t - mid_time)` through samples of the displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Slope (m/s).
    pub rate_m_per_s: f64,
    /// Standard deviation of the slope (m/s).
    pub rate_sigma_m_per_s: f64,
    /// Mean time of the samples (s).
    pub mid_time_s: f64,
    /// Displacement at that time (m).
    pub mid_m: f64,
    /// Standard deviation of that displacement (m).
    pub mid_sigma_m: f64,
    /// Number of samples.
    pub samples: usize,
}

impl Line {
    /// Displacement at a time (m).
    pub fn at(&self, time_s: f64) -> f64 {
        self.mid_m + self.rate_m_per_s * (time_s - self.mid_time_s)
    }

    /// Time at which the line reaches a displacement (s).
    pub fn time_at(&self, displacement_m: f64) -> f64 {
        self.mid_time_s + (displacement_m - self.mid_m) / self.rate_m_per_s
    }

    /// Standard deviation of [`Self::time_at`] (s).
    pub fn time_sigma_at(&self, displacement_m: f64) -> f64 {
        let away = self.time_at(displacement_m) - self.mid_time_s;
        self.mid_sigma_m.hypot(away * self.rate_sigma_m_per_s) / self.rate_m_per_s.abs()
    }

    /// Least squares; `noise_m` is the standard deviation of a sample.
    fn through(points: &[(f64, f64)], noise_m: f64) -> Self {
        let n = points.len() as f64;
        let (mid_time_s, mid_m) =
            (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
        let square: f64 = points.iter().map(|p| (p.0 - mid_time_s).powi(2)).sum();
        let product: f64 = points.iter().map(|p| (p.0 - mid_time_s) * (p.1 - mid_m)).sum();
        Self {
            rate_m_per_s: product / square,
            rate_sigma_m_per_s: noise_m / square.sqrt(),
            mid_time_s,
            mid_m,
            mid_sigma_m: noise_m / n.sqrt(),
            samples: points.len(),
        }
    }
}

/// Standard deviation of the noise that makes these distances to neighbours, of at least `fewest` samples. A median, so that
/// kinks do not count.
fn noise_of(distances: &[f64], fewest: usize) -> f64 {
    let mut sizes: Vec<f64> = distances.iter().map(|d| d.abs()).collect();
    if sizes.len() < fewest { 0.0 } else { deviation_of_sizes(&mut sizes) }
}

/// The same of a path (m): where most samples are kinks, as in one given by its corners, there is none.
pub(super) fn path_noise_of(distances: &[f64], fewest: usize, reach_m: f64) -> f64 {
    Some(noise_of(distances, fewest)).filter(|noise| *noise <= LARGEST_NOISE * reach_m).unwrap_or(0.0)
}

/// Distances of samples to the line through their neighbours.
pub(super) fn distances_to_neighbours(points: &[(f64, f64)]) -> Vec<f64> {
    let (times, values): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
    distances(&times, &values).collect()
}

/// Largest displacement of a path (m).
pub(super) fn reach_of(path: &[(f64, f64)]) -> f64 {
    path.iter().fold(0.0_f64, |r, p| r.max(p.1.abs()))
}

/// Standard deviation of the noise of samples of a smooth curve: how far each sample is from the line between
/// its neighbours.
pub fn sample_noise(points: &[(f64, f64)]) -> f64 {
    noise_of(&distances_to_neighbours(points), FEWEST)
}

/// Strokes of a displacement history.
pub fn motion(time_s: &[f64], displacement_m: &[f64]) -> Motion {
    let points: Vec<(f64, f64)> = time_s.iter().copied().zip(displacement_m.iter().copied()).collect();
    let noise_m = path_noise_of(&distances_to_neighbours(&points), FEWEST, reach_of(&points));
    if points.len() < 2 {
        return Motion { noise_m, strokes: vec![] };
    }
    let depth = displacement_m.iter().copied().fold(0.0, f64::max);
    let least_stroke = (STROKE * depth).max(2.0 * NOISE_REACH * noise_m);
    let tolerance_m = (NOISE_REACH * noise_m).max(LEAST_TOLERANCE * depth);
    let corners = corners(&points, |_| tolerance_m);
    let runs = runs(&points, &corners, least_stroke);
    let tolerance_m = ((NOISE_REACH + 1.0) * noise_m).max(2.0 * LEAST_TOLERANCE * depth);
    let strokes = (0..runs.len()).map(|k| stroke(&points, &runs, k, noise_m, tolerance_m)).collect();
    Motion { noise_m, strokes }
}

/// Samples between which the punch moves in one direction; what lies between the runs is rest.
fn runs(points: &[(f64, f64)], corners: &[usize], least_stroke: f64) -> Vec<(usize, usize)> {
    let pieces = || corners.windows(2).map(|w| (w[0], w[1], points[w[1]].1 - points[w[0]].1));
    let speed = |(a, b, change): (usize, usize, f64)| (change / (points[b].0 - points[a].0)).abs();
    let fastest = pieces().filter(|p| p.2.abs() >= least_stroke).map(speed).fold(0.0, f64::max);
    let mut runs: Vec<(usize, usize)> = Vec::new();
    let change = |run: &(usize, usize)| points[run.1].1 - points[run.0].1;
    for piece in pieces() {
        if piece.2.abs() < least_stroke && speed(piece) <= REST * fastest {
            continue;
        }
        match runs.last_mut() {
            Some(run) if run.1 == piece.0 && change(run) * piece.2 > 0.0 => run.1 = piece.1,
            _ => runs.push((piece.0, piece.1)),
        }
    }
    runs.retain(|run| change(run).abs() >= least_stroke);
    runs
}

fn stroke(
    points: &[(f64, f64)],
    runs: &[(usize, usize)],
    k: usize,
    noise_m: f64,
    tolerance_m: f64,
) -> Stroke {
    let (first, last) = runs[k];
    // The surface bounds the part that matters; the whole stroke is longer and knows its own ends better.
    let line = middle_line(points, (first, last), 0.0, noise_m);
    let whole = middle_line(points, (first, last), f64::NEG_INFINITY, noise_m);
    let kink = |corner: usize, rest: &[(f64, f64)]| {
        let values: Vec<f64> = rest.iter().map(|p| p.1).collect();
        let level = Quartiles::of(&values).filter(|q| q.count >= 3).map(|q| q.median);
        // Where two strokes meet without a rest, the corner itself is the best that is known.
        let Some(level) = level else { return points[corner] };
        let straight = [whole, line].into_iter().find(|l| {
            let at = points.partition_point(|p| p.0 < l.mid_time_s);
            let beyond = if at > corner { corner.saturating_sub(3) } else { corner + 3 };
            let near = &points[at.min(beyond)..=at.max(beyond).min(points.len() - 1)];
            near.iter().all(|p| is_on_hinge(*p, l, level, tolerance_m))
        });
        (straight.map_or(points[corner].0, |l| l.time_at(level)), level)
    };
    let rest_start = if k == 0 { 0 } else { runs[k - 1].1 };
    let rest_end = runs.get(k + 1).map_or(points.len() - 1, |r| r.0);
    let before = &points[rest_start.max(first.saturating_sub(NEAR))..=first];
    let after = &points[last..=rest_end.min(last + NEAR)];
    let ((start_s, from_m), (end_s, to_m)) = (kink(first, before), kink(last, after));
    Stroke { first, last, start_s, end_s, from_m, to_m, line }
}

/// Whether a sample lies on a stroke's line up to a level, and on that level beyond it.
fn is_on_hinge(point: (f64, f64), line: &Line, level_m: f64, tolerance_m: f64) -> bool {
    let kink_s = line.time_at(level_m);
    let in_stroke = (point.0 < kink_s) == (line.mid_time_s < kink_s);
    let on_line = line.at(point.0);
    (point.1 - if in_stroke { on_line } else { level_m }).abs() <= tolerance_m
}

/// Line through the middle 80 % of that part of a stroke which lies above `floor_m` (of all, if none does).
fn middle_line(points: &[(f64, f64)], (first, last): (usize, usize), floor_m: f64, noise_m: f64) -> Line {
    let (a, b) = (points[first].1, points[last].1);
    let (low, high) = (a.min(b), a.max(b));
    let low = if high > floor_m { low.max(floor_m) } else { low };
    let margin = 0.1 * (high - low);
    let inside = |p: &&(f64, f64)| (low + margin..=high - margin).contains(&p.1);
    let middle: Vec<(f64, f64)> = points[first..=last].iter().filter(inside).copied().collect();
    if middle.len() >= 3 {
        return Line::through(&middle, noise_m);
    }
    Line::through(&[points[first], points[last]], noise_m)
}

#[cfg(test)]
#[path = "motion_tests.rs"]
mod tests;
