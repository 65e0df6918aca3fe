//! What an instance reports.

use serde::{Deserialize, Serialize};

/// Results at one time, for the whole (not the half) punch. SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Outputs {
    /// Displacement that is commanded and measured, positive into the sample (m).
    pub displacement: f64,
    /// Position of the punch's face below the true surface: displacement, plus the contact point's offset,
    /// less what the machine yields (m).
    pub indentation: f64,
    /// What the load cell reads: the force on the specimen unless effects of the sensor are on (N).
    pub force: f64,
    /// Reaction force on the specimen: minus the sum of nodal residuals over the punch (N).
    pub force_specimen: f64,
    /// Solid part, `force_specimen - force_fluid` (N).
    pub force_solid: f64,
    /// Fluid part: integral of the pore pressure over the deformed contact area (N).
    pub force_fluid: f64,
    /// Surface integral of the traction, as the paper reports it; does not converge with the mesh (N).
    pub force_traction: f64,
    /// Viscous dissipation rate (Eq. 13) (W).
    pub viscous_dissipation_rate: f64,
    /// Viscous dissipation since the start (J).
    pub viscous_dissipation: f64,
    /// Porous dissipation rate (Eq. 14) (W).
    pub porous_dissipation_rate: f64,
    /// Porous dissipation since the start (J).
    pub porous_dissipation: f64,
    /// Stored energy of equilibrium, branches and volume (J).
    pub stored_energy: f64,
    /// Work of the punch since the start (J).
    pub external_work: f64,
    /// Fluid volume pressed out of the sample since the start (m^3).
    pub fluid_expelled: f64,
}

/// What the solver did since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Statistics {
    /// Accepted time steps.
    pub steps: u64,
    /// Newton iterations.
    pub iterations: u64,
    /// Matrix factorisations.
    pub factorisations: u64,
    /// Steps cut after a failure or an excessive error.
    pub cuts: u64,
}

/// Derivatives of the force by one parameter (N per SI unit of the parameter).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ForceSensitivity {
    /// Of the force that the load cell reads.
    pub force: f64,
    /// Of the reaction force on the specimen.
    pub specimen: f64,
    /// Of the fluid part of the reaction force.
    pub fluid: f64,
}

impl ForceSensitivity {
    /// Of the solid part.
    pub fn solid(&self) -> f64 {
        self.specimen - self.fluid
    }
}

impl Outputs {
    /// Weighted sum of results at other times; the parts of the force add up exactly.
    pub(crate) fn combine(terms: &[(f64, &Outputs)]) -> Self {
        let sum = |of: fn(&Outputs) -> f64| terms.iter().map(|(w, o)| w * of(o)).sum::<f64>();
        let (force_specimen, force_fluid) = (sum(|o| o.force_specimen), sum(|o| o.force_fluid));
        Self {
            displacement: sum(|o| o.displacement),
            indentation: sum(|o| o.indentation),
            force: sum(|o| o.force),
            force_specimen,
            force_solid: force_specimen - force_fluid,
            force_fluid,
            force_traction: sum(|o| o.force_traction),
            viscous_dissipation_rate: sum(|o| o.viscous_dissipation_rate),
            viscous_dissipation: sum(|o| o.viscous_dissipation),
            porous_dissipation_rate: sum(|o| o.porous_dissipation_rate),
            porous_dissipation: sum(|o| o.porous_dissipation),
            stored_energy: sum(|o| o.stored_energy),
            external_work: sum(|o| o.external_work),
            fluid_expelled: sum(|o| o.fluid_expelled),
        }
    }
}
