//! Load-cell lag: the law is `crate::sensor::lag`.

use super::descriptor::{Effect, Place, linear, one_sided};
use super::parameter::parameters;
use crate::unit::SECOND;

parameters! {
    /// Time constant of the filter.
    load_cell_lag:
    /// Time constant T of the load cell: its reading y follows the force with T dy/dt = force - y
    time: real(SECOND, (0.0, 1e4)) = 0.0;
}

/// The declaration.
pub const EFFECT: Effect = Effect::new("load_cell_lag", "load-cell lag", Place::Sensor)
    .physics(
        "Cell and filter follow the force with a first-order low pass. Peaks are cut and rounded, and \
         everything fast comes later.",
    )
    .revealed_by(
        "The kink of the force after that of the displacement, a delay in proportion to the rate, a \
         rounded peak.",
    )
    .mimicked_by(
        "The fast branch at the peak; compliance; an offset at one single rate.",
        &["compliance", "offset"],
    )
    .variants(&[one_sided("low pass", &[linear("effect.load_cell_lag.time", 0.0, 0.05)])]);
