//! One file per specimen, made into one measurement on common times.
//!
//! Each specimen was started by hand: its clock is shifted. The loading ramps are the same in all, so the line
//! through a ramp tells the shift, to far less than the distance of two samples.

use super::cycle::{Cycle, cycles};
use super::error::{DataError, Problem};
use super::estimate::{Estimate, Quartiles};
use super::measurement::{Measurement, interpolated, median};

/// Ramps of specimens whose rates or depths differ by more than this part are not the same ramp.
const SAME_RAMP: f64 = 0.1;
/// Fewest points that are worth calling a common curve.
const FEWEST_POINTS: usize = 5;
/// So many samples of the ramp tell the force at its end, where a specimen has no sample.
const KINK_SAMPLES: usize = 4;

/// Specimens on common times.
#[derive(Debug, Clone, PartialEq)]
pub struct Synchronised {
    /// The median with its specimens, at the times of the first specimen.
    pub measurement: Measurement,
    /// The files as they were read, when there are several: resampling has changed their noise.
    pub originals: Vec<Measurement>,
    /// What was added to each file's clock (s); empty for a single file.
    pub shifts_s: Vec<Estimate>,
}

/// Puts the specimens of a test onto the clock and the times of the first.
///
/// # Errors
/// When one has no ramp, its ramp is another one, or no common time is left.
pub fn synchronise(name: &str, specimens: Vec<Measurement>) -> Result<Synchronised, DataError> {
    if specimens.len() < 2 {
        let measurement = specimens.into_iter().next().unwrap_or_default();
        return Ok(Synchronised { measurement, originals: vec![], shifts_s: vec![] });
    }
    let all: Vec<Vec<Cycle>> = specimens.iter().map(cycles).collect::<Result<_, _>>()?;
    let mut shifts_s = Vec::with_capacity(specimens.len());
    let mut notes = Vec::new();
    for (m, own) in specimens.iter().zip(&all) {
        let shift = shift(&specimens[0], &all[0], m, own)?;
        let clock = shift.per_cycle.iter().map(|s| (s - shift.median.value).abs()).fold(0.0, f64::max);
        let within = 5.0 * shift.median.sigma + 0.01 * (own[0].times.ramp_end_s - own[0].times.ramp_start_s);
        if clock > within {
            notes.push(format!(
                "the ramps of {} need shifts that differ by up to {clock:.3} s from cycle to cycle: its dwell \
                 times or its clock differ",
                m.file.display()
            ));
        }
        shifts_s.push(shift.median);
    }
    let curves: Vec<Curve> =
        specimens.iter().zip(&all).zip(&shifts_s).map(|((m, c), s)| Curve::new(m, c, s.value)).collect();
    let measurement = resampled(name, &specimens, &curves, &shifts_s, notes)?;
    Ok(Synchronised { measurement, originals: specimens, shifts_s })
}

struct Shift {
    median: Estimate,
    per_cycle: Vec<f64>,
}

/// What must be added to a specimen's times to put its ramps onto those of the first.
fn shift(
    first: &Measurement,
    reference: &[Cycle],
    m: &Measurement,
    own: &[Cycle],
) -> Result<Shift, DataError> {
    let from =
        |c: &Cycle, m: &Measurement| m.displacement_m.first().copied().unwrap_or(0.0).clamp(0.0, c.depth_m);
    let (a, b) = (&reference[0], &own[0]);
    let same = |x: f64, y: f64| (x - y).abs() <= SAME_RAMP * x.abs();
    let overlap = (from(a, first).max(from(b, m)), a.depth_m.min(b.depth_m));
    if !same(a.ramp.rate_m_per_s, b.ramp.rate_m_per_s)
        || !same(a.depth_m, b.depth_m)
        || overlap.0 >= overlap.1
    {
        return Err(m.error(Problem::RampsDiffer {
            first: first.file.display().to_string(),
            rate_mm_s: b.ramp.rate_m_per_s * 1e3,
            from_mm: from(b, m) * 1e3,
            to_mm: b.depth_m * 1e3,
            first_rate_mm_s: a.ramp.rate_m_per_s * 1e3,
            first_from_mm: from(a, first) * 1e3,
            first_to_mm: a.depth_m * 1e3,
        }));
    }
    // The middle of the common part: there a line knows its time best, and the kinks do not matter.
    let level = 0.5 * (overlap.0 + overlap.1);
    let pairs = || reference.iter().zip(own).map(|(a, b)| (&a.ramp, &b.ramp));
    let per_cycle: Vec<f64> = pairs().map(|(a, b)| a.time_at(level) - b.time_at(level)).collect();
    let sigmas = pairs().map(|(a, b)| a.time_sigma_at(level).hypot(b.time_sigma_at(level)));
    // Of a median of n equally good ones.
    let sigma = sigmas.fold(0.0, f64::max) * (if per_cycle.len() > 2 { 1.2533 } else { 1.0 })
        / (per_cycle.len() as f64).sqrt();
    let value = median(&mut per_cycle.clone());
    Ok(Shift { median: Estimate { value, sigma }, per_cycle })
}

/// A specimen on the common clock, with points at the kinks of its motion.
struct Curve {
    time_s: Vec<f64>,
    force_n: Vec<f64>,
    displacement_m: Vec<f64>,
}

