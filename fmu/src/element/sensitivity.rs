//! How residual, history and fluid force change with the material's parameters and, where lists are so long, with the
//! magnitudes of effects.

use super::Body;
use super::assembly::{Inadmissible, Stage};
use super::group::{ElementLoop, Group};
use super::kernel::Point;
use super::magnitudes::{HistoryByInverseStress, LoadsByMagnitude};
use super::shape::POINTS;
use crate::law::sensitivity::{ConvergedStep, SpatialGradient};
use crate::law::{MaterialParameter, PointMaterial, Voigt};
use crate::mesh::{CORNERS, NODES, UNKNOWNS};
use crate::number::{Lanes, PACKET, Packet, Real, closure, each};
use pulp::Simd;
use serde::{Deserialize, Serialize};

/// Change of the history of all integration points by every parameter, of [`PACKET`] elements at a time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HistorySensitivity {
    /// Of J, point by point and parameter by parameter.
    pub jacobian: Vec<Packet>,
    /// Of `Cv^-1`, point by point, parameter by parameter and branch by branch.
    pub cv_inverse: Vec<Voigt<Packet>>,
    /// Of the largest strain so far, point by point and parameter by parameter; empty unless the material
    /// softens with it.
    pub past_strain: Vec<Packet>,
}

impl HistorySensitivity {
    /// The undeformed state does not depend on any of so many parameters.
    pub fn undeformed(elements: usize, branches: usize, parameters: usize) -> Self {
        let each = elements.div_ceil(PACKET) * POINTS * parameters;
        Self {
            jacobian: vec![Packet::default(); each],
            cv_inverse: vec![[Packet::default(); 4]; each * branches],
            past_strain: Vec::new(),
        }
    }

    /// Numbers of its entries.
    pub fn lengths(&self) -> [usize; 3] {
        [self.jacobian.len(), self.cv_inverse.len(), self.past_strain.len()]
    }

    /// The same of a material that softens with past strain, where `softens` says so.
    pub fn remembering(mut self, softens: bool) -> Self {
        self.past_strain = vec![Packet::default(); if softens { self.jacobian.len() } else { 0 }];
        self
    }
}

impl Body<'_> {
    /// Change of the residual at fixed unknowns, parameter by parameter, each as long as the unknowns.
    ///
    /// # Errors
    /// The first element that cannot be evaluated.
    pub fn residual_sensitivity(
        &self,
        stage: &Stage<'_>,
        old: &HistorySensitivity,
        loads: &mut [f64],
    ) -> Result<(), Inadmissible> {
        loads.fill(0.0);
        let elements = self.geometry.elements.len();
        ResidualSensitivity { body: self, stage, old, loads }.run(elements)?;
        let of_material = MaterialParameter::count(self.material.branches()) * stage.x.len();
        match &mut loads[of_material..] {
            [] => Ok(()),
            loads => LoadsByMagnitude { body: self, stage, loads }.run(elements),
        }
    }

    /// Change of the history over a converged stage; `changes` are those of the unknowns, parameter by parameter.
    ///
    /// # Errors
    /// The first element that cannot be evaluated.
    pub fn update_sensitivity(
        &self,
        stage: &Stage<'_>,
        reach: f64,
        changes: &[f64],
        old: &HistorySensitivity,
        new: &mut HistorySensitivity,
    ) -> Result<(), Inadmissible> {
        let elements = self.geometry.elements.len();
        UpdateSensitivity { body: self, stage, reach, changes, old, new }.run(elements)?;
        let parameters = changes.len() / stage.x.len();
        if parameters == MaterialParameter::count(self.material.branches()) || self.material.flows_linearly()
        {
            return Ok(());
        }
        HistoryByInverseStress { body: self, stage, reach, parameters, new }.run(elements)
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
            // Nanson: the axial area is F_rr (-F_rz on a side) times the hoop stretch, and changes with the row l F.
            let ([r, z], f) = (face.normal, point.f.plane);
            let area = face.geometry.measure * (f[0][0] * z - f[0][1] * r) * point.f.hoop;
            let turned = face.geometry.measure * (f[1][0] * z - f[1][1] * r) * point.f.hoop;
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

/// The loop of [`Body::residual_sensitivity`].
pub(super) struct ResidualSensitivity<'a> {
    pub body: &'a Body<'a>,
    pub stage: &'a Stage<'a>,
    pub old: &'a HistorySensitivity,
    pub loads: &'a mut [f64],
}

