//! What to simulate: a protocol by name, or the motion in a file.

use crate::cli::engine_args::show_notes;
use crate::cli::exit::UsageError;
use crate::cli::terminal;
use crate::data::{Reading, Wanted, protocol_of, read_as};
use poropunch::motion::protocol::{Protocol, ProtocolError, Trapezoid};
use std::path::Path;
use std::sync::Arc;

/// A motion and the times at which outputs are wanted.
pub struct Motion {
    /// Its name: P1, P2 or the file's.
    pub name: String,
    /// The motion.
    pub protocol: Arc<Protocol>,
    /// Output times (s).
    pub time_s: Arc<[f64]>,
}

/// Output times of a protocol where no number is asked for.
const POINTS: usize = 300;

/// The paper's `P1` or `P2`: that many complete cycles, or the first one to the end of the hold; nothing for another name.
///
/// # Errors
/// When there is no such number of cycles.
pub fn paper(name: &str, cycles: Option<i32>, points: usize) -> Result<Option<Motion>, ProtocolError> {
    let trapezoid = match name {
        "P1" => Trapezoid::p1(),
        "P2" => Trapezoid::p2(),
        _ => return Ok(None),
    };
    let protocol = match cycles {
        Some(cycles) => Trapezoid { cycles, ..trapezoid }.protocol()?,
        None => trapezoid.first_hold()?,
    };
    let time_s = output_times(&protocol, points).into();
    Ok(Some(Motion { name: name.to_owned(), protocol: Arc::new(protocol), time_s }))
}

/// `P1`, `P2` (that many complete cycles, or the first one to the end of the hold) or the path of a CSV file.
///
/// # Errors
/// When the file cannot be used, or cycles or a number of output times are asked of it.
pub fn motion(
    text: &str,
    cycles: Option<i32>,
    points: Option<usize>,
    reading: &Reading,
) -> Result<Motion, Box<dyn std::error::Error>> {
    if let Some(motion) = paper(text, cycles, points.unwrap_or(POINTS))? {
        if *reading != Reading::default() {
            terminal::note(&format!("{text} is no file: what is said about reading files acts on nothing"));
        }
        return Ok(motion);
    }
    let of_protocols = [("--cycles", cycles.is_some()), ("--points", points.is_some())];
    if let Some((option, _)) = of_protocols.iter().find(|(_, is_given)| *is_given) {
        return Err(
            UsageError(format!("{option} belongs to P1 and P2, {text} has its own; leave it out")).into()
        );
    }
    let path = Path::new(text);
    if !path.exists() {
        return Err(UsageError(format!("{text} is neither a protocol (P1, P2) nor a file")).into());
    }
    let measurement = read_as(path, Wanted::Motion, reading)?;
    show_notes(&measurement);
    let protocol = Arc::new(protocol_of(&measurement)?);
    Ok(Motion { name: measurement.name, protocol, time_s: measurement.time_s.into() })
}

/// Times that show the curve: within each straight piece even while the punch moves, and ever wider apart
/// while it rests.
fn output_times(protocol: &Protocol, points: usize) -> Vec<f64> {
    let corners = protocol.points();
    let per_piece = (points / corners.len().max(2).saturating_sub(1)).max(2);
    let mut times = vec![protocol.start_time()];
    for pair in corners.windows(2) {
        let ((from, before), (to, after)) = (pair[0], pair[1]);
        let duration = to - from;
        for i in 1..=per_piece {
            let part = i as f64 / per_piece as f64;
            // A rest is sampled geometrically, from a ten-thousandth of its length on.
            let part = if before == after { 1e4_f64.powf(part - 1.0) } else { part };
            times.push(if i == per_piece { to } else { from + part * duration });
        }
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_times_increase_and_hit_the_corners() {
        let motion = motion("P2", None, Some(200), &Reading::default()).unwrap();
        assert!(motion.time_s.windows(2).all(|w| w[0] < w[1]));
        for &(corner, _) in motion.protocol.points() {
            assert!(motion.time_s.contains(&corner));
        }
        assert_eq!(motion.time_s.len(), 201);
    }

    #[test]
    fn cycles_are_complete() {
        let motion = motion("P1", Some(6), Some(720), &Reading::default()).unwrap();
        assert_eq!(motion.protocol.points().len(), 1 + 6 * 6);
        assert_eq!(motion.time_s.last(), Some(&motion.protocol.end_time()));
        assert!(super::motion("data.csv", Some(6), None, &Reading::default()).is_err());
    }
}
