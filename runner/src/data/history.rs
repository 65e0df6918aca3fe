//! The punch's motion in a measurement, as the few straight pieces that it is within its own noise.
//!
//! Sampled displacements are rounded, step with an encoder and carry noise. Joining every sample would give the model another
//! velocity in each interval, and the cost of a run would grow with the number of samples. So samples that lie on one line within
//! their noise become one piece (Ramer, Douglas, Peucker); kinks are put where the lines through two pieces meet, which is between
//! two samples as a rule; and the levels of all kinks follow by least squares.

use super::measurement::Measurement;
use super::motion::{distances_to_neighbours, path_noise_of, reach_of};
use poropunch::motion::protocol::{Protocol, ProtocolError};

/// Samples closer to a line than this part of the largest excursion lie on it.
const RELATIVE_TOLERANCE: f64 = 1e-4;
/// Samples within this many standard deviations of the noise lie on a line: of some thousand samples, all do.
const NOISE_REACH: f64 = 6.0;
/// Noise is told from so many samples to either side.
const NEAR: usize = 25;
/// Twice the tolerance that leaves less than half the pieces is within the noise: a smooth curve keeps 70 %, steps of an encoder or
/// slow noise, which neighbouring samples do not show, next to none.
const NOISE_LEAVES: f64 = 0.5;
/// ... up to this part of the largest excursion.
const LARGEST_TOLERANCE: f64 = 1e-2;
/// A polyline of more knots is a curve, in which no single knot is superfluous.
const MOST_TO_PRUNE: usize = 60;
/// Samples of a piece that a line through it needs.
const LINE: usize = 6;

type Point = (f64, f64);

/// Piecewise linear displacement history of a measurement.
///
/// # Errors
/// When the times do not increase (a [`Measurement`] that was read from a file has been checked).
pub fn protocol_of(m: &Measurement) -> Result<Protocol, ProtocolError> {
    let points: Vec<Point> = m.time_s.iter().copied().zip(m.displacement_m.iter().copied()).collect();
    straight_pieces(&points)
}

/// Fewest straight pieces through samples (time (s), displacement (m)) within their noise.
///
/// # Errors
/// When a sample is no number, or the times do not increase.
pub fn straight_pieces(points: &[(f64, f64)]) -> Result<Protocol, ProtocolError> {
    Protocol::new(points.to_vec())?;
    Protocol::new(reduced(points))
}

/// Fewest straight pieces within the noise.
fn reduced(points: &[Point]) -> Vec<Point> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let reach = reach_of(points);
    let mut tolerance = tolerances(points, RELATIVE_TOLERANCE * reach);
    let mut found = corners(points, |i| tolerance[i]);
    while tolerance.iter().copied().fold(f64::INFINITY, f64::min) < LARGEST_TOLERANCE * reach {
        let wider: Vec<f64> = tolerance.iter().map(|t| 2.0 * t).collect();
        let fewer = corners(points, |i| wider[i]);
        if (fewer.len() - 1) as f64 > NOISE_LEAVES * (found.len() - 1) as f64 {
            break;
        }
        (tolerance, found) = (wider, fewer);
    }
    let samples: Vec<Point> = found.iter().map(|k| points[*k]).collect();
    let fitted = |knots: &[Point], reach: f64| {
        let knots = levelled(points, &tolerance, meeting(points, &tolerance, knots));
        let fits = |(p, t): (&Point, &f64)| (p.1 - level_at(&knots, p.0)).abs() <= reach * t;
        points.iter().zip(&tolerance).all(fits).then_some(knots)
    };
    // The corners are samples, each with its noise: a better polyline may miss a sample by that much more.
    let mut knots = fitted(&samples, 2.0).map_or(samples, |knots| pruned(knots, |fewer| fitted(fewer, 1.0)));
    // What starts at or above the surface does not start in the sample.
    knots[0].1 = knots[0].1.min(points[0].1.max(0.0));
    knots
}

