//! Strain-dependent permeability: the law is [`crate::law::darcy`].

use super::descriptor::{Effect, Place, linear, one_sided};
use super::parameter::parameters;
use crate::unit::ONE;

parameters! {
    /// The exponent.
    permeability:
    /// Exponent m of the permeability's dependence on the pore volume, K0 ((J-n0S)/(1-n0S))^m
    exponent: real(ONE, (0.0, 1000.0)) = 0.0;
}

/// The declaration.
pub const EFFECT: Effect = Effect::new("permeability", "strain-dependent permeability", Place::Specimen)
    .physics(
        "Compaction narrows the pores, and the permeability falls with a power of the pore volume. \
         Drainage of the most compressed region then slows down.",
    )
    .revealed_by(
        "Consolidation that is slower at larger depth; visible only where seepage is (soft skeleton).",
    )
    .mimicked_by("K0 itself; nothing to see while lambda* = 1e5 Pa.", &["lambda_star", "drained_punch"])
    .variants(&[one_sided("power", &[linear("effect.permeability.exponent", 0.0, 5.0)])]);
