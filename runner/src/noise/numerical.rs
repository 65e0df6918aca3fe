//! Error of the simulation: slow along a curve, so it does not average out over the points.

use super::Common;
use super::observation::Observation;
use crate::data::Phase;
use crate::data::measurement::median;
use nalgebra::DVector;
use std::collections::BTreeMap;

/// Relative error that is left between two correct programs at their usual accuracy (design, section 6: 0.2 to 0.8 % in the
/// force; late in a hold, 0.1 to 0.3 % of the peak), independent from one knot to the next.
const RELATIVE: f64 = 5e-3;
/// What two correct programs differ by while contact is lost, or made on a surface that still recovers, as part of the peak: contact
/// that sticks without a limit against friction 1 moves the end of an unloading by 0.16 % of the peak (`coarse`; `fine` 0.24 %).
const CONTACT: f64 = 2e-3;
/// Contact changes while the force is about this part of the peak or less.
const CHANGING: f64 = 0.1;
/// Knots per decade of time.
pub const PER_DECADE: f64 = 2.0;

/// Part of that error which one cycle does not share with the others: a program makes the same error in the same
/// motion, but for what it remembers of the cycles before.
const OWN: f64 = 0.4;

/// Hat functions over the decades of the time since touch, each 1 at its knot and 0 at the next ones: a basis for
/// whatever changes slowly along a cycle. One row per knot.
pub fn hats(observation: &Observation, cycle: usize, per_decade: f64) -> Vec<DVector<f64>> {
    hats_by_knot(observation, cycle, per_decade).into_values().collect()
}

/// The same with their knots.
pub fn hats_by_knot(observation: &Observation, cycle: usize, per_decade: f64) -> BTreeMap<i32, DVector<f64>> {
    let decade = |i: usize| per_decade * observation.since_touch_s(i).max(FIRST_S).log10();
    let points = || (0..observation.len()).filter(|&i| observation.cycle[i] == cycle);
    let first = (per_decade * FIRST_S.log10()).floor() as i32;
    let last = points().map(decade).fold(f64::from(first), f64::max).ceil() as i32;
    let hat = |knot: i32| {
        let mut shape = DVector::zeros(observation.len());
        for i in points() {
            shape[i] = hat_at(decade(i), knot);
        }
        (knot, shape)
    };
    (first..=last).map(hat).filter(|(_, h)| h.amax() > 0.0).collect()
}

/// Value of the hat function that is 1 at its knot and 0 at the next ones.
pub fn hat_at(place: f64, knot: i32) -> f64 {
    (1.0 - (place - f64::from(knot)).abs()).max(0.0)
}

/// Sums of the shapes with the same key: what all cycles have in common.
pub fn sum_by_key<'a, K: Ord>(
    shapes: impl IntoIterator<Item = (K, &'a DVector<f64>)>,
) -> BTreeMap<K, DVector<f64>> {
    let mut sums: BTreeMap<K, DVector<f64>> = BTreeMap::new();
    for (key, shape) in shapes {
        sums.entry(key).and_modify(|sum| *sum += shape).or_insert_with(|| shape.clone());
    }
    sums
}

/// Time since touch that the first knot stands for (s).
const FIRST_S: f64 = 1e-2;

/// The error of the simulation: independent errors after each kink, as parts of the computed force (mN).
pub fn slow_errors(observation: &Observation, force_mn: &DVector<f64>) -> Vec<Common> {
    errors_after_kinks(observation, force_mn, (RELATIVE, PER_DECADE), "simulation")
        .map(|c| Common { relative: true, ..c })
        .collect()
}

/// The form of a contact that is lost, or made again: errors of a size that does not go to zero with the force.
pub fn contact_errors<'a>(
    observation: &'a Observation,
    force_mn: &DVector<f64>,
) -> impl Iterator<Item = Common> + use<'a> {
    let peak_mn = force_mn.max();
    let changes = |i: usize| match observation.phases[i] {
        Phase::Unload => true,
        Phase::Approach | Phase::Ramp => observation.cycle[i] > 0,
        _ => false,
    };
    let size_mn = |i: usize| {
        let is_held = force_mn[i] > 0.0 && peak_mn > 0.0 && changes(i);
        if is_held { peak_mn * (-force_mn[i] / (CHANGING * peak_mn)).exp() } else { 0.0 }
    };
    let curve_mn = DVector::from_fn(force_mn.len(), |i, _| size_mn(i));
    errors_after_kinks(observation, &curve_mn, (CONTACT, PER_DECADE), "contact")
        .collect::<Vec<_>>()
        .into_iter()
}

