//! Drainage of bottom and side: whether the fluid can leave there.

use super::descriptor::{Effect, Place, one_sided, switch};

/// The declaration.
pub const EFFECT: Effect = Effect::new("drainage", "drainage of bottom and side", Place::Contact)
    .physics(
        "A sample on glass cannot drain through its bottom, one in a tight dish not through its side. \
         The pore pressure then falls only towards the free top.",
    )
    .revealed_by(
        "Late consolidation over the sample's own length, if it is permeable enough for that within the \
         test.",
    )
    .mimicked_by(
        "Permeability and specimen size; nothing to see while lambda* = 1e5 Pa.",
        &["lambda_star", "drained_punch", "specimen_size"],
    )
    .variants(&[
        one_sided("bottom", &[switch("boundary.drained_bottom", 1.0, 0.0)]),
        one_sided("side", &[switch("boundary.drained_side", 1.0, 0.0)]),
    ]);
