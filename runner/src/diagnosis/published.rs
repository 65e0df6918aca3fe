//! Parity of published numbers: peaks and relaxations of two protocols, without any curve.
//!
//! At equal depth every material with fading memory ends at the same force, however fast it was loaded. So the ratio
//! of the forces after the hold is the amplitude between the two protocols' specimens, and the ratio of the peaks
//! divided by it is the rate's own effect, which the model can be asked for.

use serde::Deserialize;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// One published line.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Published {
    /// Material.
    pub material: String,
    /// Protocol; empty where it was not told.
    #[serde(default)]
    pub protocol: String,
    /// Cycle, counted from 1.
    pub cycle: usize,
    /// Peak over the reference protocol's peak of this cycle.
    pub peak_over_p1: Option<f64>,
    /// Relaxation, (peak - force after the hold) / peak (%).
    pub relaxation_percent: f64,
}

/// A file that cannot be used.
#[derive(Debug, Error)]
pub enum PublishedError {
    /// Not readable as such a table.
    #[error(
        "{path}: {source}; needed are the columns material,protocol,cycle,peak_over_P1,relaxation_percent (lines with # are \
         comments)"
    )]
    Csv {
        /// File.
        path: PathBuf,
        /// Reason, with the line.
        source: csv::Error,
    },
    /// A relaxation that is none.
    #[error("{path}: {material}, {protocol}, cycle {cycle}: relaxation_percent must lie between 0 and 100")]
    Relaxation {
        /// File.
        path: PathBuf,
        /// Material.
        material: String,
        /// Protocol.
        protocol: String,
        /// Cycle.
        cycle: usize,
    },
}

/// Reads the table.
///
/// # Errors
/// Names file, line and columns.
pub fn read(path: &Path) -> Result<Vec<Published>, PublishedError> {
    let problem = |source| PublishedError::Csv { path: path.to_owned(), source };
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(problem)?;
    // `P1` in a column's name: names are matched in small letters.
    let header = reader.headers().map_err(problem)?;
    let header: csv::StringRecord = header.iter().map(str::to_lowercase).collect();
    reader.set_headers(header);
    let lines: Vec<Published> = reader.deserialize().collect::<Result<_, _>>().map_err(problem)?;
    match lines.iter().find(|l| !(0.0..100.0).contains(&l.relaxation_percent)) {
        Some(l) => Err(PublishedError::Relaxation {
            path: path.to_owned(),
            material: l.material.clone(),
            protocol: l.protocol.clone(),
            cycle: l.cycle,
        }),
        None => Ok(lines),
    }
}

/// A value with the range that the rounding of the published digits leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rounded {
    /// Value.
    pub value: f64,
    /// Range.
    pub range: (f64, f64),
}

impl Rounded {
    fn over(self, other: Self) -> Self {
        Self {
            value: self.value / other.value,
            range: (self.range.0 / other.range.1, self.range.1 / other.range.0),
        }
    }

    fn holds(self, value: f64) -> bool {
        (self.range.0..=self.range.1).contains(&value)
    }
}

/// What the two protocols' numbers of one cycle say.
#[derive(Debug, Clone, PartialEq)]
pub struct Ratios {
    /// Material.
    pub material: String,
    /// Cycle.
    pub cycle: usize,
    /// Protocol over the other.
    pub protocols: (String, String),
    /// Ratio of the peaks.
    pub peaks: Rounded,
    /// Ratio of the forces after the hold.
    pub ends: Rounded,
    /// Ratio of the peaks over that of the ends.
    pub rate: Rounded,
}

/// Cause of the difference between two protocols.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// The amplitude explains what the model's own rate effect leaves.
    Amplitude,
    /// The rate has a larger effect than the model's, and there is no amplitude.
    Rate,
    /// Both are there.
    Both,
    /// A faster protocol with a smaller rate effect than none: relaxation itself differs.
    Relaxation,
    /// The model explains the ratio.
    Neither,
}