/// Independent errors over the time since each kink of the motion, where every program begins anew with small steps and every
/// effect with its fastest part, each of a size that is this part of `curve_mn` (mN), with so many knots per decade. The cycles
/// share them but for `OWN` of them: taken as independent, they would average out over the cycles.
pub fn errors_after_kinks(
    observation: &Observation,
    curve_mn: &DVector<f64>,
    (part, per_decade): (f64, f64),
    what: &str,
) -> impl Iterator<Item = Common> {
    let error = move |name: String, shape: DVector<f64>, share: f64| {
        let name = format!("{what} of {}, {name}", observation.name());
        Common::additive(name, shape.component_mul(curve_mn) * (share * part)).of_the_model()
    };
    let own = if observation.cycles.len() > 1 { OWN } else { 0.0 };
    let hats = hats_after_kinks(observation, per_decade);
    let shared = sum_by_key(hats.iter().map(|((_, leg, knot), hat)| ((*leg, *knot), hat)));
    let common = (1.0 - own * own).sqrt();
    let of_one = move |((cycle, leg, knot), hat)| {
        error(format!("cycle {}, leg {leg}, knot {knot}", cycle + 1), hat, own)
    };
    let of_all = move |((leg, knot), sum)| error(format!("leg {leg}, knot {knot}"), sum, common);
    let single = hats.into_iter().filter(move |_| own > 0.0).map(of_one);
    single.chain(shared.into_iter().map(of_all)).filter(|c| c.shape_mn.amax() > 0.0)
}

/// Hat functions over the decades of the time since the kink that begins each leg of the motion: cycle, leg, knot.
pub fn hats_after_kinks(observation: &Observation, per_decade: f64) -> Vec<((usize, u8, i32), DVector<f64>)> {
    let n = observation.len();
    let time_s = &observation.time_s;
    let leg = |i: usize| (observation.cycle[i], leg(observation.phases[i]));
    let mut all = Vec::new();
    let mut begin = 0;
    while begin < n {
        let end = (begin..n).find(|&i| leg(i) != leg(begin)).unwrap_or(n);
        let kink_s = time_s[begin.saturating_sub(1)];
        let decade = |i: usize| per_decade * (time_s[i] - kink_s).max(FIRST_S).log10();
        let (first, last) = (per_decade * FIRST_S.log10(), decade(end - 1));
        for knot in first.floor() as i32..=last.ceil() as i32 {
            let mut hat = DVector::zeros(n);
            for i in begin..end {
                hat[i] = hat_at(decade(i), knot);
            }
            let (cycle, leg) = leg(begin);
            all.push(((cycle, leg, knot), hat));
        }
        begin = end;
    }
    all
}

/// Straight part of the motion that a phase belongs to.
fn leg(phase: Phase) -> u8 {
    match phase {
        Phase::Approach => 0,
        Phase::Ramp => 1,
        Phase::HoldEarly | Phase::HoldMiddle | Phase::HoldLate => 2,
        Phase::Unload => 3,
        Phase::Recovery => 4,
    }
}

/// Force and displacement of a sample belong to times that are known to a part of the sampling interval: the kinks of
/// the motion lie anywhere between two samples. `dF/dt` times the deviation of a uniform distribution over the
/// interval of the ramp (mN).
pub fn timing(observation: &Observation, force_mn: &DVector<f64>) -> Option<Common> {
    let (t, n) = (&observation.time_s, observation.len());
    let ramp: Vec<usize> = (1..n).filter(|&i| observation.phases[i] == Phase::Ramp).collect();
    if ramp.is_empty() {
        return None;
    }
    let interval = median(&mut ramp.iter().map(|&i| t[i] - t[i - 1]).collect::<Vec<_>>());
    let sigma_s = interval / 12f64.sqrt();
    let between = |i: usize| (force_mn[i + 1] - force_mn[i]) / (t[i + 1] - t[i]);
    // The smaller of both sides' slopes, none at a peak: before the first touch no shift makes a force.
    let slope = |i: usize| {
        if i == 0 || i + 1 >= n {
            return 0.0;
        }
        let (left, right) = (between(i - 1), between(i));
        if left * right <= 0.0 { 0.0 } else { left.signum() * left.abs().min(right.abs()) }
    };
    let shape_mn = DVector::from_fn(n, |i, _| sigma_s * slope(i));
    Some(Common::proportional(format!("timing of {}", observation.name()), shape_mn))
}

/// The difference that a refinement makes, as an error of that size. `None` where it makes none.
pub fn refinement(name: &str, coarse_mn: &[f64], fine_mn: &[f64]) -> Option<Common> {
    let shape_mn = DVector::from_iterator(coarse_mn.len(), fine_mn.iter().zip(coarse_mn).map(|(f, c)| f - c));
    (shape_mn.amax() > 0.0).then(|| Common::proportional(name.to_owned(), shape_mn).of_the_model())
}
