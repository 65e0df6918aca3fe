//! What is not known of the motion: a single record tells where the surface lies only to the depth at which its force leaves the
//! noise, and a model that follows the straight pieces of a motion misses what the recorded one did beside them.

use super::Common;
use super::observation::Observation;
use crate::data::Phase;
use nalgebra::DVector;

/// A force of so many deviations of a sample is no noise.
const BEYOND_NOISE: f64 = 3.0;
/// A punch that is slower than this part of its fastest in a phase comes to rest: its force no longer tells a stiffness.
const MOVES: f64 = 0.5;

/// Change of the computed force `force_mn` (mN) by a depth that is larger from the touch on (mN/m), at each point.
///
/// While the punch moves an earlier touch shifts the force by time, `(dF/dt) / (dd/dt)`; at rest the force relaxes in proportion,
/// and the ratio to it stays what it was when the motion ended.
fn stiffness(observation: &Observation, depth_m: &[f64], force_mn: &DVector<f64>) -> DVector<f64> {
    let (n, time_s) = (depth_m.len(), &observation.time_s);
    let fastest = |range: std::ops::Range<usize>| {
        let speed = |i: usize| ((depth_m[i + 1] - depth_m[i]) / (time_s[i + 1] - time_s[i])).abs();
        range.clone().take(range.len().saturating_sub(1)).map(speed).fold(0.0, f64::max)
    };
    let mut relative = 0.0;
    let mut stiffness = DVector::zeros(n);
    for leg in phases(observation) {
        let moves = matches!(observation.phases[leg.start], Phase::Ramp | Phase::Unload);
        let least = if moves { MOVES * fastest(leg.clone()) } else { f64::INFINITY };
        for i in leg.clone() {
            let (before, after) = (i.saturating_sub(1).max(leg.start), (i + 1).min(leg.end - 1));
            let path_m = depth_m[after] - depth_m[before];
            let in_contact = depth_m[before].min(depth_m[after]) > 0.0 && force_mn[i] > 0.0;
            if in_contact && path_m.abs() >= least * (time_s[after] - time_s[before]) && path_m != 0.0 {
                relative = ((force_mn[after] - force_mn[before]) / (path_m * force_mn[i])).max(0.0);
            }
            stiffness[i] = relative * force_mn[i].max(0.0);
        }
    }
    stiffness
}

/// Points of each phase of each cycle.
fn phases(observation: &Observation) -> Vec<std::ops::Range<usize>> {
    let part = |i: usize| (observation.cycle[i], observation.phases[i]);
    let mut legs = Vec::new();
    let mut begin = 0;
    while begin < observation.len() {
        let end = (begin..observation.len()).find(|&i| part(i) != part(begin)).unwrap_or(observation.len());
        legs.push(begin..end);
        begin = end;
    }
    legs
}

/// Depth (m) of the motion that the model follows, at each point.
fn followed(observation: &Observation) -> Vec<f64> {
    observation.time_s.iter().map(|t| observation.protocol.displacement(*t)).collect()
}

/// Deviation of the force (mN) by what the recorded motion does beside the one that the model follows: root mean square of their
/// distance over each phase of each cycle, times the stiffness.
pub fn beside_the_path(observation: &Observation, force_mn: &DVector<f64>) -> DVector<f64> {
    let depth_m = followed(observation);
    let stiffness = stiffness(observation, &depth_m, force_mn);
    let mut deviation_mn = DVector::zeros(depth_m.len());
    for leg in phases(observation) {
        let apart = |i: usize| (observation.measurement.displacement_m[i] - depth_m[i]).powi(2);
        let distance_m = (leg.clone().map(apart).sum::<f64>() / leg.len() as f64).sqrt();
        leg.for_each(|i| deviation_mn[i] = stiffness[i] * distance_m);
    }
    deviation_mn
}

/// The error of one record's zero of the depth: the change of the computed force `force_mn` (mN) by the depth at which it has
/// grown to [`BEYOND_NOISE`] deviations of a sample, `white_mn` (mN).
#[derive(Debug, Clone)]
pub struct ZeroOfDepth {
    /// What it does to the shape of the curve.
    pub shape: Common,
    /// What it does to the height of the hold: the moduli take that up, as they do with the height of the specimens.
    pub height: Common,
}

impl ZeroOfDepth {
    /// Of a test; none where no force grows, and where the file tells by several specimens, or by a spread, how much tests differ.
    pub fn of(observation: &Observation, force_mn: &DVector<f64>, white_mn: &DVector<f64>) -> Option<Self> {
        if !observation.factors.is_empty() || observation.measurement.spread_n.is_some() {
            return None;
        }
        let depth_m = followed(observation);
        let is_ramp = |i: &usize| observation.cycle[*i] == 0 && observation.phases[*i] == Phase::Ramp;
        let is_seen = |i: &usize| force_mn[*i] > BEYOND_NOISE * white_mn[*i];
        let seen = (1..depth_m.len()).filter(is_ramp).find(is_seen)?;
        // Between two samples the force is taken as straight.
        let (low, high) = (force_mn[seen - 1], force_mn[seen]);
        let share = ((BEYOND_NOISE * white_mn[seen] - low) / (high - low)).clamp(0.0, 1.0);
        let above = depth_m[seen - 1].max(0.0);
        let error_m = above + share * (depth_m[seen] - above);
        let change_mn = stiffness(observation, &depth_m, force_mn) * error_m;
        let end = (0..depth_m.len()).rfind(is_ramp)?;
        let height_mn = force_mn * (change_mn[end] / force_mn[end].max(f64::MIN_POSITIVE));
        let name = format!("zero of the depth of {}", observation.name());
        let is_error = change_mn.amax() > 0.0 && height_mn.amax().is_finite();
        is_error.then(|| Self {
            shape: Common::additive(name.clone(), change_mn - &height_mn),
            height: Common::proportional(name, height_mn),
        })
    }
}
