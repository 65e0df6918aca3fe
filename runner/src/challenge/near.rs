//! Causes of the near ground.

use super::form::Form;
use crate::data::random::Random;

/// Sizes of effects in plausible scales, drawn evenly in the logarithm.
pub const SIZES: (f64, f64) = (0.7, 4.0);
/// Number of effects in [`inside`].
pub const INSIDE: usize = 10;
/// Number of causes in [`outside`].
pub const OUTSIDE: usize = 5;

/// An effect of the catalogue, of a size between these (in plausible scales).
pub fn inside(which: usize, sizes: (f64, f64), random: &mut Random) -> Form {
    let size = sizes.0 * (sizes.1 / sizes.0).powf(random.uniform());
    let signed = if random.uniform() < 0.5 { -size } else { size };
    match which {
        0 => Form::SaturatingDrift { rate: 2e-6 * signed, time_s: random.between(150.0, 600.0) },
        1 => Form::TwoPoleLag { time_s: 0.05 * size },
        // The tests start 0.1 mm above the surface: a higher one must not reach the punch.
        2 => Form::ShiftedSurface { height: 2e-5 * signed.min(4.0) },
        3 => Form::Batch { log_factor: 0.15 * signed.clamp(-4.0, 4.0) },
        4 => Form::SlowBranch { mu: -40.0 * size, eta: 60.0 * size * random.between(150.0, 600.0) },
        5 => Form::Flow { inverse_stress: 5e-3 * size },
        6 => {
            let loss = if sizes.1 < 1.0 { 0.3 * size } else { 0.15 + 0.3 * random.uniform() };
            Form::Damage { loss, strain: random.between(0.1, 0.4) }
        }
        7 => Form::Ageing { rate: 2e-4 * signed },
        8 => Form::Frame { per_newton: 3e-3 * size },
        _ => Form::SoftSkeleton { lambda: 1e5 * (0.02_f64).powf(0.5 * size.min(2.5)) },
    }
}

/// A cause outside the catalogue.
pub fn outside(random: &mut Random) -> Form {
    let size = 0.7 + 2.3 * random.uniform();
    match random.below(OUTSIDE) {
        0 => Form::Overshoot { length: 2e-5 * size, frequency: 2.0 + 3.0 * random.uniform(), decay_s: 0.3 },
        1 => Form::WarmingFrame { length: 3e-5 * size, time_s: 5.0 + 30.0 * random.uniform() },
        2 => Form::Meniscus { force: 2e-4 * size },
        3 => Form::Hum { force: 1e-4 * size, period_s: 3.0 + 20.0 * random.uniform() },
        _ => Form::GainStep { part: 0.03 * size, from_s: 3.0 + 10.0 * random.uniform(), to_s: 40.0 },
    }
}