impl ElementLoop for ResidualSensitivity<'_> {
    #[inline(always)]
    fn group<S: Simd>(&mut self, group: &Group<S>) -> Option<()> {
        let Self { body: Body { geometry, map, material }, stage: Stage { x, old: history, dt }, old, loads } =
            self;
        let branches = material.branches();
        let count = loads.len() / x.len();
        let zero = group.splat(0.0);
        let mut own_loads = vec![[zero; UNKNOWNS]; count];
        let mut stress = vec![[zero; 4]; count];
        let mut mobility = vec![zero; count];
        let places = group.geometry(geometry);
        let load = closure!(|packet: &Packet| group.load(packet));
        let (x_e, history) = (group.unknowns(map, x), group.history(history));
        for (k, place) in places.points.iter().enumerate() {
            let place = place.load(load);
            let point = Point::at(&place, &x_e)?;
            let at = (group.packet() * POINTS + k) * count;
            let step = ConvergedStep {
                f: &point.f,
                history: &history.cv_inverse[k * branches..(k + 1) * branches],
                dt: *dt,
            };
            let changes = closure!(|parameter: usize, branch: usize| {
                group.load_tensor(&old.cv_inverse[(at + parameter) * branches + branch])
            });
            material.stress_sensitivity(step, changes, &mut stress)?;
            if let Some(softening) = &material.softening {
                let undamaged = material.elasticity(&point.f, step.history, *dt)?.kirchhoff_stress;
                let changes = closure!(|parameter: usize| load(&old.past_strain[at + parameter]));
                let past = *history.past_strain.get(k)?;
                softening.differentiate(&point.f, (past, changes, *dt), &undamaged, &mut stress)?;
            }
            mobility_sensitivity(material, point.jacobian, &mut mobility);
            let w = place.measure;
            let g = point.grad_p;
            for (parameter, own) in own_loads.iter_mut().enumerate() {
                add_stress(&point, &each(&stress[parameter], closure!(|tau: Lanes<S>| tau * w)), own);
                let (flow, growth) = (w * mobility[parameter] * *dt, w * load(&old.jacobian[at + parameter]));
                for m in 0..CORNERS {
                    let gm = point.pressure_gradient[m];
                    own[2 * NODES + m] += flow * (gm[0] * g[0] + gm[1] * g[1]) - growth * place.p[m];
                }
            }
        }
        for place in &places.volumetric {
            let place = place.load(load);
            let point = Point::at(&place, &x_e)?;
            let [by_lambda, by_n0s] = material.volumetric.sensitivity(point.jacobian);
            for (parameter, tau) in
                [(MaterialParameter::LambdaStar, by_lambda), (MaterialParameter::SolidFraction, by_n0s)]
            {
                add_pressure(&point, place.measure * tau, &mut own_loads[parameter.index()]);
            }
        }
        for (own, total) in own_loads.iter().zip(loads.chunks_exact_mut(x.len())) {
            group.scatter(map, own, total);
        }
        Some(())
    }
}

/// The loop of [`Body::update_sensitivity`].
pub(super) struct UpdateSensitivity<'a> {
    pub body: &'a Body<'a>,
    pub stage: &'a Stage<'a>,
    pub reach: f64,
    pub changes: &'a [f64],
    pub old: &'a HistorySensitivity,
    pub new: &'a mut HistorySensitivity,
}

