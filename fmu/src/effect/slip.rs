//! Frictionless or partly slipping punch: a thin shear layer between punch and sample.
//!
//! The traction `t_r = -u_r / c` per reference area holds the face of the sample back, `c` the layer's
//! compliance: 0 is the bonded punch, infinity the frictionless one. The layer is elastic and its energy is
//! not among the outputs. It ends where the surface has left the punch.

use super::descriptor::{Effect, Place, linear, one_sided, switch};
use super::parameter::parameters;
use crate::unit::METRE_PER_PASCAL;

parameters! {
    /// Compliance of the layer.
    slip:
    /// Compliance of a thin shear layer under the bonded punch: radial slip per shear traction
    compliance: real(METRE_PER_PASCAL, (0.0, 1e6)) = 0.0;
}

/// The declaration.
pub const EFFECT: Effect = Effect::new("slip", "frictionless or partly slipping punch", Place::Contact)
    .physics(
        "The wet surface slides under the punch, held back by a thin shear layer. Without any bond the \
         force is some per cent less and the edge's singularity weaker.",
    )
    .revealed_by("Next to nothing in the force; a picture of the contact's edge.")
    .mimicked_by("All moduli together, amplitude.", &["amplitude", "specimen_size"])
    .variants(&[
        one_sided("partial", &[linear("effect.slip.compliance", 0.0, 1e-6)]),
        one_sided("frictionless", &[switch("boundary.bonded_punch", 1.0, 0.0)]),
    ]);
