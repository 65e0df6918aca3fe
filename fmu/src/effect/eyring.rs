//! Nonlinear (Eyring) viscosity: the law is [`crate::law::eyring`].

use super::descriptor::{Effect, Place, linear, one_sided};
use super::parameter::parameters;
use crate::unit::PER_PASCAL;

parameters! {
    /// The stress that drives the flow out of proportion.
    eyring:
    /// 1/tau_0 of the branches' flow, shear rate (tau_0/eta) sinh(stress/tau_0); 0: linear dashpots
    inverse_stress: real(PER_PASCAL, (0.0, 10.0)) = 0.0;
}

/// The declaration.
pub const EFFECT: Effect = Effect::new("eyring", "nonlinear (Eyring) viscosity", Place::Specimen)
    .physics(
        "Stress helps the dashpots' units over their barriers, so that the rate of flow grows with the \
         hyperbolic sine of the stress. Peaks are cut the more the faster they are reached, and \
         relaxation begins fast and ends slowly.",
    )
    .revealed_by(
        "The ratio of peaks at two rates below that of linear dashpots; relaxation whose shape depends \
         on the depth.",
    )
    .mimicked_by(
        "A spectrum of branches at one rate and depth; compliance or lag at the peak.",
        &["third_branch", "compliance", "load_cell_lag"],
    )
    .variants(&[one_sided("sinh flow", &[linear("effect.eyring.inverse_stress", 0.0, 5e-3)])]);
