//! Ten specimens of a case: what each of them measures.

use super::draw::Drawn;
use super::simulate::Test;
use crate::data::measurement::median;
use crate::data::random::Random;
use std::fmt::Write as _;

/// Specimens of a test.
const COUNT: usize = 10;
/// White noise of a sample (N).
const WHITE_N: f64 = 0.07e-3;

/// What makes a specimen different.
#[derive(Debug, Clone, Copy)]
struct Specimen {
    height: f64,
    late: f64,
}

/// Measured forces (N) of both tests, `[test][specimen][sample]`.
pub fn measured_n(drawn: &Drawn, tests: &[Test; 2], readings_n: &[Vec<f64>]) -> Vec<Vec<Vec<f64>>> {
    let mut random = Random::new(drawn.noise_seed);
    let mut specimens = batch(drawn, &mut random);
    let mut all = Vec::new();
    for (index, (test, reading)) in tests.iter().zip(readings_n).enumerate() {
        if index > 0 && !drawn.same_specimens {
            specimens = batch(drawn, &mut random);
        }
        let one = |s: &Specimen, random: &mut Random| -> Vec<f64> {
            let value = |(t, f): (&f64, &f64)| {
                // Shapes differ with the logarithm of the time: 0 at 0.1 s, 1 at 100 s after the ramp.
                let decades = ((t - test.ramp_end_s).max(0.1).log10() + 1.0) / 3.0;
                s.height * f * (1.0 + s.late * decades) + WHITE_N * random.normal()
            };
            test.time_s.iter().zip(reading).map(value).collect()
        };
        all.push(specimens.iter().map(|s| one(s, &mut random)).collect());
    }
    all
}

/// Height that the specimens of both tests share: their geometric mean over the nominal one. No data tell it from the moduli. The
/// first test has `points` samples.
pub fn shared_height(drawn: &Drawn, points: usize) -> f64 {
    let mut random = Random::new(drawn.noise_seed);
    let mean = |batch: &[Specimen]| batch.iter().map(|s| s.height.ln()).sum::<f64>() / COUNT as f64;
    let first = mean(&batch(drawn, &mut random));
    if drawn.same_specimens {
        return first.exp();
    }
    (0..COUNT * points).for_each(|_| {
        random.normal();
    });
    (0.5 * (first + mean(&batch(drawn, &mut random)))).exp()
}

fn batch(drawn: &Drawn, random: &mut Random) -> Vec<Specimen> {
    let mut one = || Specimen {
        height: (drawn.height_scatter * random.normal()).exp(),
        late: drawn.shape_scatter * random.normal(),
    };
    (0..COUNT).map(|_| one()).collect()
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
    use crate::challenge::simulate::tests;

    /// Goal: the height is that of the specimens that were measured. Reference: the mean of the measured curves where all force is 1 N
    /// long after the ramp, 10 specimens and hundreds of points: its noise is below 1e-5.
    #[test]
    fn the_shared_height_is_that_of_what_was_measured() {
        let mut drawn = draw(3, 1, &[]).remove(0);
        drawn.shape_scatter = 0.0;
        let tests = tests(1).unwrap();
        let ones: Vec<Vec<f64>> = tests.iter().map(|t| vec![1.0; t.time_s.len()]).collect();
        for same in [true, false] {
            drawn.same_specimens = same;
            let measured = measured_n(&drawn, &tests, &ones);
            let log_height =
                |specimen: &Vec<f64>| (specimen.iter().sum::<f64>() / specimen.len() as f64).ln();
            let heights: Vec<f64> = measured.iter().flatten().map(log_height).collect();
            let mean = heights.iter().sum::<f64>() / heights.len() as f64;
            assert!((shared_height(&drawn, ones[0].len()) - mean.exp()).abs() < 1e-5);
        }
    }
}
