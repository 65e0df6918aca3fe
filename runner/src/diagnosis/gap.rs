//! How large a difference between two curves is.

use crate::inference::fit::Fit;
use crate::inference::white_residual;
use crate::noise::{Observation, PER_DECADE, hats_after_kinks};
use nalgebra::DVector;

/// Points, by weight, that a mean needs: of fewer it is the noise's.
const FEWEST: f64 = 3.0;

/// Largest mean of a difference (mN, all tests one after the other) over half a decade of the time since any kink of the motion, as
/// part of its test's largest force (%).
pub fn gap_percent(observations: &[Observation], difference_mn: &DVector<f64>) -> f64 {
    largest_mean(observations, difference_mn, f64::abs)
}

/// The same of the mean square beyond that of independent noise (`white_mn`), as its root: what swings has no mean.
fn swing_percent(observations: &[Observation], difference_mn: &DVector<f64>, white_mn: &DVector<f64>) -> f64 {
    let beyond = difference_mn.zip_map(white_mn, |d, w| d * d - w * w);
    largest_mean(observations, &beyond, |mean| mean.max(0.0).sqrt())
}

/// What known errors - the heights of the specimens, the simulation's - leave of a fit's gap (%), in its mean or, beyond the noise, in its
/// mean square.
pub fn percent_beside_known_errors(observations: &[Observation], fit: &Fit) -> f64 {
    let white_mn = fit.covariance.white_mn();
    let rest_mn = white_residual(fit).component_mul(white_mn);
    gap_percent(observations, &rest_mn).max(swing_percent(observations, &rest_mn, white_mn))
}

/// Largest size of any mean of some values over half a decade, as part of its test's largest force (%).
fn largest_mean(observations: &[Observation], values: &DVector<f64>, size: impl Fn(f64) -> f64) -> f64 {
    let (mut largest, mut before) = (0.0_f64, 0);
    for o in observations {
        let peak_mn = o.force_mn().iter().fold(0.0_f64, |peak, f| peak.max(f.abs()));
        let own = values.rows(before, o.len());
        let hats =
            hats_after_kinks(o, PER_DECADE).into_iter().map(|(_, hat)| hat).filter(|hat| hat.sum() >= FEWEST);
        let means = hats.map(|hat| 100.0 * size(hat.dot(&own) / hat.sum()) / peak_mn);
        largest = means.fold(largest, f64::max);
        before += o.len();
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Measurement;

    /// A ramp of 1 s and a hold of 9 s at 10 mN.
    fn test() -> Observation {
        let time_s: Vec<f64> = (0..=1000).map(|i| 0.01 * f64::from(i)).collect();
        let m = Measurement {
            displacement_m: time_s.iter().map(|t| 1e-3 * t.min(1.0)).collect(),
            force_n: time_s.iter().map(|t| 1e-2 * t.min(1.0)).collect(),
            time_s,
            ..Measurement::default()
        };
        Observation::new(&m, None).unwrap()
    }

    #[test]
    fn a_swing_has_a_size_but_no_mean() {
        let o = [test()];
        let white_mn = DVector::from_element(o[0].len(), 0.1);
        let swing = DVector::from_fn(o[0].len(), |i, _| if i % 2 == 0 { 0.5 } else { -0.5 });
        assert!(gap_percent(&o, &swing) < 1.0);
        let size = swing_percent(&o, &swing, &white_mn);
        approx::assert_relative_eq!(size, 10.0 * 0.24_f64.sqrt(), max_relative = 1e-9);
        assert_eq!(swing_percent(&o, &(swing * 0.1), &white_mn), 0.0);
    }
}
