//! Discretisation: errors of mesh and time steps, and the traction integral as the force that is read out.

use super::descriptor::{Effect, Place, geometric, one_sided, switch, two_sided};
use super::parameter::parameters;

parameters! {
    /// What is read out.
    discretisation:
    /// The force that is read is the surface integral of the traction, as the paper reports it
    traction: flag = false;
}

/// The declaration.
pub const EFFECT: Effect = Effect::new("discretisation", "discretisation", Place::Numerics)
    .physics(
        "The edge of a bonded punch is singular: the force converges slowly on refinement, and the \
         integral of the traction, which the paper reports, does not converge. Backward Euler steps \
         lengthen a relaxation time by half a step.",
    )
    .revealed_by("Nothing in the data: refining mesh and steps shows it.")
    .mimicked_by("All moduli together, amplitude.", &["amplitude", "specimen_size"])
    .variants(&[
        one_sided("mesh", &[switch("mesh.preset", 2.0, 3.0)]),
        two_sided("time", &[geometric("solver.tolerance", 3e-4, 3e-5)]),
        one_sided("traction", &[switch("effect.discretisation.traction", 0.0, 1.0)]).without_sensitivities(),
    ]);
