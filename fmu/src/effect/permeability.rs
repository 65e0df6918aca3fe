//! Strain-dependent permeability: `K = K0 ((J - n0S)/(1 - n0S))^m` on top of Eq. 11.
//!
//! A power of the pore volume, so that the permeability vanishes with it (Eipper, 1998, the exponent there
//! is m + 1).

use super::descriptor::{Effect, Place, linear, one_sided};
use crate::number::Real;
use crate::variables::units::ONE;
use crate::variables::{Variable, field, real};
use serde::{Deserialize, Serialize};

/// The exponent.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Parameters {
    /// m [-].
    pub exponent: f64,
}

impl Parameters {
    pub(crate) fn is_active(&self) -> bool {
        self.exponent != 0.0
    }
}

/// `((J-n)/(1-n))^m` and its derivatives by J and by n.
#[inline(always)]
pub(crate) fn factor<T: Real>(exponent: f64, j: T, n0s: f64) -> [T; 3] {
    let (pore, open) = (j - n0s, 1.0 - n0s);
    let value = (pore * (1.0 / open)).powf(exponent);
    let by_pore = value * exponent / pore;
    [value, by_pore, value * (exponent / open) - by_pore]
}

pub(super) const VARIABLES: &[Variable] = &[real(
    "effect.permeability.exponent",
    "Exponent m of the permeability's dependence on the pore volume, K0 ((J-n0S)/(1-n0S))^m",
    &ONE,
    (0.0, 1000.0),
    field!(Real, padded.effect.permeability.exponent),
)];

/// The declaration.
pub const EFFECT: Effect = Effect {
    name: "permeability",
    title: "strain-dependent permeability",
    place: Place::Specimen,
    variants: &[one_sided("power", &[linear("effect.permeability.exponent", 0.0, 5.0)])],
    physics: "Compaction narrows the pores, and the permeability falls with a power of the pore volume. \
              Drainage of the most compressed region then slows down.",
    revealed_by: "Consolidation that is slower at larger depth; visible only where seepage is (soft skeleton).",
    mimicked_by: "K0 itself; nothing to see while lambda* = 1e5 Pa.",
    mimics: &["lambda_star", "drained_punch"],
};
