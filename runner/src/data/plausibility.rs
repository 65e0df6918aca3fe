//! What may be read and is still no measurement of a test: told in plain words before anything is fitted.

use super::error::Problem;
use super::measurement::Measurement;
use super::motion::sample_noise;

/// Larger values are no laboratory's: seconds, metres, newtons.
const LARGEST: [f64; 3] = [1e9, 10.0, 1e6];
/// Numbers that programs write where they have none.
const SENTINELS: [f64; 5] = [-9999.0, -99999.0, -999_999.0, 9_999_999.0, -9999.9];
/// So many equal largest values in a row are a limit of the instrument ...
const CLIPPED: usize = 8;
/// ... where at most this part of other neighbours are equal.
const EQUAL: f64 = 0.1;
/// A pause so many times longer than those before and after it is a gap.
const GAP: f64 = 10.0;

/// Whether a value in SI is beyond everything (`kind`: 0 time, 1 displacement, 2 force).
pub fn is_absurd(value: f64, kind: usize) -> bool {
    value.abs() > LARGEST[kind.min(2)]
}

/// Whether a value, as written, stands for none: it is one of the known, and its neighbour is far from it.
pub fn is_sentinel(value: f64, before: Option<f64>) -> bool {
    SENTINELS.contains(&value) && before.is_none_or(|b| (b - value).abs() > 0.1 * value.abs())
}

/// Two specimens that are one.
///
/// # Errors
/// Names the two.
pub fn check_specimens(m: &Measurement) -> Result<(), Problem> {
    for (k, specimen) in m.specimens_n.iter().enumerate() {
        let same = |other: &Vec<f64>| other == specimen && specimen.iter().any(|f| *f != specimen[0]);
        if let Some(first) = m.specimens_n[..k].iter().position(same) {
            let name = |i: usize| m.specimen_names.get(i).cloned().unwrap_or_else(|| format!("{}", i + 1));
            return Err(Problem::SameTwice { first: name(first), second: name(k) });
        }
    }
    Ok(())
}

/// What a reader should know before believing a result.
pub fn warnings(m: &Measurement) -> Vec<String> {
    let mut found = Vec::new();
    if let Some((force_n, samples)) = clipped(m) {
        found.push(format!(
            "the force stays at exactly {:.4} mN over {samples} samples at its largest: is the load cell at its limit?",
            force_n * 1e3
        ));
    }
    found.extend(jump(m).map(|i| {
        let line = m.lines.get(i + 1).map_or_else(String::new, |l| format!(" (line {l})"));
        format!(
            "the clock jumps by {:.3} s at {:.3} s{line}: are samples missing?",
            m.time_s[i + 1] - m.time_s[i],
            m.time_s[i]
        )
    }));
    if m.spread_n.as_ref().is_some_and(|s| s.iter().all(|v| *v == 0.0)) {
        found.push("every spread is zero: it says nothing about the noise (--noise none)".to_owned());
    }
    if m.specimens_n.len() == 2 {
        found.push(
            "two specimens tell little about their spread: intervals from it may be far off".to_owned(),
        );
    }
    found
}

