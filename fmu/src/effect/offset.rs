//! Contact-point offset: the true surface lies above or below the nominal zero.

use super::descriptor::{Effect, Place, linear, two_sided};
use super::parameter::parameters;
use crate::unit::METRE;

parameters! {
    /// Where the surface is.
    offset:
    /// Height of the true surface above the nominal zero: the sample feels displacement + height
    height: real(METRE, (-1.0, 1.0)) = 0.0;
}

/// The declaration.
pub const EFFECT: Effect = Effect::new("offset", "contact-point offset", Place::Contact)
    .physics(
        "The surface was found at a threshold force, or by eye, and lies elsewhere. Contact begins \
         earlier or later, and every depth is wrong by the same height.",
    )
    .revealed_by("The onset of force in the approach and the foot of the loading ramp.")
    .mimicked_by(
        "Amplitude at the peak alone; a lag shifts the onset in time, in proportion to the rate.",
        &["amplitude", "load_cell_lag", "compliance"],
    )
    .variants(&[two_sided("surface above zero", &[linear("effect.offset.height", 0.0, 2e-5)])]);
