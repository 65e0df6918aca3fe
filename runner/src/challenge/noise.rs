//! Specimens of a case: what each of them measures, and with which noise.

use super::cause::{Cause, Flaw};
use super::draw::Drawn;
use super::simulate::Test;
use crate::data::measurement::median;
use crate::data::random::Random;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;

/// Specimens and noise of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Specimens of each test.
    pub specimens: usize,
    /// Whether both tests are made on the same specimens.
    pub same_specimens: bool,
    /// Relative deviation of the specimens' heights (-).
    pub height_scatter: f64,
    /// Relative deviation of the specimens' late forces (-).
    pub shape_scatter: f64,
    /// White noise of a sample (N).
    pub white_n: f64,
    /// What there is beside it.
    pub family: Family,
    /// Seed of all of it.
    pub seed: u64,
}

/// Noise beside the white one; the diagnosis knows none of it by its name.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "form", rename_all = "kebab-case")]
pub enum Family {
    /// None.
    White,
    /// The zero of the load cell wanders about its mean, on its own for every specimen.
    WanderingZero {
        /// Standard deviation (N).
        deviation_n: f64,
        /// Time of the wandering (s).
        time_s: f64,
    },
    /// Forces come in steps.
    Quantised {
        /// Step (N).
        step_n: f64,
    },
    /// A sample is taken a little before or after the time that is recorded.
    JitteredClock {
        /// Standard deviation (s).
        deviation_s: f64,
    },
    /// Single samples are far off.
    Outliers {
        /// Part of all samples.
        share: f64,
        /// Standard deviation (N).
        size_n: f64,
    },
}

impl Family {
    /// Its name, as the table of scores has it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::White => "white",
            Self::WanderingZero { .. } => "wandering zero",
            Self::Quantised { .. } => "quantised",
            Self::JitteredClock { .. } => "jittered clock",
            Self::Outliers { .. } => "outliers",
        }
    }

    /// Force (N) as it would be without white noise, from that at the recorded times.
    fn disturbed(&self, time_s: &[f64], force_n: &[f64], random: &mut Random) -> Vec<f64> {
        match *self {
            Self::White | Self::Quantised { .. } => force_n.to_vec(),
            Self::WanderingZero { deviation_n, time_s: slow } => {
                let (mut zero, mut before) = (deviation_n * random.normal(), time_s[0]);
                let mut wandering = |(f, t): (&f64, &f64)| {
                    let kept = (-(t - before) / slow).exp();
                    zero = kept * zero + deviation_n * (1.0 - kept * kept).sqrt() * random.normal();
                    before = *t;
                    f + zero
                };
                force_n.iter().zip(time_s).map(&mut wandering).collect()
            }
            Self::JitteredClock { deviation_s } => {
                let last = force_n.len() - 1;
                let mut at = |k: usize| {
                    let late = deviation_s * random.normal();
                    let (from, to) =
                        if late > 0.0 { (k, (k + 1).min(last)) } else { (k.saturating_sub(1), k) };
                    let slope = if from < to {
                        (force_n[to] - force_n[from]) / (time_s[to] - time_s[from])
                    } else {
                        0.0
                    };
                    force_n[k] + late * slope
                };
                (0..force_n.len()).map(&mut at).collect()
            }
            Self::Outliers { share, size_n } => {
                let mut spoilt = |f: &f64| {
                    let is_out = random.uniform() < share;
                    f + if is_out { size_n * random.normal() } else { 0.0 }
                };
                force_n.iter().map(&mut spoilt).collect()
            }
        }
    }

    /// What the digits leave of a force (N).
    fn recorded(&self, force_n: f64) -> f64 {
        match self {
            Self::Quantised { step_n } => (force_n / step_n).round() * step_n,
            _ => force_n,
        }
    }
}

/// What makes a specimen different.
#[derive(Debug, Clone, Copy)]
struct Specimen {
    height: f64,
    late: f64,
}

/// Measured forces (N) of both tests, `[test][specimen][sample]`.
pub fn measured_n(drawn: &Drawn, tests: &[Test; 2], readings_n: &[Vec<f64>]) -> Vec<Vec<Vec<f64>>> {
    let noise = &drawn.noise;
    let mut random = Random::new(noise.seed);
    // Of its own, so that heights and white noise are the same with every family.
    let mut beside = Random::new(!noise.seed);
    let mut specimens = batch(noise, &mut random);
    let mut all = Vec::new();
    for (index, (test, reading)) in tests.iter().zip(readings_n).enumerate() {
        if index > 0 && !noise.same_specimens {
            specimens = batch(noise, &mut random);
        }
        let mut one = |(number, s): (usize, &Specimen)| -> Vec<f64> {
            let is_bad = number == 0 && (index == 0 || noise.same_specimens);
            let value = |(t, f): (&f64, &f64)| {
                // Shapes differ with the logarithm of the time: 0 at 0.1 s, 1 at 100 s after the ramp.
                let since = t - test.ramp_end_s;
                let decades = (since.max(0.1).log10() + 1.0) / 3.0;
                let kept = if is_bad { kept_by_bad(&drawn.causes, since) } else { 1.0 };
                s.height * f * (1.0 + s.late * decades) * kept
            };
            let force: Vec<f64> = test.time_s.iter().zip(reading).map(value).collect();
            let disturbed = noise.family.disturbed(&test.time_s, &force, &mut beside);
            disturbed.iter().map(|f| noise.family.recorded(f + noise.white_n * random.normal())).collect()
        };
        all.push(specimens.iter().enumerate().map(&mut one).collect());
    }
    all
}