/// How far from a line each sample may lie (m): noise from its neighbours, rounding, and at least `least`.
fn tolerances(points: &[Point], least: f64) -> Vec<f64> {
    let mut levels: Vec<f64> = points.iter().map(|p| p.1).collect();
    levels.sort_by(f64::total_cmp);
    let rounding = levels.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
    let rounding = if rounding < LARGEST_TOLERANCE * levels[levels.len() - 1].abs() { rounding } else { 0.0 };
    let (distances, reach) = (distances_to_neighbours(points), reach_of(points));
    // Everywhere at least what most samples have: so few neighbours do not tell the noise better than that.
    let usual = path_noise_of(&distances, NEAR, reach);
    let near = |i: usize| {
        let around =
            &distances[i.saturating_sub(NEAR + 1).min(distances.len() - 1)..(i + NEAR).min(distances.len())];
        if around.len() < NEAR { 0.0 } else { path_noise_of(around, NEAR, reach).max(usual) }
    };
    (0..points.len()).map(|i| (NOISE_REACH * near(i) + rounding).max(least)).collect()
}

/// Ramer, Douglas and Peucker: the farthest sample, measured by its tolerance, becomes a corner until none is too far. First and
/// last sample (there must be one) are corners.
pub(super) fn corners(points: &[Point], tolerance: impl Fn(usize) -> f64) -> Vec<usize> {
    let last = points.len() - 1;
    let mut corners = vec![0];
    // A stack instead of recursion: six cycles of noisy samples may be deep.
    let mut pending = vec![(0, last)];
    while let Some((a, b)) = pending.pop() {
        let farthest = (a + 1..b)
            .map(|i| (i, (points[i].1 - on_line(points[a], points[b], points[i].0)).abs() / tolerance(i)))
            .max_by(|x, y| x.1.total_cmp(&y.1));
        if let Some((i, distance)) = farthest
            && distance > 1.0
        {
            corners.push(i);
            pending.extend([(a, i), (i, b)]);
        }
    }
    corners.push(last);
    corners.sort_unstable();
    corners
}

/// The corners with every kink where the lines through the middle of the pieces beside it meet, if that is near.
fn meeting(points: &[Point], tolerance: &[f64], corners: &[Point]) -> Vec<Point> {
    let inside = |a: f64, b: f64| {
        let first = points.partition_point(|p| p.0 < a);
        &points[first..points.partition_point(|p| p.0 <= b).max(first)]
    };
    let lines: Vec<Option<(f64, f64, f64)>> =
        corners.windows(2).map(|w| middle_line(inside(w[0].0, w[1].0))).collect();
    let mut knots = corners.to_vec();
    let mut k = 1;
    while k + 1 < corners.len() {
        // A kink between two samples, or in noise, leaves a piece too short for a line.
        let short = lines[k].is_none() && k + 2 < corners.len();
        let after = if short { k + 1 } else { k };
        if let (Some(before), Some(behind)) = (lines[k - 1], lines[after]) {
            let ((t0, d0, r0), (t1, d1, r1)) = (before, behind);
            let time = (d1 - r1 * t1 - d0 + r0 * t0) / (r0 - r1);
            let level = d0 + r0 * (time - t0);
            // Two samples to either side; farther where the polyline passes there.
            let index = |corner: usize| points.partition_point(|p| p.0 < corners[corner].0);
            let (from, to) = (index(k).saturating_sub(2), (index(after) + 2).min(points.len() - 1));
            let between = time > knots[k - 1].0 && time < corners[after + 1].0;
            let near = time > points[from].0 && time < points[to].0;
            if between && (near || (level - level_at(corners, time)).abs() <= 2.0 * tolerance[from]) {
                let meet = (time, level);
                (knots[k], knots[after]) = (meet, meet);
            }
        }
        k = after + 1;
    }
    knots.dedup();
    knots
}

/// Mean time (s), level (m) and slope (m/s) of a least-squares line, without the tenth at either end.
fn middle_line(points: &[Point]) -> Option<(f64, f64, f64)> {
    let margin = (points.len() / 10).max(1);
    let middle = points.get(margin..points.len().checked_sub(margin)?).filter(|m| m.len() + 2 >= LINE)?;
    let n = middle.len() as f64;
    let (t, d) = (middle.iter().map(|p| p.0).sum::<f64>() / n, middle.iter().map(|p| p.1).sum::<f64>() / n);
    let square: f64 = middle.iter().map(|p| (p.0 - t).powi(2)).sum();
    let product: f64 = middle.iter().map(|p| (p.0 - t) * (p.1 - d)).sum();
    Some((t, d, product / square))
}