/// All cycles for which two protocols are published; the first protocol of each is the reference.
pub fn ratios(lines: &[Published]) -> Vec<Ratios> {
    // Published to whole percents.
    const HALF: f64 = 0.005;
    let rounded = |value: f64| Rounded { value, range: (value - HALF, value + HALF) };
    let left = |l: &Published| rounded(1.0 - 0.01 * l.relaxation_percent);
    let mut all = Vec::new();
    for (k, reference) in lines.iter().enumerate() {
        let same = |l: &&Published| l.material == reference.material && l.cycle == reference.cycle;
        if reference.protocol.is_empty() || lines[..k].iter().any(|l| same(&l)) {
            continue;
        }
        for other in lines[k + 1..].iter().filter(same).filter(|l| !l.protocol.is_empty()) {
            let (Some(peak), Some(unit)) = (other.peak_over_p1, reference.peak_over_p1) else { continue };
            let peaks = rounded(peak / unit);
            let fractions = left(other).over(left(reference));
            let product = |a: Rounded, b: Rounded| Rounded {
                value: a.value * b.value,
                range: (a.range.0 * b.range.0, a.range.1 * b.range.1),
            };
            all.push(Ratios {
                material: reference.material.clone(),
                cycle: reference.cycle,
                protocols: (other.protocol.clone(), reference.protocol.clone()),
                peaks,
                ends: product(peaks, fractions),
                // The peaks cancel: only what is left of them counts.
                rate: Rounded { value: 1.0, range: (1.0, 1.0) }.over(fractions),
            });
        }
    }
    all
}

impl Ratios {
    /// What the ratios mean, where the model's own rate effect is `model` and both are the same but for rounding
    /// and the few per cent by which curves of the same model differ.
    pub fn reading(&self, model: f64) -> Reading {
        const LIKE: f64 = 0.02;
        let wider = |r: Rounded| Rounded { range: (r.range.0 - LIKE, r.range.1 + LIKE), ..r };
        let amplitude = !wider(self.ends).holds(1.0);
        let rate = !wider(self.rate).holds(model);
        match (amplitude, rate) {
            (_, true) if self.rate.value < 1.0 => Reading::Relaxation,
            (true, false) => Reading::Amplitude,
            (false, true) => Reading::Rate,
            (true, true) => Reading::Both,
            (false, false) => Reading::Neither,
        }
    }

    /// In words; `model` as for [`Ratios::reading`].
    pub fn words(&self, model: f64) -> String {
        let headline = match self.reading(model) {
            Reading::Amplitude => "amplitude between the two protocols' specimens, not rate",
            Reading::Rate => "rate, more than the model has; no amplitude between the specimens",
            Reading::Both => "amplitude between the two protocols' specimens, and rate beyond the model's",
            Reading::Relaxation => {
                "amplitude and shape: the faster protocol relaxes less, which no effect of its rate explains"
            }
            Reading::Neither => "nothing beyond the model",
        };
        let shown = |r: Rounded| format!("{:.2} [{:.2}, {:.2}]", r.value, r.range.0, r.range.1);
        format!(
            "{}, cycle {}, {} against {}: {headline}.\n  peaks {}; forces after the hold {} (1.00 at equal depth for any fading \
             memory); effect of the rate alone {}, of the model {model:.2}",
            self.material,
            self.cycle,
            self.protocols.0,
            self.protocols.1,
            shown(self.peaks),
            shown(self.ends),
            shown(self.rate),
        )
    }
}

/// What such numbers cannot decide.
pub const UNDECIDED: &str = "Ranges are those of rounding only. Not to be decided from these numbers: whether the ratio is \
chance (the scatter of the specimens is not published with them), where in the curve it arises, whether drift, lag, contact \
offset or compliance take part, and what the read-out (traction integral) or the size of the meshed domain change: those \
scale both protocols alike and cancel in the ratios.";

#[cfg(test)]
mod tests {
    use super::*;

    fn line(protocol: &str, peak: f64, relaxation_percent: f64) -> Published {
        Published {
            material: "gel".into(),
            protocol: protocol.into(),
            cycle: 1,
            peak_over_p1: Some(peak),
            relaxation_percent,
        }
    }

    fn reading(peak: f64, first: f64, second: f64) -> Reading {
        let all = ratios(&[line("P1", 1.0, first), line("P2", peak, second)]);
        assert_eq!(all.len(), 1);
        all[0].reading(1.06)
    }

    #[test]
    fn the_first_cycle_of_the_paper_is_amplitude() {
        let all = ratios(&[line("P1", 1.0, 52.0), line("P2", 1.27, 55.0)]);
        assert!((all[0].ends.value - 1.27 * 0.45 / 0.48).abs() < 1e-12);
        assert!((all[0].rate.value - 0.48 / 0.45).abs() < 1e-12);
        assert_eq!(reading(1.27, 52.0, 55.0), Reading::Amplitude);
    }

    #[test]
    fn a_faster_test_of_the_same_specimens_is_rate_or_nothing() {
        // The ends are equal: 1.30 * 0.40 = 1 * 0.52.
        assert_eq!(reading(1.30, 48.0, 60.0), Reading::Rate);
        assert_eq!(reading(1.06, 52.0, 54.7), Reading::Neither);
        assert_eq!(reading(1.27, 60.0, 53.0), Reading::Relaxation);
        assert_eq!(reading(1.60, 48.0, 60.0), Reading::Both);
    }
}
