//! Integrals and history over a converged solution.

use super::History;
use super::assembly::{Body, Inadmissible, Stage, element_history};
use super::geometry::FacePoint;
use super::group::{ElementLoop, Group};
use super::kernel::Point;
use super::shape::{gauss_lagrange, volumetric_lagrange};
use crate::number::{Packet, closure};
use pulp::Simd;

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
    /// `reach` as in [`crate::law::PointMaterial::update`]; J is continued in the same way.
    ///
    /// # Errors
    /// The first element that cannot be evaluated.
    pub fn update(
        &self,
        stage: &Stage<'_>,
        reach: f64,
        new: &mut History,
    ) -> Result<Integrals, Inadmissible> {
        let mut sums = [0.0; 4];
        Update { body: self, stage, reach, new, sums: &mut sums }.run(self.geometry.elements.len())?;
        let [stored_energy, viscous_dissipation_rate, porous_dissipation_rate, volume_change] = sums;
        Ok(Integrals { stored_energy, viscous_dissipation_rate, porous_dissipation_rate, volume_change })
    }

    /// Fluid force and traction integral over the punch's face (N), positive into the sample.
    ///
    /// `closed` tells which of the face's points are in contact. The traction is taken from the total Cauchy stress, extrapolated from the Gauss points to the face.
    ///
    /// # Errors
    /// The first element that cannot be evaluated.
    pub fn face_forces(&self, stage: &Stage<'_>, closed: &[bool]) -> Result<(f64, f64), Inadmissible> {
        let Self { geometry, map, material } = self;
        let Stage { x, old, dt } = *stage;
        let (mut fluid, mut traction) = (0.0, 0.0);
        let branches = material.branches();
        let points = geometry.face.iter().zip(closed).filter(|(_, closed)| **closed);
        for (FacePoint { element, xi, geometry: place, normal, .. }, _) in points {
            let failed = Inadmissible { element: *element };
            let x_e = map.gather(*element, x);
            let history = element_history(old, *element, branches);
            // Cauchy stress of the skeleton (zz, rz), extrapolated from the Gauss points.
            let mut sigma = [0.0; 2];
            for (k, weight) in gauss_lagrange(*xi).into_iter().enumerate() {
                let point = Point::at(&geometry.elements[*element].points[k], &x_e).ok_or(failed)?;
                let cv = &history.cv_inverse[k * branches..(k + 1) * branches];
                let mut elasticity = material.elasticity(&point.f, cv, dt).ok_or(failed)?;
                if let Some(softening) = &material.softening {
                    let past = *history.past_strain.get(k).ok_or(failed)?;
                    softening.apply(&point.f, (past, dt), &mut elasticity).ok_or(failed)?;
                }
                let tau = elasticity.kirchhoff_stress;
                sigma[0] += weight * tau[1] / point.jacobian;
                sigma[1] += weight * tau[3] / point.jacobian;
            }
            for (k, weight) in volumetric_lagrange(*xi).into_iter().enumerate() {
                let point = Point::at(&geometry.elements[*element].volumetric[k], &x_e).ok_or(failed)?;
                let (tau_vol, _) = material.volumetric_stress(point.dilatation).ok_or(failed)?;
                sigma[0] += weight * tau_vol / point.jacobian;
            }
            let point = Point::at(place, &x_e).ok_or(failed)?;
            // Nanson: n da = J F^-T N dA.
            let inverse = point.f.inverse().plane;
            let normal: [f64; 2] = std::array::from_fn(|d| {
                point.jacobian * (inverse[0][d] * normal[0] + inverse[1][d] * normal[1])
            });
            fluid += place.measure * point.pressure * normal[1];
            traction -= place.measure * ((sigma[0] - point.pressure) * normal[1] + sigma[1] * normal[0]);
        }
        Ok((fluid, traction))
    }
}

/// The loop of [`Body::update`].
pub(super) struct Update<'a> {
    pub body: &'a Body<'a>,
    pub stage: &'a Stage<'a>,
    pub reach: f64,
    pub new: &'a mut History,
    /// The integrals, in the order of their fields.
    pub sums: &'a mut [f64; 4],
}

impl ElementLoop for Update<'_> {
    #[inline(always)]
    fn group<S: Simd>(&mut self, group: &Group<S>) -> Option<()> {
        let Body { geometry, map, material } = self.body;
        let (reach, dt) = (self.reach, self.stage.dt);
        let places = group.geometry(geometry);
        let load = closure!(|packet: &Packet| group.load(packet));
        let x = group.unknowns(map, self.stage.x);
        let old = group.history(self.stage.old);
        let mut new = group.history(self.stage.old);
        let branches = material.branches();
        let [mut stored, mut viscous, mut porous, mut volume] = [group.splat(0.0); 4];
        for place in &places.volumetric {
            let place = place.load(load);
            stored += place.measure * material.volumetric.energy(Point::at(&place, &x)?.jacobian);
        }
        for (k, place) in places.points.iter().enumerate() {
            let place = place.load(load);
            let point = Point::at(&place, &x)?;
            let range = k * branches..(k + 1) * branches;
            let (history, updated) = (&old.cv_inverse[range.clone()], &mut new.cv_inverse[range]);
            let energetics = material.update(&point.f, history, dt, reach, updated)?;
            let mut weight = place.measure;
            if let Some(softening) = &material.softening {
                let past = softening.remember(&point.f, *old.past_strain.get(k)?, (dt, reach))?;
                new.past_strain[k] = past.continued;
                weight = weight * softening.factor(past.strain);
            }
            let j = point.jacobian;
            new.jacobian[k] = old.jacobian[k] + (j - old.jacobian[k]) * reach;
            let (mobility, _) = material.darcy.referential_mobility(j);
            let g = point.grad_p;
            stored += weight * energetics.stored_energy;
            viscous += weight * energetics.viscous_dissipation_rate;
            porous += place.measure * mobility * (g[0] * g[0] + g[1] * g[1]);
            volume += place.measure * (j - 1.0);
        }
        new.store(group, self.new);
        for (sum, lanes) in self.sums.iter_mut().zip([stored, viscous, porous, volume]) {
            // Elements that fill the group up have no volume.
            *sum += lanes.as_slice().iter().sum::<f64>();
        }
        Some(())
    }
}