/// Knots at these times with the levels of least squares: a continuous polyline, so its normal equations are tridiagonal.
fn levelled(points: &[Point], tolerance: &[f64], mut knots: Vec<Point>) -> Vec<Point> {
    let n = knots.len();
    let (mut diagonal, mut beside, mut right) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    for (p, tolerance) in points.iter().zip(tolerance) {
        let k = knots.partition_point(|q| q.0 <= p.0).clamp(1, n - 1);
        let share = ((p.0 - knots[k - 1].0) / (knots[k].0 - knots[k - 1].0)).clamp(0.0, 1.0);
        let weight = tolerance.powi(-2);
        for (at, part) in [(k - 1, 1.0 - share), (k, share)] {
            diagonal[at] += weight * part * part;
            right[at] += weight * part * p.1;
        }
        beside[k] += weight * share * (1.0 - share);
    }
    // A knot whose pieces hold hardly a sample stays near where it is.
    for (k, knot) in knots.iter().enumerate() {
        let hold = 1e-6 * diagonal.iter().copied().fold(0.0, f64::max) / n as f64;
        diagonal[k] += hold;
        right[k] += hold * knot.1;
    }
    for k in 1..n {
        let factor = beside[k] / diagonal[k - 1];
        diagonal[k] -= factor * beside[k];
        right[k] -= factor * right[k - 1];
    }
    for k in (0..n).rev() {
        let next = if k + 1 < n { beside[k + 1] * knots[k + 1].1 } else { 0.0 };
        knots[k].1 = (right[k] - next) / diagonal[k];
    }
    knots
}

/// Without the kinks that are not needed, the smallest first; `fitted` gives the best polyline of fewer knots, if it fits.
fn pruned(mut knots: Vec<Point>, fitted: impl Fn(&[Point]) -> Option<Vec<Point>>) -> Vec<Point> {
    if knots.len() > MOST_TO_PRUNE {
        return knots;
    }
    'fewer: loop {
        let kink = |k: usize| (knots[k].1 - on_line(knots[k - 1], knots[k + 1], knots[k].0)).abs();
        let mut order: Vec<usize> = (1..knots.len() - 1).collect();
        order.sort_by(|a, b| kink(*a).total_cmp(&kink(*b)));
        for k in order {
            let mut fewer = knots.clone();
            fewer.remove(k);
            if let Some(found) = fitted(&fewer) {
                knots = found;
                continue 'fewer;
            }
        }
        return knots;
    }
}

/// Level of a polyline at a time.
fn level_at(knots: &[Point], time: f64) -> f64 {
    let k = knots.partition_point(|q| q.0 <= time).clamp(1, knots.len() - 1);
    on_line(knots[k - 1], knots[k], time)
}

