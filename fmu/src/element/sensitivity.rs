//! How residual, history and fluid force change with the material's parameters.

use super::Body;
use super::assembly::{Inadmissible, Stage};
use super::kernel::Point;
use super::shape::POINTS;
use crate::effect::softening::Softening;
use crate::material::sensitivity::{Flow, SpatialGradient};
use crate::material::{MaterialParameter, Voigt};
use crate::mesh::{CORNERS, NODES, UNKNOWNS};
use serde::{Deserialize, Serialize};

/// Change of the history of all integration points by every parameter.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HistorySensitivity {
    /// Of J, point by point and parameter by parameter.
    pub jacobian: Vec<f64>,
    /// Of `Cv^-1`, point by point, parameter by parameter and branch by branch.
    pub cv_inverse: Vec<Voigt>,
    /// Of the largest strain so far, point by point and parameter by parameter; empty unless the material
    /// softens with it.
    pub past_strain: Vec<f64>,
}

impl HistorySensitivity {
    /// The undeformed state does not depend on any parameter.
    pub fn undeformed(elements: usize, branches: usize) -> Self {
        let each = elements * POINTS * MaterialParameter::count(branches);
        Self {
            jacobian: vec![0.0; each],
            cv_inverse: vec![[0.0; 4]; each * branches],
            past_strain: Vec::new(),
        }
    }

    /// The same of a material that softens with past strain, where `softens` says so.
    pub fn remembering(mut self, softens: bool) -> Self {
        self.past_strain = vec![0.0; if softens { self.jacobian.len() } else { 0 }];
        self
    }
}

impl Body<'_> {
    /// Change of the residual at fixed unknowns, parameter by parameter, each as long as the unknowns.
    /// `flows` keeps what [`Body::update_sensitivity`] needs, branch by branch at every point.
    ///
    /// # Errors
    /// The first element that cannot be evaluated.
    pub fn residual_sensitivity(
        &self,
        stage: &Stage<'_>,
        old: &HistorySensitivity,
        flows: &mut [Flow],
        loads: &mut [f64],
    ) -> Result<(), Inadmissible> {
        pulp::Arch::new().dispatch(ResidualSensitivity { body: self, stage, old, flows, loads })
    }

    /// Change of the history over a converged stage; `changes` are those of the
    /// unknowns, parameter by parameter, `flows` those of [`Body::residual_sensitivity`].
    ///
    /// # Errors
    /// The first element that cannot be evaluated.
    #[allow(clippy::too_many_arguments)]
    pub fn update_sensitivity(
        &self,
        stage: &Stage<'_>,
        reach: f64,
        changes: &[f64],
        old: &HistorySensitivity,
        flows: &[Flow],
        new: &mut HistorySensitivity,
    ) -> Result<(), Inadmissible> {
        pulp::Arch::new().dispatch(UpdateSensitivity { body: self, stage, reach, changes, old, flows, new })
    }

    /// Change of the fluid force on the punch (N per unit), parameter by parameter; `closed` tells which of the
    /// face's points are in contact.
    ///
    /// # Errors
    /// The first element that cannot be evaluated.
    pub fn fluid_force_sensitivity(
        &self,
        x: &[f64],
        changes: &[f64],
        closed: &[bool],
        fluid: &mut [f64],
    ) -> Result<(), Inadmissible> {
        fluid.fill(0.0);
        for (face, _) in self.geometry.face.iter().zip(closed).filter(|(_, closed)| **closed) {
            let failed = Inadmissible { element: face.element };
            let point = Point::at(&face.geometry, &self.map.gather(face.element, x)).ok_or(failed)?;
            // Nanson: the axial area is F_rr times the hoop stretch, and F_rr changes with all of the row l F.
            let area = face.geometry.measure * point.f.plane[0][0] * point.f.hoop;
            let turned = face.geometry.measure * point.f.plane[1][0] * point.f.hoop;
            for (total, all) in fluid.iter_mut().zip(changes.chunks_exact(x.len())) {
                let change = self.map.gather(face.element, all);
                let l = spatial_gradient(&point, &change);
                let pressure: f64 = (0..CORNERS).map(|m| face.geometry.p[m] * change[2 * NODES + m]).sum();
                let area_change = area * (l.plane[0][0] + l.hoop) + turned * l.plane[0][1];
                *total += pressure * area + point.pressure * area_change;
            }
        }
        Ok(())
    }
}

/// The loop of [`Body::residual_sensitivity`], compiled for the machine's vector instructions.
struct ResidualSensitivity<'a> {
    body: &'a Body<'a>,
    stage: &'a Stage<'a>,
    old: &'a HistorySensitivity,
    flows: &'a mut [Flow],
    loads: &'a mut [f64],
}

