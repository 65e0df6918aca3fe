//! Finite specimen size: the sample as cut against the sample as meshed.

use super::descriptor::{Effect, Place, geometric, two_sided};

/// The declaration.
pub const EFFECT: Effect = Effect::new("specimen_size", "finite specimen size", Place::Specimen)
    .physics(
        "Bottom and side stiffen the response as their distance comes near the punch's radius. The \
         sample as cut, twice the meshed one, gives 14 % less force.",
    )
    .revealed_by("Nothing in one force curve but its scale; measuring the sample does.")
    .mimicked_by("All moduli together, amplitude.", &["amplitude"])
    // The real sample is twice the paper's mesh in both directions.
    .variants(&[two_sided(
        "as cut",
        &[geometric("geometry.sample_radius", 1e-2, 2e-2), geometric("geometry.sample_height", 1e-2, 2e-2)],
    )]);