fn on_line(a: Point, b: Point, time: f64) -> f64 {
    a.1 + (b.1 - a.1) * (time - a.0) / (b.0 - a.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;
    use poropunch::motion::protocol::Trapezoid;

    /// P2 until the end of the hold, sampled and rounded to 0.1 um.
    fn sampled(times: &[f64]) -> Vec<(f64, f64)> {
        let protocol = Trapezoid::p2().first_hold().unwrap();
        times.iter().map(|&t| (t, (protocol.displacement(t) * 1e7).round() / 1e7)).collect()
    }

    #[test]
    fn a_kink_at_a_sample_stays_there() {
        let mut times: Vec<f64> = (0..34).map(|i| 0.02 * f64::from(i)).collect();
        times.extend([0.6875, 0.7, 0.8, 1.0, 10.0, 90.6875]);
        let corners = reduced(&sampled(&times));
        for (found, expected) in corners.iter().zip([(0.0, -1e-4), (0.6875, 1e-3), (90.6875, 1e-3)]) {
            assert!(
                (found.0 - expected.0).abs() < 1e-4 && (found.1 - expected.1).abs() < 1e-7,
                "{corners:?}"
            );
        }
        assert_eq!(corners.len(), 3);
    }

    #[test]
    fn a_kink_between_samples_is_found() {
        let times: Vec<f64> = (0..60).map(|i| 0.05 * f64::from(i)).collect();
        let corners = reduced(&sampled(&times));
        assert_eq!(corners.len(), 3, "{corners:?}");
        assert!((corners[1].0 - 0.6875).abs() < 1e-4 && (corners[1].1 - 1e-3).abs() < 5e-8, "{corners:?}");
    }

    /// Corners are no noise, however many: six cycles have 37.
    #[test]
    fn a_path_of_corners_is_taken_as_it_is() {
        let cycles = Trapezoid { cycles: 6, ..Trapezoid::p2() };
        let points = cycles.protocol().unwrap().points().to_vec();
        let found = reduced(&points);
        assert_eq!((points.len(), found.len()), (37, 37));
        for (found, given) in found.iter().zip(&points) {
            assert!(
                (found.0 - given.0).abs() < 1e-9 && (found.1 - given.1).abs() < 1e-15,
                "{found:?} {given:?}"
            );
        }
    }

    #[test]
    fn noise_is_not_motion() {
        let protocol = Trapezoid::p2().first_hold().unwrap();
        let times: Vec<f64> = (0..900).map(|i| 0.1013 * f64::from(i)).collect();
        let mut times: Vec<f64> = times.into_iter().chain((0..80).map(|i| 0.01 * f64::from(i))).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let mut random = Random::new(7);
        let noise_m = 1e-6;
        let displacement_m = times.iter().map(|&t| protocol.displacement(t) + noise_m * random.normal());
        let m = Measurement { displacement_m: displacement_m.collect(), time_s: times, ..Default::default() };
        let found = protocol_of(&m).unwrap();
        let [start, kink, end] = found.points() else { panic!("{:?}", found.points()) };
        assert!((start.1 + 1e-4).abs() < noise_m && (end.1 - 1e-3).abs() < noise_m, "{start:?} {end:?}");
        assert!((kink.0 - 0.6875).abs() < 1e-3 && (kink.1 - 1e-3).abs() < noise_m, "{kink:?}");
    }

    #[test]
    fn a_noisy_sine_keeps_its_shape() {
        let mut random = Random::new(3);
        let time_s: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
        let shape = |t: f64| 5e-4 * (1.0 - (0.9 * t).cos());
        let displacement_m = time_s.iter().map(|&t| shape(t) + 1e-6 * random.normal()).collect();
        let m = Measurement { time_s: time_s.clone(), displacement_m, ..Default::default() };
        let found = protocol_of(&m).unwrap();
        assert!(found.points().len() < 200, "{} corners", found.points().len());
        for t in time_s {
            assert!((found.displacement(t) - shape(t)).abs() < 1.2e-5, "{t}");
        }
    }

    #[test]
    fn a_curve_stays_within_the_tolerance() {
        let points: Vec<Point> = (0..2000).map(|i| (f64::from(i), (f64::from(i) * 0.003).sin())).collect();
        let protocol = Protocol::new(reduced(&points)).unwrap();
        assert!(protocol.points().len() < 300, "{}", protocol.points().len());
        for (t, d) in points {
            assert!((protocol.displacement(t) - d).abs() < 4e-3);
        }
    }

    /// A kilohertz of encoder steps and noise, fast and slow: as many pieces as there are.
    #[test]
    fn steps_of_an_encoder_are_not_motion() {
        for (rate_mm_per_s, step_m, noise_m) in
            [(1.6, 1e-6, 0.0), (0.05, 1e-6, 0.0), (0.05, 1e-6, 2e-7), (0.7, 5e-6, 1e-6)]
        {
            let ramp = 1.1 / rate_mm_per_s;
            let at = |t: f64| -1e-4 + 1.1e-3 * (t / ramp).min(1.0);
            let mut random = Random::new(11);
            let points: Vec<Point> = (0..30_000)
                .map(|i| 1e-3 * f64::from(i) * (ramp + 5.0) / 30.0)
                .map(|t| (t, (at(t) / step_m).round() * step_m + noise_m * random.normal()))
                .collect();
            let found = reduced(&points);
            assert_eq!(found.len(), 3, "{rate_mm_per_s} {step_m} {noise_m}: {found:?}");
            assert!((found[1].0 / ramp - 1.0).abs() < 2e-3, "{found:?} {ramp}");
            assert!(
                (found[1].1 - 1e-3).abs() < 0.6 * step_m && (found[2].1 - 1e-3).abs() < 0.6 * step_m,
                "{found:?}"
            );
        }
    }
}
