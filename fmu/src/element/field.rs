//! Integrals and history over a converged solution.

use super::assembly::{Body, History, Inadmissible, Stage};
use super::geometry::FacePoint;
use super::kernel::Point;
use super::shape::{POINTS, gauss_lagrange, volumetric_lagrange};
use crate::effect::softening::Softening;

/// Volume integrals at one time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Integrals {
    /// Stored energy (J).
    pub stored_energy: f64,
    /// Viscous dissipation rate (W) (Eq. 13).
    pub viscous_dissipation_rate: f64,
    /// Porous dissipation rate (W) (Eq. 14).
    pub porous_dissipation_rate: f64,
    /// Change of the sample's volume (m^3).
    pub volume_change: f64,
}

impl Body<'_> {
    /// Advances the history over a converged stage into `new` and integrates.
    ///
    /// `reach` as in [`crate::material::PointMaterial::update`]; J is continued in the same way.
    ///
    /// # Errors
    /// The first element that cannot be evaluated.
    pub fn update(
        &self,
        stage: &Stage<'_>,
        reach: f64,
        new: &mut History,
    ) -> Result<Integrals, Inadmissible> {
        let Self { geometry, map, material } = self;
        let Stage { x, old, dt } = *stage;
        let branches = material.branches();
        let mut integrals = Integrals::default();
        for (index, places) in geometry.elements.iter().enumerate() {
            let failed = Inadmissible { element: index };
            let x_e = map.gather(index, x);
            for place in &places.volumetric {
                let j = Point::at(place, &x_e).ok_or(failed)?.jacobian;
                integrals.stored_energy += place.measure * material.volumetric.energy(j);
            }
            for (k, place) in places.points.iter().enumerate() {
                let point = Point::at(place, &x_e).ok_or(failed)?;
                let at = index * POINTS + k;
                let range = at * branches..(at + 1) * branches;
                let energetics = material
                    .update(&point.f, &old.cv_inverse[range.clone()], dt, reach, &mut new.cv_inverse[range])
                    .ok_or(failed)?;
                let mut left = 1.0;
                if let Some(softening) = &material.softening {
                    let past = Softening::past_strain(&point.f, old.past_strain[at]).ok_or(failed)?;
                    new.past_strain[at] = past;
                    left = softening.factor(past);
                }
                let j = point.jacobian;
                new.jacobian[at] = old.jacobian[at] + reach * (j - old.jacobian[at]);
                let (mobility, _) = material.darcy.referential_mobility(j);
                let g = point.grad_p;
                integrals.stored_energy += left * place.measure * energetics.stored_energy;
                integrals.viscous_dissipation_rate +=
                    left * place.measure * energetics.viscous_dissipation_rate;
                integrals.porous_dissipation_rate += place.measure * mobility * (g[0] * g[0] + g[1] * g[1]);
                integrals.volume_change += place.measure * (j - 1.0);
            }
        }
        Ok(integrals)
    }

    /// Fluid force and traction integral over the punch's face (N), positive into the sample.
    ///
    /// The traction is taken from the total Cauchy stress, extrapolated from the Gauss points to the face.
    ///
    /// # Errors
    /// The first element that cannot be evaluated.
    pub fn face_forces(&self, stage: &Stage<'_>) -> Result<(f64, f64), Inadmissible> {
        let Self { geometry, map, material } = self;
        let Stage { x, old, dt } = *stage;
        let (mut fluid, mut traction) = (0.0, 0.0);
        let branches = material.branches();
        for FacePoint { element, xi, geometry: place } in &geometry.face {
            let failed = Inadmissible { element: *element };
            let x_e = map.gather(*element, x);
            let history = old.element(*element, branches);
            // Cauchy stress of the skeleton (zz, rz), extrapolated from the Gauss points.
            let mut sigma = [0.0; 2];
            for (k, weight) in gauss_lagrange(*xi).into_iter().enumerate() {
                let point = Point::at(&geometry.elements[*element].points[k], &x_e).ok_or(failed)?;
                let cv = &history.cv_inverse[k * branches..(k + 1) * branches];
                let mut elasticity = material.elasticity(&point.f, cv, dt).ok_or(failed)?;
                if let Some(softening) = &material.softening {
                    let past = *history.past_strain.get(k).ok_or(failed)?;
                    softening.apply(&point.f, past, &mut elasticity).ok_or(failed)?;
                }
                let tau = elasticity.kirchhoff_stress;
                sigma[0] += weight * tau[1] / point.jacobian;
                sigma[1] += weight * tau[3] / point.jacobian;
            }
            for (k, weight) in volumetric_lagrange(*xi).into_iter().enumerate() {
                let point = Point::at(&geometry.elements[*element].volumetric[k], &x_e).ok_or(failed)?;
                let (tau_vol, _) = material.volumetric_stress(point.jacobian).ok_or(failed)?;
                sigma[0] += weight * tau_vol / point.jacobian;
            }
            let point = Point::at(place, &x_e).ok_or(failed)?;
            // Nanson: n da = J F^-T N dA, N = e_z.
            let inverse = point.f.inverse();
            let normal = [point.jacobian * inverse.plane[1][0], point.jacobian * inverse.plane[1][1]];
            fluid += place.measure * point.pressure * normal[1];
            traction -= place.measure * ((sigma[0] - point.pressure) * normal[1] + sigma[1] * normal[0]);
        }
        Ok((fluid, traction))
    }
}
