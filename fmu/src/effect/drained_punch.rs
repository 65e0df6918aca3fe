//! Drained punch face: a porous or rough punch lets fluid out.

use super::descriptor::{Effect, Place, one_sided, switch};

/// The declaration.
pub const EFFECT: Effect = Effect::new("drained_punch", "drained punch face", Place::Contact)
    .physics(
        "A porous punch, or a film of water between it and the sample, holds the pore pressure at zero \
         on its face. The fluid then leaves over the shortest way and carries less of the force.",
    )
    .revealed_by("Less force early in the ramp where consolidation matters (soft, permeable skeleton).")
    .mimicked_by(
        "A higher permeability, a softer skeleton; nothing to see while lambda* = 1e5 Pa.",
        &["lambda_star", "drainage", "permeability"],
    )
    .variants(&[one_sided("drained", &[switch("boundary.drained_punch", 0.0, 1.0)])]);
