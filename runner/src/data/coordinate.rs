//! From the machine's coordinate to the sample's: sign, surface and load cell's zero, given by the user, told by the data,
//! or asked for.

use super::error::Question;
use super::measurement::{Measurement, median};
use super::motion::sample_noise;
use super::reading::{Flip, Reading, Tare, Zero};

/// Whether displacement and force are in this project's own spelling, which promises sign and zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Own {
    /// That of the displacement.
    pub displacement: bool,
    /// That of the force.
    pub force: bool,
}

/// Where the force begins to rise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Onset {
    /// Displacement there (m).
    pub at_m: f64,
    /// Its standard deviation (m).
    pub sigma_m: f64,
    /// Mean force before it (N).
    pub base_n: f64,
    /// Standard deviation of that mean (N).
    pub base_sigma_n: f64,
    /// Samples before it.
    pub samples: usize,
}

/// A rise of this many deviations of the noise is contact ...
const RISE_SIGMA: f64 = 6.0;
/// ... or of this part of the largest force.
const RISE_PART: f64 = 0.01;
/// An offset of less than this part of the depth, or of the largest force, moves no result.
const SMALL: f64 = 0.02;
/// Samples that tell where the force begins.
const BEGINNING: usize = 5;
/// Fewest samples before the rise that tell its level: one of three may stand alone.
const FEWEST: usize = 3;

/// Puts displacement and force into the sample's coordinate; returns what is open.
pub fn settle(m: &mut Measurement, own: Own, reading: &Reading) -> Vec<Question> {
    let mut questions = Vec::new();
    let flipped = flips(m, own, reading);
    if flipped.displacement {
        m.displacement_m.iter_mut().for_each(|d| *d = -*d);
    }
    if flipped.force {
        reverse_force(m);
    }
    let told = Told { own, reading, flipped, onset: onset(&m.displacement_m, &m.force_n) };
    tare(m, &told, &mut questions);
    zero(m, &told, &mut questions);
    questions
}

/// Which of displacement and force are reversed.
#[derive(Clone, Copy)]
struct Flipped {
    displacement: bool,
    force: bool,
}

/// What is known of a file when its zeros are looked for.
struct Told<'a> {
    own: Own,
    reading: &'a Reading,
    flipped: Flipped,
    onset: Option<Onset>,
}

/// Whether displacement and force are reversed.
fn flips(m: &mut Measurement, own: Own, reading: &Reading) -> Flipped {
    let of = |displacement, force| Flipped { displacement, force };
    match reading.flip {
        Some(Flip::Displacement) => return of(true, false),
        Some(Flip::Force) => return of(false, true),
        Some(Flip::Both) => return of(true, true),
        Some(Flip::None) => return of(false, false),
        None => {}
    }
    // The force is largest where the punch is in; a test in which it is not has no direction of its own.
    let Some((motion, push)) = largest_push(m) else { return of(false, false) };
    if push < 0.0 && own.force {
        m.warnings.push(
            "the force falls as the punch goes in: is tension positive? --flip=force, or --flip=none"
                .to_owned(),
        );
    }
    let flip = of(motion < 0.0 && !own.displacement, push < 0.0 && !own.force);
    for (flipped, what) in [
        (
            flip.displacement,
            "displacement grows away from the sample: its sign was reversed (--flip=none keeps it)",
        ),
        (flip.force, "tension is positive: the sign of the force was reversed (--flip=none keeps it)"),
    ] {
        if flipped {
            m.notes.push(what.to_owned());
        }
    }
    flip
}

/// Displacement and force at the largest change of the force from its beginning, where that stands out of the noise.
fn largest_push(m: &Measurement) -> Option<(f64, f64)> {
    let start_n = median(&mut m.force_n.get(..BEGINNING)?.to_vec());
    let far = (0..m.len())
        .max_by(|&a, &b| (m.force_n[a] - start_n).abs().total_cmp(&(m.force_n[b] - start_n).abs()))?;
    let push = m.force_n[far] - start_n;
    let (motion, noise) = (m.displacement_m[far] - m.displacement_m[0], noise_n(m));
    (push.abs() > 2.0 * RISE_SIGMA * noise && motion != 0.0).then_some((motion, push))
}

fn noise_n(m: &Measurement) -> f64 {
    let points: Vec<(f64, f64)> = m.time_s.iter().copied().zip(m.force_n.iter().copied()).collect();
    sample_noise(&points)
}

fn reverse_force(m: &mut Measurement) {
    m.force_n.iter_mut().chain(m.specimens_n.iter_mut().flatten()).for_each(|f| *f = -*f);
    for (low, high) in m.quartiles_n.iter_mut().flatten() {
        (*low, *high) = (-*high, -*low);
    }
}

