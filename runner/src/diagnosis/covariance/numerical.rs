//! Error of the simulation: slow along a curve, so it does not average out over the points.

use super::super::observation::Observation;
use super::Common;
use nalgebra::DVector;

/// Relative error per decade of time that is left between two correct programs at their usual accuracy
/// (design, section 6: 0.2 to 0.8 % in the force, most of it a common factor that the moduli absorb).
const RELATIVE: f64 = 1e-3;

/// Hat functions over the decades of the time since touch, each 1 at its knot and 0 at the next ones: a basis for
/// whatever changes slowly along a cycle. One row per knot.
pub fn hats(observation: &Observation, cycle: usize, per_decade: f64) -> Vec<DVector<f64>> {
    let decade = |i: usize| per_decade * observation.since_touch_s(i).max(FIRST_S).log10();
    let points = || (0..observation.len()).filter(|&i| observation.cycle[i] == cycle);
    let first = (per_decade * FIRST_S.log10()).floor() as i32;
    let last = points().map(decade).fold(f64::from(first), f64::max).ceil() as i32;
    let hat = |knot: i32| {
        let mut shape = DVector::zeros(observation.len());
        for i in points() {
            shape[i] = (1.0 - (decade(i) - f64::from(knot)).abs()).max(0.0);
        }
        shape
    };
    (first..=last).map(hat).filter(|h| h.amax() > 0.0).collect()
}

/// Time since touch that the first knot stands for (s).
const FIRST_S: f64 = 1e-2;

/// The error as one independent error per decade and cycle, in proportion to the computed force (mN).
pub fn slow_errors(observation: &Observation, force_mn: &DVector<f64>) -> Vec<Common> {
    let of_cycle = |cycle: usize| {
        hats(observation, cycle, 1.0).into_iter().enumerate().map(move |(knot, hat)| Common {
            name: format!("simulation of {}, cycle {}, part {}", observation.name(), cycle + 1, knot + 1),
            shape_mn: hat.component_mul(force_mn) * RELATIVE,
        })
    };
    let all = (0..observation.cycles.len()).flat_map(of_cycle);
    all.filter(|c| c.shape_mn.amax() > 0.0).collect()
}

/// The difference that a refinement makes, as an error of that size. `None` where it makes none.
pub fn refinement(name: &str, coarse_mn: &[f64], fine_mn: &[f64]) -> Option<Common> {
    let shape_mn = DVector::from_iterator(coarse_mn.len(), fine_mn.iter().zip(coarse_mn).map(|(f, c)| f - c));
    (shape_mn.amax() > 0.0).then(|| Common { name: name.to_owned(), shape_mn })
}
