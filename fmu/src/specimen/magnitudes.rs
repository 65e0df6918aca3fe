//! What the magnitudes of effects in contact, machine and motion change in a stage at fixed unknowns.

use super::derivatives::Converged;
use super::stepper::Stepper;
use crate::law::{Magnitude, MaterialParameter};

/// Places of the magnitudes in lists of derivatives, where these are computed by them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Places {
    of_material: usize,
}

impl Places {
    /// Place of a magnitude.
    pub fn of(self, magnitude: Magnitude) -> usize {
        self.of_material + magnitude.index()
    }
}

impl Stepper {
    /// Where the magnitudes stand among `parameters`, if they do.
    pub(super) fn places(&self) -> Option<Places> {
        let of_material = MaterialParameter::count(self.material.branches());
        (self.parameters > of_material).then_some(Places { of_material })
    }

    /// Adds what the residuals of free nodes change by shear layer and adhesion to their loads, and what the force does (N).
    pub(super) fn add_contact_loads(
        &self,
        places: Places,
        at: &Converged<'_>,
        loads: &mut [f64],
        force: &mut [f64],
    ) {
        let unknowns = at.stage.x.len();
        if let Some(stiffness) = self.shear_layer {
            // The stiffness is the reciprocal of the compliance.
            let place = places.of(Magnitude::ShearCompliance);
            let load = &mut loads[place * unknowns..][..unknowns];
            let body = self.sample.body(&self.material);
            body.add_layer_forces((-stiffness * stiffness, &self.conditions.closed_points), at.stage.x, load);
        }
        let place = places.of(Magnitude::AdhesiveStrength);
        let load = &mut loads[place * unknowns..][..unknowns];
        for (index, node) in self.surface.nodes().iter().enumerate() {
            let area = self.surface.bridged_area(index, at.contact);
            load[node.axial] -= area;
            if !at.contact.is_closed(index) {
                force[place] -= area;
            }
        }
    }

    /// Adds the adhesion's part of the friction of sliding nodes to the load by its strength.
    pub(super) fn add_friction_of_adhesion(&self, at: &Converged<'_>, load: &mut [f64]) {
        for slide in &self.conditions.slides {
            load[slide.radial] -= slide.friction * self.surface.clinging_area(slide.node, at.contact);
        }
    }

    /// Adds how far the punch moves up (m) at a fixed force, with the compliance of the machine and the height of the surface.
    pub(super) fn add_motion_of_punch(&self, places: Places, loads: &mut [f64]) {
        let unknowns = self.column_scale.len();
        let motions = [
            (Magnitude::MachineCompliance, self.conditions.reaction(&self.raw_residual)),
            (Magnitude::SurfaceHeight, -1.0),
        ];
        for (magnitude, rise) in motions {
            let load = &mut loads[places.of(magnitude) * unknowns..][..unknowns];
            for &axial in &self.conditions.punch {
                load[axial] += rise / self.column_scale[axial];
            }
        }
    }
}