/// Takes the load cell's zero off, or asks.
fn tare(m: &mut Measurement, told: &Told<'_>, questions: &mut Vec<Question>) {
    let mn = |f: f64| format!("{:.4} mN", f * 1e3);
    let offset = match told.reading.tare {
        Some(Tare::None) => return,
        Some(Tare::First) => m.force_n.first().copied(),
        Some(Tare::At(value)) => Some(if told.flipped.force { -value } else { value }),
        // Where nothing stands before contact, the fit alone finds it.
        Some(Tare::Fit) => told.onset.filter(|o| o.samples >= FEWEST).map(|o| o.base_n),
        Some(Tare::OffContact) => {
            let base = told.onset.filter(|o| o.samples >= 1).map(|o| o.base_n);
            if base.is_none() {
                questions.push(Question {
                    what: "the file has no samples before contact, so there is no force off contact"
                        .to_owned(),
                    answer: "--tare none".to_owned(),
                });
            }
            base
        }
        None => {
            let Some(o) = told.onset.filter(|o| o.samples >= FEWEST) else { return };
            let largest = m.force_n.iter().map(|f| (f - o.base_n).abs()).fold(0.0, f64::max);
            if o.base_n.abs() < (4.0 * o.base_sigma_n).max(SMALL * largest) {
                return;
            }
            let sigma = mn(o.base_sigma_n);
            let what = format!(
                "the force is {} +- {sigma} before it rises: is that the load cell's zero?",
                mn(o.base_n)
            );
            let answer = "--tare off-contact".to_owned();
            if told.own.force {
                m.warnings.push(format!("{what} {answer}, or --tare none"));
            } else {
                questions.push(Question { what, answer });
            }
            return;
        }
    };
    let Some(offset) = offset else { return };
    m.force_n.iter_mut().chain(m.specimens_n.iter_mut().flatten()).for_each(|f| *f -= offset);
    m.quartiles_n.iter_mut().flatten().for_each(|q| *q = (q.0 - offset, q.1 - offset));
    m.notes.push(format!("{} were taken off the force (--tare)", mn(offset)));
}

/// Puts the zero of the displacement onto the surface, or asks.
fn zero(m: &mut Measurement, told: &Told<'_>, questions: &mut Vec<Question>) {
    let mm = |d: f64| format!("{:.4} mm", d * 1e3);
    let first = m.displacement_m.first().copied().unwrap_or(0.0);
    let surface = match told.reading.zero {
        Some(Zero::First) => Some(first),
        Some(Zero::At(value)) => Some(if told.flipped.displacement { -value } else { value }),
        Some(Zero::Contact | Zero::Fit) => {
            if told.onset.is_none() {
                questions.push(Question {
                    what: "the force does not rise out of its noise, so there is no contact".to_owned(),
                    answer: format!("--zero {}mm", first * 1e3),
                });
            }
            told.onset.map(|o| o.at_m)
        }
        None => {
            let depth = m.depth_m() - first.min(0.0);
            let Some(o) = told.onset else { return };
            if o.at_m.abs() < (3.0 * o.sigma_m).max(SMALL * depth) {
                return;
            }
            let what =
                format!("the force starts at {} +- {}: is that the surface?", mm(o.at_m), mm(o.sigma_m));
            if told.own.displacement {
                m.warnings.push(format!("{what} --zero contact, or --zero 0"));
            } else {
                let sign = if told.flipped.displacement { "(sign reversed) " } else { "" };
                questions.push(Question {
                    what: format!("{what} {sign}The file begins at {}", mm(first)),
                    answer: "--zero contact".to_owned(),
                });
            }
            return;
        }
    };
    let Some(surface) = surface else { return };
    m.displacement_m.iter_mut().for_each(|d| *d -= surface);
    if surface != 0.0 {
        m.notes.push(format!("the surface is at {} of the file's displacement (--zero)", mm(surface)));
    }
}

