//! How large a difference between two curves is.

use crate::noise::{Observation, hats_after_kinks};
use nalgebra::DVector;

/// Points, by weight, that a mean needs: of fewer it is the noise's.
const FEWEST: f64 = 3.0;

/// Largest mean of a difference (mN, all tests one after the other) over half a decade of the time since any kink of the motion, as
/// part of its test's largest force (%).
pub fn gap_percent(observations: &[Observation], difference_mn: &DVector<f64>) -> f64 {
    let (mut largest, mut before) = (0.0_f64, 0);
    for o in observations {
        let peak_mn = o.force_mn().iter().fold(0.0_f64, |peak, f| peak.max(f.abs()));
        let own_mn = difference_mn.rows(before, o.len());
        let hats = hats_after_kinks(o).into_iter().map(|(_, hat)| hat).filter(|hat| hat.sum() >= FEWEST);
        let means = hats.map(|hat| 100.0 * (hat.dot(&own_mn) / hat.sum()).abs() / peak_mn);
        largest = means.fold(largest, f64::max);
        before += o.len();
    }
    largest
}
