//! Integrals and history over a converged solution; all sums are those of the whole sample.

use super::assembly::{SolidBody, cell_history};
use super::geometry::FacePoint;
use super::kernel::Point;
use super::point::inverse;
use super::shape::{GAUSS_POINTS, POINTS, VOLUMETRIC_POINTS, gauss_lagrange, volumetric_lagrange};
use crate::element::field::Integrals;
use crate::element::{History, Inadmissible, Stage};

/// Quarters per sample.
pub const QUARTERS: f64 = 4.0;

impl SolidBody<'_> {
    /// Advances the history over a converged step into `new` and integrates.
    ///
    /// `reach` as in [`super::point::SolidMaterial::update`]; J is continued in the same way.
    ///
    /// # Errors
    /// The first cell that cannot be evaluated.
    pub fn update(&self, stage: Stage<'_>, reach: f64, new: &mut History) -> Result<Integrals, Inadmissible> {
        let (Self { geometry, map, material }, Stage { x, old, dt }) = (*self, stage);
        let branches = material.branches();
        let mut sums = Integrals::default();
        for (cell, places) in geometry.cells.iter().enumerate() {
            let failed = Inadmissible { element: cell };
            let x_c = map.gather(cell, x);
            for (place, shape) in places.volumetric.iter().zip(&*VOLUMETRIC_POINTS) {
                let j = Point::at(place, shape, &x_c).ok_or(failed)?.jacobian;
                sums.stored_energy += QUARTERS * place.measure * material.volumetric.energy(j);
            }
            for (k, (place, shape)) in places.points.iter().zip(&*GAUSS_POINTS).enumerate() {
                let point = Point::at(place, shape, &x_c).ok_or(failed)?;
                let at = cell * POINTS + k;
                let range = at * branches..(at + 1) * branches;
                let energetics = material
                    .update(&point.f, &old.tensors()[range.clone()], dt, reach, &mut new.tensors_mut()[range])
                    .ok_or(failed)?;
                let j = point.jacobian;
                new.jacobian[at] = old.jacobian[at] + reach * (j - old.jacobian[at]);
                let (mobility, _) = material.darcy.referential_mobility(j);
                let square: f64 = point.grad_p.iter().map(|g| g * g).sum();
                let w = QUARTERS * place.measure;
                sums.stored_energy += w * energetics.stored_energy;
                sums.viscous_dissipation_rate += w * energetics.viscous_dissipation_rate;
                sums.porous_dissipation_rate += w * mobility * square;
                sums.volume_change += w * (j - 1.0);
            }
        }
        Ok(sums)
    }

    /// Fluid force and traction integral over the punch's face (N), positive into the sample.
    ///
    /// The traction is taken from the total Cauchy stress, extrapolated from the Gauss points to the face.
    ///
    /// # Errors
    /// The first cell that cannot be evaluated.
    pub fn face_forces(&self, stage: Stage<'_>) -> Result<(f64, f64), Inadmissible> {
        let (Self { geometry, map, material }, Stage { x, old, dt }) = (*self, stage);
        let (mut fluid, mut traction) = (0.0, 0.0);
        let branches = material.branches();
        // The points of one cell follow each other and share its stresses.
        for face in geometry.face.chunk_by(|a, b| a.cell == b.cell) {
            let cell = face[0].cell;
            let failed = Inadmissible { element: cell };
            let x_c = map.gather(cell, x);
            let history = cell_history(old, cell, branches);
            // Cauchy stress of the skeleton on a horizontal face (zx, yz, zz) at the Gauss points.
            let mut skeleton = [[0.0; 3]; POINTS];
            for (k, (place, shape)) in geometry.cells[cell].points.iter().zip(&*GAUSS_POINTS).enumerate() {
                let point = Point::at(place, shape, &x_c).ok_or(failed)?;
                let cv = &history.cv_inverse[k * branches..(k + 1) * branches];
                let tau = material.elasticity(&point.f, cv, dt).ok_or(failed)?.kirchhoff_stress;
                skeleton[k] = [tau[5], tau[4], tau[2]].map(|t| t / point.jacobian);
            }
            let mut volumetric = [0.0; 8];
            for (k, (place, shape)) in
                geometry.cells[cell].volumetric.iter().zip(&*VOLUMETRIC_POINTS).enumerate()
            {
                let j = Point::at(place, shape, &x_c).ok_or(failed)?.jacobian;
                volumetric[k] = material.volumetric_stress(j - 1.0).ok_or(failed)?.0 / j;
            }
            for FacePoint { shape, geometry: place, .. } in face {
                let mut sigma = [0.0; 3];
                for (weight, s) in gauss_lagrange(shape.xi).iter().zip(&skeleton) {
                    (0..3).for_each(|i| sigma[i] += weight * s[i]);
                }
                for (weight, s) in volumetric_lagrange(shape.xi).iter().zip(&volumetric) {
                    sigma[2] += weight * s;
                }
                let point = Point::at(place, shape, &x_c).ok_or(failed)?;
                // Nanson: n da = J F^-T N dA, N = e_z.
                let normal = inverse(&point.f, point.jacobian)[2].map(|n| point.jacobian * n);
                sigma[2] -= point.pressure;
                let w = QUARTERS * place.measure;
                fluid += w * point.pressure * normal[2];
                traction -= w * (0..3).map(|i| sigma[i] * normal[i]).sum::<f64>();
            }
        }
        Ok((fluid, traction))
    }
}
