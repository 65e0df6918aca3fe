//! Compressible skeleton: a drained volumetric stiffness that seepage can reach.

use super::descriptor::{Effect, Place, geometric, one_sided};

/// The declaration.
pub const EFFECT: Effect = Effect::new("lambda_star", "compressible skeleton", Place::Specimen)
    .physics(
        "With lambda* near the shear modulus the drained skeleton loses volume as the fluid leaves, so \
         that the force falls by consolidation. At 1e5 Pa it is as good as incompressible and K0 cannot \
         be seen.",
    )
    .revealed_by(
        "Relaxation whose time grows with the square of the punch's radius, fluid expelled, a force \
         that depends on drainage.",
    )
    .mimicked_by(
        "A viscous branch with the time of consolidation; permeability, which only sets that time.",
        &["third_branch", "drained_punch", "drainage"],
    )
    .variants(&[one_sided("softer", &[geometric("material.lambda_star", 1e5, 2e3)])]);