impl pulp::NullaryFnOnce for ResidualSensitivity<'_> {
    type Output = Result<(), Inadmissible>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let Self { body, stage, old, flows, loads } = self;
        let material = body.material;
        let branches = material.branches();
        let count = MaterialParameter::count(branches);
        let unknowns = stage.x.len();
        loads.fill(0.0);
        let mut element_loads = vec![[0.0; UNKNOWNS]; count];
        let mut stress = vec![[0.0; 4]; count];
        let mut mobility = vec![0.0; count];
        for (index, places) in body.geometry.elements.iter().enumerate() {
            let failed = Inadmissible { element: index };
            let x_e = body.map.gather(index, stage.x);
            let history = stage.old.element(index, branches);
            element_loads.fill([0.0; UNKNOWNS]);
            for (k, place) in places.points.iter().enumerate() {
                let point = Point::at(place, &x_e).ok_or(failed)?;
                let at = (index * POINTS + k) * count;
                let cv = &history.cv_inverse[k * branches..(k + 1) * branches];
                let changes = &old.cv_inverse[at * branches..(at + count) * branches];
                let flows = &mut flows[(index * POINTS + k) * branches..][..branches];
                material
                    .stress_sensitivity(&point.f, cv, changes, stage.dt, flows, &mut stress)
                    .ok_or(failed)?;
                if let Some(softening) = &material.softening {
                    let undamaged =
                        material.elasticity(&point.f, cv, stage.dt).ok_or(failed)?.kirchhoff_stress;
                    let past = (history.past_strain[k], &old.past_strain[at..at + count]);
                    softening.differentiate(&point.f, past, &undamaged, &mut stress).ok_or(failed)?;
                }
                mobility_sensitivity(body, point.jacobian, &mut mobility);
                let w = place.measure;
                let g = point.grad_p;
                let along = point.pressure_gradient.map(|gm| gm[0] * g[0] + gm[1] * g[1]);
                for (parameter, load) in element_loads.iter_mut().enumerate() {
                    let tau = &stress[parameter];
                    for a in 0..NODES {
                        let ([gr, gz], h) = (point.gradient[a], point.hoop[a]);
                        load[2 * a] += w * (gr * tau[0] + gz * tau[3] + h * tau[2]);
                        load[2 * a + 1] += w * (gr * tau[3] + gz * tau[1]);
                    }
                    let (flow, growth) =
                        (w * stage.dt * mobility[parameter], w * old.jacobian[at + parameter]);
                    for m in 0..CORNERS {
                        load[2 * NODES + m] += flow * along[m] - growth * place.p[m];
                    }
                }
            }
            for place in &places.volumetric {
                let point = Point::at(place, &x_e).ok_or(failed)?;
                let [by_lambda, by_n0s] = material.volumetric.sensitivity(point.jacobian);
                for (parameter, tau) in
                    [(MaterialParameter::LambdaStar, by_lambda), (MaterialParameter::SolidFraction, by_n0s)]
                {
                    let load = &mut element_loads[parameter.index()];
                    let pressure = place.measure * tau;
                    for a in 0..NODES {
                        let ([gr, gz], h) = (point.gradient[a], point.hoop[a]);
                        load[2 * a] += pressure * (gr + h);
                        load[2 * a + 1] += pressure * gz;
                    }
                }
            }
            for (load, total) in element_loads.iter().zip(loads.chunks_exact_mut(unknowns)) {
                for (value, &unknown) in load.iter().zip(&body.map.unknowns[index]) {
                    total[unknown as usize] += value;
                }
            }
        }
        Ok(())
    }
}

/// The loop of [`Body::update_sensitivity`], compiled for the machine's vector instructions.
struct UpdateSensitivity<'a> {
    body: &'a Body<'a>,
    stage: &'a Stage<'a>,
    reach: f64,
    changes: &'a [f64],
    old: &'a HistorySensitivity,
    flows: &'a [Flow],
    new: &'a mut HistorySensitivity,
}

impl pulp::NullaryFnOnce for UpdateSensitivity<'_> {
    type Output = Result<(), Inadmissible>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let Self { body, stage, reach, changes, old, flows, new } = self;
        let x = stage.x;
        let material = body.material;
        let branches = material.branches();
        let count = MaterialParameter::count(branches);
        let mut element_changes = vec![[0.0; UNKNOWNS]; count];
        let mut gradients = vec![SpatialGradient::default(); count];
        for (index, places) in body.geometry.elements.iter().enumerate() {
            let failed = Inadmissible { element: index };
            let x_e = body.map.gather(index, x);
            for (change, all) in element_changes.iter_mut().zip(changes.chunks_exact(x.len())) {
                *change = body.map.gather(index, all);
            }
            for (k, place) in places.points.iter().enumerate() {
                let point = Point::at(place, &x_e).ok_or(failed)?;
                let at = (index * POINTS + k) * count;
                for (l, change) in gradients.iter_mut().zip(&element_changes) {
                    *l = spatial_gradient(&point, change);
                }
                let range = at * branches..(at + count) * branches;
                let flows = &flows[(index * POINTS + k) * branches..][..branches];
                let updated = &mut new.cv_inverse[range.clone()];
                let cv_changes = &old.cv_inverse[range];
                material.history_sensitivity(&point.f, flows, cv_changes, &gradients, reach, updated);
                if material.softening.is_some() {
                    let past = (stage.old.past_strain[index * POINTS + k], &old.past_strain[at..at + count]);
                    let new = &mut new.past_strain[at..at + count];
                    Softening::past_sensitivity(&point.f, past, &gradients, new).ok_or(failed)?;
                }
                for (parameter, l) in gradients.iter().enumerate() {
                    let before = old.jacobian[at + parameter];
                    new.jacobian[at + parameter] = before + reach * (point.jacobian * l.trace() - before);
                }
            }
        }
        Ok(())
    }
}

#[inline(always)]
fn spatial_gradient(point: &Point, change: &[f64; UNKNOWNS]) -> SpatialGradient {
    let mut l = SpatialGradient::default();
    for a in 0..NODES {
        let g = point.gradient[a];
        for d in 0..2 {
            l.plane[0][d] += change[2 * a] * g[d];
            l.plane[1][d] += change[2 * a + 1] * g[d];
        }
        l.hoop += change[2 * a] * point.hoop[a];
    }
    l
}

#[inline(always)]
fn mobility_sensitivity(body: &Body<'_>, jacobian: f64, by: &mut [f64]) {
    use MaterialParameter::{FluidViscosity, Permeability, SolidFraction};
    let values = body.material.darcy.sensitivity(jacobian);
    for (parameter, value) in [Permeability, FluidViscosity, SolidFraction].into_iter().zip(values) {
        by[parameter.index()] = value;
    }
}