/// Part of a bad specimen's force that is left so long after the ramp's end (s).
fn kept_by_bad(causes: &[Cause], since: f64) -> f64 {
    let kept = |cause: &Cause| match cause {
        Cause::Specimen(Flaw::BadSpecimen { loss, time_s }) => {
            1.0 - loss * (1.0 - (-since.max(0.0) / time_s).exp())
        }
        _ => 1.0,
    };
    causes.iter().map(kept).product()
}

/// Height that the specimens of both tests share: their geometric mean over the nominal one. No data tell it from the moduli. The
/// first test has `points` samples.
pub fn shared_height(drawn: &Drawn, points: usize) -> f64 {
    let noise = &drawn.noise;
    let mut random = Random::new(noise.seed);
    let mean = |batch: &[Specimen]| batch.iter().map(|s| s.height.ln()).sum::<f64>() / batch.len() as f64;
    let first = mean(&batch(noise, &mut random));
    if noise.same_specimens {
        return first.exp();
    }
    (0..noise.specimens * points).for_each(|_| {
        random.normal();
    });
    (0.5 * (first + mean(&batch(noise, &mut random)))).exp()
}

fn batch(noise: &Noise, random: &mut Random) -> Vec<Specimen> {
    let mut one = || Specimen {
        height: (noise.height_scatter * random.normal()).exp(),
        late: noise.shape_scatter * random.normal(),
    };
    (0..noise.specimens).map(|_| one()).collect()
}

/// The file of a test.
pub fn csv(test: &Test, measured_n: &[Vec<f64>]) -> String {
    let mut text =
        "# Synthetic: made by `runner challenge make`; what is behind it is in a sealed key.\n".to_owned();
    text.push_str("time_s,displacement_mm,force_mN");
    for k in 1..=measured_n.len() {
        let _ = write!(text, ",s{k:02}");
    }
    text.push('\n');
    for (i, t) in test.time_s.iter().enumerate() {
        let values: Vec<f64> = measured_n.iter().map(|s| s[i] * 1e3).collect();
        let middle = median(&mut values.clone());
        let depth_mm = test.protocol.displacement(*t) * 1e3;
        let _ = write!(text, "{t:.4},{depth_mm:.4},{middle:.4}");
        for value in values {
            let _ = write!(text, ",{value:.4}");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::challenge::draw::draw;
    use crate::challenge::ground::Ground;
    use crate::challenge::simulate::tests;

    /// Goal: the height is that of the specimens that were measured. Reference: the mean of the measured curves where all force is 1 N
    /// long after the ramp, 10 specimens and hundreds of points: its noise is below 1e-5.
    #[test]
    fn the_shared_height_is_that_of_what_was_measured() {
        let mut drawn = draw(3, 1, &[], Ground::Near).remove(0);
        drawn.noise.shape_scatter = 0.0;
        let tests = tests(1).unwrap();
        let ones: Vec<Vec<f64>> = tests.iter().map(|t| vec![1.0; t.time_s.len()]).collect();
        for same in [true, false] {
            drawn.noise.same_specimens = same;
            let measured = measured_n(&drawn, &tests, &ones);
            let log_height =
                |specimen: &Vec<f64>| (specimen.iter().sum::<f64>() / specimen.len() as f64).ln();
            let heights: Vec<f64> = measured.iter().flatten().map(log_height).collect();
            let mean = heights.iter().sum::<f64>() / heights.len() as f64;
            assert!((shared_height(&drawn, ones[0].len()) - mean.exp()).abs() < 1e-5);
        }
    }

    /// Goal: each family of noise is what it says. Set-up: a ramp of 1 N/s without white noise, 20,000 samples.
    #[test]
    fn families_of_noise_have_their_deviations() {
        let time: Vec<f64> = (0..20_000).map(|k| 0.01 * f64::from(k)).collect();
        let noise = |family: Family| -> Vec<f64> {
            let disturbed = family.disturbed(&time, &time, &mut Random::new(5));
            disturbed.iter().zip(&time).map(|(f, t)| family.recorded(*f) - t).collect()
        };
        let deviation = |of: &[f64]| (of.iter().map(|x| x * x).sum::<f64>() / of.len() as f64).sqrt();
        let jitter = noise(Family::JitteredClock { deviation_s: 2e-3 });
        assert!((deviation(&jitter) / 2e-3 - 1.0).abs() < 0.03);
        let steps = noise(Family::Quantised { step_n: 0.7 });
        assert!((deviation(&steps) / (0.7 / 12f64.sqrt()) - 1.0).abs() < 0.03);
        let outliers = noise(Family::Outliers { share: 0.01, size_n: 3.0 });
        let out = outliers.iter().filter(|f| f.abs() > 1e-9).count();
        assert!((150..250).contains(&out) && deviation(&outliers) > 0.2);
        let wandering = noise(Family::WanderingZero { deviation_n: 0.3, time_s: 0.5 });
        assert!((deviation(&wandering) / 0.3 - 1.0).abs() < 0.15);
        let near = wandering.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / wandering.len() as f64;
        assert!((near / 0.09 - 0.98).abs() < 0.3);
        assert!(noise(Family::White).iter().all(|f| *f == 0.0));
    }
}