impl ElementLoop for UpdateSensitivity<'_> {
    #[inline(always)]
    fn group<S: Simd>(&mut self, group: &Group<S>) -> Option<()> {
        let Self { body: Body { geometry, map, material }, stage, reach, changes, old, new } = self;
        let Stage { x, old: history, dt } = **stage;
        let branches = material.branches();
        let count = changes.len() / x.len();
        let zero = group.splat(0.0);
        let mut own_changes = vec![[zero; UNKNOWNS]; count];
        let mut gradients = vec![SpatialGradient { plane: [[zero; 2]; 2], hoop: zero }; count];
        for (own, all) in own_changes.iter_mut().zip(changes.chunks_exact(x.len())) {
            *own = group.unknowns(map, all);
        }
        let places = group.geometry(geometry);
        let load = closure!(|packet: &Packet| group.load(packet));
        let (x_e, history) = (group.unknowns(map, x), group.history(history));
        for (k, place) in places.points.iter().enumerate() {
            let point = Point::at(&place.load(load), &x_e)?;
            let at = (group.packet() * POINTS + k) * count;
            for (l, change) in gradients.iter_mut().zip(&own_changes) {
                *l = spatial_gradient(&point, change);
            }
            let step = ConvergedStep {
                f: &point.f,
                history: &history.cv_inverse[k * branches..(k + 1) * branches],
                dt,
            };
            let changes = closure!(|parameter: usize, branch: usize| {
                group.load_tensor(&old.cv_inverse[(at + parameter) * branches + branch])
            });
            let updated = closure!(|parameter: usize, branch: usize, tensor: Voigt<Lanes<S>>| {
                let into = &mut new.cv_inverse[(at + parameter) * branches + branch];
                group.store_tensor(tensor, into);
            });
            material.history_sensitivity(step, *reach, &gradients, changes, updated)?;
            if let Some(softening) = &material.softening {
                let changes = closure!(|parameter: usize| load(&old.past_strain[at + parameter]));
                let past = (*history.past_strain.get(k)?, changes);
                let update = closure!(
                    |parameter: usize, value| group.store(value, &mut new.past_strain[at + parameter])
                );
                softening.past_sensitivity(&point.f, past, (dt, *reach), &gradients, update)?;
            }
            for (parameter, l) in gradients.iter().enumerate() {
                let before = load(&old.jacobian[at + parameter]);
                let after = before + (point.jacobian * l.trace() - before) * *reach;
                group.store(after, &mut new.jacobian[at + parameter]);
            }
        }
        Some(())
    }
}

/// Adds the nodal forces of a stress times the volume.
#[inline(always)]
pub(super) fn add_stress<T: Real>(point: &Point<T>, tau: &Voigt<T>, own: &mut [T; UNKNOWNS]) {
    for a in 0..NODES {
        let ([gr, gz], h) = (point.gradient[a], point.hoop[a]);
        own[2 * a] = gr.mul_add(tau[0], gz.mul_add(tau[3], h.mul_add(tau[2], own[2 * a])));
        own[2 * a + 1] = gr.mul_add(tau[3], gz.mul_add(tau[1], own[2 * a + 1]));
    }
}

/// Adds those of an isotropic stress times the volume.
#[inline(always)]
pub(super) fn add_pressure<T: Real>(point: &Point<T>, pressure: T, own: &mut [T; UNKNOWNS]) {
    for a in 0..NODES {
        let ([gr, gz], h) = (point.gradient[a], point.hoop[a]);
        own[2 * a] += pressure * (gr + h);
        own[2 * a + 1] += pressure * gz;
    }
}

#[inline(always)]
fn spatial_gradient<T: Real>(point: &Point<T>, change: &[T; UNKNOWNS]) -> SpatialGradient<T> {
    let zero = point.jacobian.constant(0.0);
    let mut l = SpatialGradient { plane: [[zero; 2]; 2], hoop: zero };
    for a in 0..NODES {
        let g = point.gradient[a];
        for d in 0..2 {
            l.plane[0][d] = change[2 * a].mul_add(g[d], l.plane[0][d]);
            l.plane[1][d] = change[2 * a + 1].mul_add(g[d], l.plane[1][d]);
        }
        l.hoop = change[2 * a].mul_add(point.hoop[a], l.hoop);
    }
    l
}

#[inline(always)]
fn mobility_sensitivity<T: Real>(material: &PointMaterial, jacobian: T, by: &mut [T]) {
    use MaterialParameter::{FluidViscosity, Permeability, SolidFraction};
    let values = material.darcy.sensitivity(jacobian);
    for (parameter, value) in [Permeability, FluidViscosity, SolidFraction].into_iter().zip(values) {
        by[parameter.index()] = value;
    }
}
