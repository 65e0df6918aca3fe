//! From parameters and effects to the set-ups of specimen and load cell: the one place that knows both.

use crate::contact::Adhesion;
use crate::effect::{slip, softening};
use crate::law::extensions::Extensions;
use crate::law::softening::Softening;
use crate::parameters::Parameters;
use crate::sensor::LoadCellParameters;
use crate::specimen::Setup;

impl Parameters {
    /// The specimen under the punch, with the effects of specimen, contact and machine.
    pub fn setup(&self) -> Setup {
        let Self { material, geometry, indenter, boundary, solver, effect, .. } = self.clone();
        Setup {
            extensions: Extensions {
                amplitude: effect.amplitude.log_factor.exp(),
                growth_rate: effect.modulus_drift.rate,
                inverse_stress: effect.eyring.inverse_stress,
                permeability_exponent: effect.permeability.exponent,
                // To be differentiated by, it remembers the past strain before it acts.
                softening: (softening::EFFECT.acts(&effect) || solver.effect_sensitivities).then_some(
                    Softening {
                        loss: effect.softening.loss,
                        strain: effect.softening.strain,
                        delay: effect.softening.delay,
                    },
                ),
            },
            adhesion: Adhesion { strength: effect.adhesion.strength, opening: effect.adhesion.opening },
            // The optimiser may divide before it asks whether the layer is there.
            shear_layer: slip::EFFECT
                .acts(&effect)
                .then(|| 1.0 / effect.slip.compliance.max(f64::MIN_POSITIVE)),
            compliance: effect.compliance.per_newton,
            material,
            geometry,
            indenter,
            boundary,
            solver,
        }
    }

    /// The load cell with the effects of the sensor.
    pub fn load_cell(&self) -> LoadCellParameters {
        let effect = &self.effect;
        LoadCellParameters {
            lag: effect.load_cell_lag.time,
            drift_rate: effect.load_cell_drift.rate,
            differentiates_lag: self.solver.effect_sensitivities,
            reads_traction: effect.discretisation.traction,
        }
    }
}