impl Curve {
    fn new(m: &Measurement, cycles: &[Cycle], shift_s: f64) -> Self {
        let mut points: Vec<(f64, f64, f64)> =
            (0..m.len()).map(|i| (m.time_s[i], m.displacement_m[i], m.force_n[i])).collect();
        // Force falls at once when the ramp ends: interpolation across the kink would cut the peak off.
        let kinks: Vec<_> = cycles.iter().filter_map(|c| at_ramp_end(m, c)).collect();
        points.extend(kinks);
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self {
            time_s: points.iter().map(|p| p.0 + shift_s).collect(),
            displacement_m: points.iter().map(|p| p.1).collect(),
            force_n: points.iter().map(|p| p.2).collect(),
        }
    }

    fn span(&self) -> (f64, f64) {
        (self.time_s.first().copied().unwrap_or(0.0), self.time_s.last().copied().unwrap_or(0.0))
    }
}

/// Time, displacement and force at the end of a ramp, from the line through its last samples; none where a
/// sample is there already, or the ramp has too few.
fn at_ramp_end(m: &Measurement, cycle: &Cycle) -> Option<(f64, f64, f64)> {
    let ramp = cycle.points(&m.time_s, cycle.times.ramp_start_s, cycle.times.ramp_end_s);
    let last = ramp.end.checked_sub(1)?;
    let (step, gap) =
        (m.time_s[last] - m.time_s[last.checked_sub(1)?], cycle.times.ramp_end_s - m.time_s[last]);
    if ramp.len() < KINK_SAMPLES + 1 || gap < 0.05 * step || gap > 1.5 * step {
        return None;
    }
    let tail = ramp.end - KINK_SAMPLES..ramp.end;
    let n = tail.len() as f64;
    let (t0, f0) =
        (m.time_s[tail.clone()].iter().sum::<f64>() / n, m.force_n[tail.clone()].iter().sum::<f64>() / n);
    let square: f64 = tail.clone().map(|i| (m.time_s[i] - t0).powi(2)).sum();
    let slope = tail.map(|i| (m.time_s[i] - t0) * (m.force_n[i] - f0)).sum::<f64>() / square;
    Some((cycle.times.ramp_end_s, cycle.depth_m, f0 + slope * (cycle.times.ramp_end_s - t0)))
}

fn resampled(
    name: &str,
    specimens: &[Measurement],
    curves: &[Curve],
    shifts_s: &[Estimate],
    mut notes: Vec<String>,
) -> Result<Measurement, DataError> {
    let start = curves.iter().map(|c| c.span().0).fold(f64::NEG_INFINITY, f64::max);
    let end = curves.iter().map(|c| c.span().1).fold(f64::INFINITY, f64::min);
    let first = &specimens[0];
    let time_s: Vec<f64> = first.time_s.iter().copied().filter(|t| (start..=end).contains(t)).collect();
    if time_s.len() < FEWEST_POINTS {
        let shortest = curves.iter().zip(specimens).min_by(|a, b| {
            let length = |c: &Curve| c.span().1 - c.span().0;
            length(a.0).total_cmp(&length(b.0))
        });
        let first = first.file.display().to_string();
        return Err(shortest
            .map_or(&specimens[0], |s| s.1)
            .error(Problem::NoCommonTime { first, points: time_s.len() }));
    }
    let on_grid = |values: fn(&Curve) -> &[f64]| -> Vec<Vec<f64>> {
        curves
            .iter()
            .map(|c| {
                time_s.iter().map(|&t| interpolated(&c.time_s, values(c), t).unwrap_or(f64::NAN)).collect()
            })
            .collect()
    };
    let displacements = on_grid(|c| &c.displacement_m);
    let median_at = |i: usize| {
        Quartiles::of(&displacements.iter().map(|d| d[i]).collect::<Vec<_>>()).map_or(0.0, |q| q.median)
    };
    let range =
        |v: &mut dyn Iterator<Item = f64>| v.fold((0.0_f64, 0.0_f64), |r, x| (r.0.min(x), r.1.max(x)));
    let (low, high) = range(&mut shifts_s.iter().map(|s| s.value));
    notes.insert(
        0,
        format!(
            "{} files put onto the clock and times of {} by their ramps (shifts {low:.4} to {high:.4} s)",
            specimens.len(),
            first.file.display()
        ),
    );
    for m in specimens {
        notes.extend(m.notes.iter().map(|note| format!("{}: {note}", m.file.display())));
    }
    let mut comments: Vec<String> = Vec::new();
    for comment in specimens.iter().flat_map(|m| &m.comments) {
        if !comments.contains(comment) {
            comments.push(comment.clone());
        }
    }
    let mut measurement = Measurement {
        name: name.to_owned(),
        file: first.file.parent().map_or_else(|| first.file.clone(), ToOwned::to_owned),
        comments,
        notes,
        displacement_m: (0..time_s.len()).map(median_at).collect(),
        specimens_n: on_grid(|c| &c.force_n),
        specimen_names: specimens.iter().map(|m| m.name.clone()).collect(),
        time_s,
        ..Measurement::default()
    };
    measurement.summarise_specimens();
    Ok(measurement)
}

#[cfg(test)]
#[path = "synchronise_tests.rs"]
mod tests;
