//! The punch's motion in a measurement, as straight pieces with exact kinks.
//!
//! Sampled displacements are rounded. Joining every sample would give the model a slightly different
//! velocity in each interval; so samples that lie on one line become one piece, and a kink that fell
//! between two samples is put where the two pieces meet. Noise is not motion, either: where it is above the
//! rounding, the strokes and rests that [`super::motion`] finds in it are joined.

use super::measurement::Measurement;
use super::motion::{motion, sample_noise};
use poropunch::motion::protocol::{Protocol, ProtocolError};

/// Samples closer to a line than this part of the largest excursion lie on it.
const RELATIVE_TOLERANCE: f64 = 1e-4;
/// Samples within this many standard deviations of the noise lie on a line: of some thousand samples, all do.
const NOISE_REACH: f64 = 5.0;

/// Piecewise linear displacement history of a measurement.
///
/// # Errors
/// When the times do not increase (a [`Measurement`] that was read from a file has been checked).
pub fn protocol_of(m: &Measurement) -> Result<Protocol, ProtocolError> {
    let points: Vec<(f64, f64)> = m.time_s.iter().copied().zip(m.displacement_m.iter().copied()).collect();
    let reach = m.displacement_m.iter().fold(0.0_f64, |r, d| r.max(d.abs()));
    let tolerance = RELATIVE_TOLERANCE * reach;
    let noise = NOISE_REACH * sample_noise(&points);
    if noise <= tolerance {
        return Protocol::new(simplified(&points, tolerance));
    }
    match strokes(m, &points).filter(|p| lie_on(&points, p, noise + tolerance)) {
        Some(strokes) => Protocol::new(strokes),
        // A motion that is not made of straight strokes.
        None => Protocol::new(simplified(&points, noise)),
    }
}

/// Ends of the strokes, and of the rests before the first and after the last.
fn strokes(m: &Measurement, points: &[(f64, f64)]) -> Option<Vec<(f64, f64)>> {
    let strokes = motion(&m.time_s, &m.displacement_m).strokes;
    let (first, last) = (strokes.first()?, strokes.last()?);
    let (begin, finish) = (points[0].0, points[points.len() - 1].0);
    // Without a rest beside it, one noisy sample says less about a stroke's end than its line.
    let from = if first.first == 0 { first.line.at(begin) } else { first.from_m };
    let to = if last.last == points.len() - 1 { last.line.at(finish) } else { last.to_m };
    let mut result = vec![(begin, from)];
    let ends = strokes.iter().flat_map(|s| [(s.start_s, s.from_m), (s.end_s, s.to_m)]);
    let ends = ends.filter(|end| end.0 < finish);
    for end in ends.chain([(finish, to)]) {
        // A stroke may begin where the record or the stroke before it ends.
        if end.0 > result[result.len() - 1].0 {
            result.push(end);
        }
    }
    Some(result)
}

/// Whether all points lie on the polyline.
fn lie_on(points: &[(f64, f64)], polyline: &[(f64, f64)], tolerance: f64) -> bool {
    points.iter().all(|p| {
        let k = polyline.partition_point(|q| q.0 <= p.0).clamp(1, polyline.len() - 1);
        (p.1 - on_line(polyline[k - 1], polyline[k], p.0)).abs() <= tolerance
    })
}

/// Fewest corners such that every sample lies within `tolerance` of the line between its corners.
fn simplified(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    if points.len() < 3 {
        return points.to_vec();
    }
    with_kinks_between_samples(points, &corners(points, tolerance))
}

/// Ramer, Douglas and Peucker: the farthest sample becomes a corner until none is too far. First and last
/// sample (there must be one) are corners.
pub(super) fn corners(points: &[(f64, f64)], tolerance: f64) -> Vec<usize> {
    let last = points.len() - 1;
    let mut corners = vec![0];
    // A stack instead of recursion: six cycles of noisy samples may be deep.
    let mut pending = vec![(0, last)];
    while let Some((a, b)) = pending.pop() {
        let farthest = (a + 1..b)
            .map(|i| (i, (points[i].1 - on_line(points[a], points[b], points[i].0)).abs()))
            .max_by(|x, y| x.1.total_cmp(&y.1));
        if let Some((i, distance)) = farthest
            && distance > tolerance
        {
            corners.push(i);
            pending.extend([(a, i), (i, b)]);
        }
    }
    corners.push(last);
    corners.sort_unstable();
    corners
}

/// Two corners one sample apart between longer pieces: one kink where the pieces' lines cross.
fn with_kinks_between_samples(points: &[(f64, f64)], corners: &[usize]) -> Vec<(f64, f64)> {
    let mut result = Vec::with_capacity(corners.len());
    let mut i = 0;
    while i < corners.len() {
        let kink = (i > 0 && i + 2 < corners.len() && corners[i + 1] == corners[i] + 1)
            .then(|| [corners[i - 1], corners[i], corners[i + 1], corners[i + 2]])
            .filter(|c| c[1] - c[0] > 1 && c[3] - c[2] > 1)
            .and_then(|c| crossing(c.map(|k| points[k])));
        match kink {
            Some(point) => {
                result.push(point);
                i += 2;
            }
            None => {
                result.push(points[corners[i]]);
                i += 1;
            }
        }
    }
    result
}

/// Where the line through the first two points meets that through the last two, if in between.
fn crossing([a, b, c, d]: [(f64, f64); 4]) -> Option<(f64, f64)> {
    let (before, after) = ((b.1 - a.1) / (b.0 - a.0), (d.1 - c.1) / (d.0 - c.0));
    let time = (c.1 - after * c.0 - b.1 + before * b.0) / (before - after);
    (time > b.0 && time < c.0).then_some((time, b.1 + before * (time - b.0)))
}

fn on_line(a: (f64, f64), b: (f64, f64), time: f64) -> f64 {
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
        let corners = simplified(&sampled(&times), 1e-7);
        assert_eq!(corners, [(0.0, -1e-4), (0.6875, 1e-3), (90.6875, 1e-3)]);
    }

    #[test]
    fn a_kink_between_samples_is_found() {
        let times: Vec<f64> = (0..60).map(|i| 0.05 * f64::from(i)).collect();
        let corners = simplified(&sampled(&times), 1e-7);
        assert_eq!(corners.len(), 3, "{corners:?}");
        assert!((corners[1].0 - 0.6875).abs() < 1e-4 && (corners[1].1 - 1e-3).abs() < 1e-9, "{corners:?}");
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
    fn every_sample_stays_within_the_tolerance() {
        let points: Vec<(f64, f64)> = (0..200).map(|i| (f64::from(i), (f64::from(i) * 0.1).sin())).collect();
        let protocol = Protocol::new(simplified(&points, 1e-2)).unwrap();
        assert!(protocol.points().len() < 100);
        for (t, d) in points {
            assert!((protocol.displacement(t) - d).abs() < 2e-2);
        }
    }
}