/// Where the force begins to rise on the way to its largest value; `None` when it does not, or nothing is before it.
pub fn onset(displacement_m: &[f64], force_n: &[f64]) -> Option<Onset> {
    let points: Vec<(f64, f64)> = force_n.iter().enumerate().map(|(i, f)| (i as f64, *f)).collect();
    let noise = sample_noise(&points);
    let start = median(&mut force_n.get(..3)?.to_vec());
    let peak = (0..force_n.len()).max_by(|&a, &b| force_n[a].total_cmp(&force_n[b]))?;
    let rise = force_n[peak] - start;
    if rise <= 2.0 * RISE_SIGMA * noise || rise <= 0.0 {
        return None;
    }
    let level = start + (RISE_SIGMA * noise).max(RISE_PART * rise);
    let last = (0..peak).rev().find(|&i| force_n[i] <= level)?;
    let base = &force_n[..=last];
    let base_n = median(&mut base.to_vec());
    // Before contact the punch may be on its way, or rest on the surface: there the surface is.
    let next = last + 1;
    let step = displacement_m[next] - displacement_m[last];
    let beyond = (next + 1..=peak).find(|&i| displacement_m[i] > displacement_m[next]);
    let line = beyond.map(|i| {
        let slope = (force_n[i] - force_n[next]) / (displacement_m[i] - displacement_m[next]);
        displacement_m[next] - (force_n[next] - base_n) / slope
    });
    let low = displacement_m[last].min(displacement_m[next]);
    let at_m = line.filter(|d| d.is_finite()).map_or(low, |d| d.clamp(low, displacement_m[next].max(low)));
    let base_sigma_n = 1.2533 * noise / (base.len() as f64).sqrt();
    Some(Onset { at_m, sigma_m: (0.5 * step.abs()).max(1e-9), base_n, base_sigma_n, samples: base.len() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::random::Random;

    /// A machine that rests, then moves down from 12.34 mm to the sample at 12.00 mm and 1 mm into it; tension positive,
    /// 1.5 mN on the load cell.
    fn machine() -> Measurement {
        let mut random = Random::new(5);
        let time_s: Vec<f64> = (0..400).map(|i| 0.01 * f64::from(i)).collect();
        let depth = |t: f64| (t - 0.5).clamp(0.0, 1.34) - 0.34;
        let force = |t: f64| 1.5 + if depth(t) > 0.0 { -10.0 * depth(t) } else { 0.0 };
        Measurement {
            displacement_m: time_s.iter().map(|t| (12.0 - depth(*t)) * 1e-3).collect(),
            force_n: time_s.iter().map(|t| (force(*t) + 0.01 * random.normal()) * 1e-3).collect(),
            time_s,
            ..Measurement::default()
        }
    }

    const LAB: Own = Own { displacement: false, force: false };

    #[test]
    fn signs_are_told_by_the_data_zero_and_tare_are_asked_together() {
        let questions = settle(&mut machine(), LAB, &Reading::default());
        let answers: Vec<&str> = questions.iter().map(|q| q.answer.as_str()).collect();
        assert_eq!(answers, ["--tare off-contact", "--zero contact"]);
        assert!(questions[1].what.contains("-12.0") || questions[1].what.contains("-11.99"), "{questions:?}");
    }

    #[test]
    fn the_answers_put_everything_in_place() {
        let reading =
            Reading { zero: Some(Zero::Contact), tare: Some(Tare::OffContact), ..Reading::default() };
        let mut m = machine();
        assert!(settle(&mut m, LAB, &reading).is_empty());
        assert!((m.displacement_m[0] + 0.34e-3).abs() < 2e-5, "{}", m.displacement_m[0]);
        assert!((m.depth_m() - 1e-3).abs() < 2e-5);
        assert!((m.force_n[399] - 10e-3).abs() < 0.1e-3 && m.force_n[0].abs() < 0.1e-3);
        assert_eq!(m.notes.len(), 4, "{:?}", m.notes);
        // The same by hand, in the file's own coordinate.
        let by_hand = Reading {
            zero: Some(Zero::At(12e-3)),
            tare: Some(Tare::At(1.5e-3)),
            flip: Some(Flip::Both),
            ..Reading::default()
        };
        let mut again = machine();
        assert!(settle(&mut again, LAB, &by_hand).is_empty());
        assert!((again.depth_m() - 1e-3).abs() < 1e-9 && (again.force_n[399] - 10e-3).abs() < 0.1e-3);
    }

    #[test]
    fn own_files_are_believed_and_warned_about() {
        let mut m = machine();
        m.displacement_m.iter_mut().for_each(|d| *d = 12.1e-3 - *d);
        m.force_n.iter_mut().for_each(|f| *f = 1.5e-3 - *f);
        let own = Own { displacement: true, force: true };
        assert!(settle(&mut m, own, &Reading::default()).is_empty());
        assert!(
            m.warnings.len() == 1 && m.warnings[0].contains("the force starts at 0.1"),
            "{:?}",
            m.warnings
        );
        m.warnings.clear();
        m.displacement_m.iter_mut().for_each(|d| *d -= 0.1e-3);
        assert!(
            settle(&mut m, own, &Reading::default()).is_empty() && m.warnings.is_empty(),
            "{:?}",
            m.warnings
        );
    }

    #[test]
    fn without_contact_there_is_nothing_to_ask() {
        let mut m = machine();
        m.force_n.iter_mut().enumerate().for_each(|(i, f)| *f = if i % 2 == 0 { 1e-5 } else { -1e-5 });
        assert!(settle(&mut m, LAB, &Reading::default()).is_empty());
    }
}