/// Largest value that many samples share, where samples differ otherwise.
fn clipped(m: &Measurement) -> Option<(f64, usize)> {
    let largest = m.force_n.iter().copied().max_by(f64::total_cmp)?;
    let (mut run, mut longest) = (0, 0);
    for f in &m.force_n {
        run = if *f == largest { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    let others = m.force_n.windows(2).filter(|w| w[0] != largest && w[1] != largest);
    let (mut equal, mut count) = (0, 0);
    for w in others {
        count += 1;
        equal += usize::from(w[0] == w[1]);
    }
    let rare = count >= 20 && (equal as f64) < EQUAL * f64::from(count);
    (longest >= CLIPPED && rare).then_some((largest, longest))
}

/// Samples that stand alone: far from both neighbours, which are close to each other and to theirs.
pub fn outliers(time_s: &[f64], force_n: &[f64]) -> Vec<usize> {
    const SIGMA: f64 = 8.0;
    const ALONE: f64 = 5.0;
    let points: Vec<(f64, f64)> = time_s.iter().copied().zip(force_n.iter().copied()).collect();
    let noise = sample_noise(&points);
    let step = |a: usize, b: usize| force_n[b] - force_n[a];
    let stands_out = |&i: &usize| {
        let (before, after) = (step(i - 1, i), step(i + 1, i));
        let near = step(i - 2, i - 1).abs().max(step(i + 1, i + 2).abs()).max(step(i - 1, i + 1).abs());
        before * after > 0.0 && before.abs().min(after.abs()) > (SIGMA * noise).max(ALONE * near)
    };
    (2..force_n.len().saturating_sub(2)).filter(stands_out).collect()
}

/// Sample before a gap between samples that are close to each other on both sides.
fn jump(m: &Measurement) -> Option<usize> {
    let steps: Vec<f64> = m.time_s.windows(2).map(|w| w[1] - w[0]).collect();
    let is_gap = |&i: &usize| {
        let near = |range: std::ops::Range<usize>| range.map(|k| steps[k]).fold(0.0, f64::max);
        steps[i] > GAP * near(i - 3..i) && steps[i] > GAP * near(i + 1..i + 4)
    };
    (3..steps.len().saturating_sub(4)).find(is_gap)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measurement() -> Measurement {
        let time_s: Vec<f64> = (0..100).map(|i| 0.1 * f64::from(i)).collect();
        let force_n = time_s.iter().map(|t| 1e-3 * t.sin()).collect();
        Measurement { displacement_m: time_s.clone(), force_n, time_s, ..Measurement::default() }
    }

    #[test]
    fn plausible_data_are_left_alone() {
        assert!(warnings(&measurement()).is_empty());
        assert!(!is_sentinel(-9999.0, Some(-9998.0)) && !is_absurd(1.0, 1));
    }

    #[test]
    fn limits_gaps_and_spreads_are_told() {
        let mut m = measurement();
        m.force_n.iter_mut().for_each(|f| *f = f.min(0.8e-3));
        assert!(warnings(&m)[0].contains("exactly 0.8000 mN"), "{:?}", warnings(&m));
        let mut m = measurement();
        m.time_s.iter_mut().skip(50).for_each(|t| *t += 5.0);
        assert!(warnings(&m)[0].contains("jumps by 5.100 s at 4.900 s"), "{:?}", warnings(&m));
        let mut m = measurement();
        m.spread_n = Some(vec![0.0; 100]);
        m.specimens_n = vec![m.force_n.clone(), m.time_s.clone()];
        assert_eq!(warnings(&m).len(), 2);
    }

    #[test]
    fn a_sample_that_stands_alone_is_an_outlier_and_a_peak_is_none() {
        let mut m = measurement();
        assert!(outliers(&m.time_s, &m.force_n).is_empty());
        m.force_n[40] += 1e-3;
        assert_eq!(outliers(&m.time_s, &m.force_n), [40]);
        let peak: Vec<f64> =
            (0..100).map(|i| if i < 50 { f64::from(i) } else { f64::from(100 - i) }).collect();
        assert!(outliers(&m.time_s, &peak).is_empty());
    }

    #[test]
    fn one_specimen_under_two_names_is_refused() {
        let mut m = measurement();
        m.specimens_n = vec![m.force_n.clone(), m.time_s.clone(), m.force_n.clone()];
        m.specimen_names = ["s01", "s02", "s03"].map(str::to_owned).to_vec();
        let problem = check_specimens(&m).unwrap_err();
        assert_eq!(problem, Problem::SameTwice { first: "s01".into(), second: "s03".into() });
    }

    #[test]
    fn what_stands_for_nothing_or_is_beyond_everything() {
        assert!(is_sentinel(-9999.0, Some(1.0)) && is_absurd(1e30, 2) && is_absurd(100.0, 1));
    }
}
