//! Causes of the wide ground: every effect of the catalogue in the independent solver's forms, and what the catalogue does not have.

use super::cause::{Cause, Flaw};
use crate::data::random::Random;
use poropunch_maker::Effect;

/// Sizes of effects in plausible scales, drawn evenly in the logarithm.
pub const SIZES: (f64, f64) = (1.0 / 3.0, 10.0);
/// Number of effects in [`inside`]: the whole catalogue.
pub const INSIDE: usize = 17;
/// Number of causes in [`outside`].
pub const OUTSIDE: usize = 14;

/// A skeleton with a fiftieth of lambda*: with less of it the specimen folds at the punch's edge.
const MOST_COMPRESSIBLE: f64 = 1.0;
/// 30 % of the stress: what softens more has no stable equilibrium at the punch's edge.
const MOST_SOFTENED: f64 = 1.0;
/// Half as large: a smaller one ends near the punch's edge.
const SMALLEST: f64 = 1.0;
/// Eight times as large: a half-space, as every larger one is.
const LARGEST: f64 = 3.0;
/// 0.08 mm: the tests start 0.1 mm above the surface, and a higher one must not reach the punch.
const HIGHEST_SURFACE: f64 = 4.0;
/// Triangles sixteen times as long at the edge: larger ones are not refined there at all.
const COARSEST: f64 = 2.0;
/// Peak of Table 1's force (N).
const PEAK_N: f64 = 11e-3;

/// An effect of the catalogue, of a size between these (in plausible scales), for stresses `stress` times Table 1's: what is a stress
/// or a force in it grows as much.
pub fn inside(which: usize, sizes: (f64, f64), stress: f64, random: &mut Random) -> Effect {
    let sign = if random.uniform() < 0.5 { -1.0 } else { 1.0 };
    let second = random.uniform() < 0.5;
    let slow_s = random.between(150.0, 600.0);
    let mut up_to = |most: f64| random.between(sizes.0.min(most), sizes.1.min(most));
    match which {
        0 => Effect::SlowPair { size: stress * up_to(f64::INFINITY), time_s: slow_s },
        1 => Effect::Carreau { size: up_to(f64::INFINITY) / stress },
        2 => Effect::ExponentialPermeability { size: up_to(f64::INFINITY) },
        3 => Effect::LogarithmicSkeleton { size: up_to(MOST_COMPRESSIBLE) },
        4 => Effect::EnergySoftening { size: up_to(MOST_SOFTENED) },
        5 => Effect::SaturatingAgeing { size: sign * up_to(f64::INFINITY), time_s: slow_s },
        6 => Effect::Batch { size: sign * up_to(f64::INFINITY) },
        7 => Effect::Dimensions { size: if sign < 0.0 { -up_to(SMALLEST) } else { up_to(LARGEST) } },
        8 if second => Effect::Film { size: up_to(f64::INFINITY) / stress },
        // From the plain model's coefficient of 1 through 0.1 at the plausible scale towards none.
        8 => Effect::LowFriction { coefficient: 1.0 / (1.0 + 9.0 * up_to(f64::INFINITY)) },
        9 => Effect::LeakyFace { size: up_to(f64::INFINITY) },
        10 if second => Effect::TightBottom { size: up_to(f64::INFINITY) },
        10 => Effect::TightSide { size: up_to(f64::INFINITY) },
        11 => Effect::ExponentialAdhesion { size: stress * up_to(f64::INFINITY) },
        12 => {
            let most = if sign > 0.0 { HIGHEST_SURFACE } else { f64::INFINITY };
            Effect::ShiftedSurface { size: sign * up_to(most) }
        }
        13 => Effect::StiffeningFrame { size: up_to(f64::INFINITY) / stress, force: PEAK_N * stress },
        14 => Effect::SaturatingDrift { size: sign * stress * up_to(f64::INFINITY), time_s: slow_s },
        15 => Effect::TwoPoleLag { size: up_to(f64::INFINITY) },
        _ => Effect::Coarse { size: up_to(COARSEST) },
    }
}

/// A cause outside the catalogue, for stresses so many times Table 1's.
pub fn outside(stress: f64, random: &mut Random) -> Cause {
    let size = 0.7 + 2.3 * random.uniform();
    let force = stress * size;
    let sign = if random.uniform() < 0.5 { -1.0 } else { 1.0 };
    // After the first ramp.
    let time_s = random.between(6.0, 60.0);
    let phase = std::f64::consts::TAU * random.uniform();
    Cause::Maker(match random.below(OUTSIDE) {
        0 => Effect::Overshoot { length: 2e-5 * size, frequency: random.between(2.0, 5.0), decay_s: 0.3 },
        1 => Effect::WarmingFrame { length: 3e-5 * size, time_s: random.between(5.0, 35.0) },
        2 => Effect::Meniscus { force: 2e-4 * force, reach: random.between(2e-4, 1e-3) },
        // The air conditioning, the mains (aliased by the sampling), the room's temperature.
        3 => Effect::Wave { force: 1e-4 * force, period_s: random.between(3.0, 23.0), phase },
        4 => Effect::Wave { force: 1e-4 * force, period_s: 1.0 / random.between(49.0, 49.9), phase },
        5 => Effect::Wave { force: 1e-4 * force, period_s: random.between(60.0, 400.0), phase },
        6 => Effect::Gain { part: 0.03 * size, from_s: random.between(4.0, 14.0), to_s: 41.0 },
        7 => Effect::GripStep { length: sign * 1e-5 * size, time_s },
        8 => Effect::Tilt { height: 6e-5 * size },
        9 => Effect::Clip { part: 1.0 - 0.06 * size },
        10 => Effect::Clock { rate: 0.01 * size },
        11 => Effect::Bubble { loss: 0.02 * size, time_s },
        // To be seen after a reversal only, in more cycles than one.
        12 => Effect::Backlash { length: 1e-5 * size },
        _ => {
            return Cause::Specimen(Flaw::BadSpecimen {
                loss: 0.15 * size,
                time_s: random.between(3.0, 30.0),
            });
        }
    })
}
