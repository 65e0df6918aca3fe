//! How residual and history change with the magnitudes of effects in the laws, at fixed unknowns and history: loops of their
//! own, since most runs do without.

use super::Body;
use super::assembly::Stage;
use super::group::{ElementLoop, Group};
use super::kernel::Point;
use super::sensitivity::{HistorySensitivity, add_pressure, add_stress};
use super::shape::POINTS;
use crate::law::point::add;
use crate::law::sensitivity::ConvergedStep;
use crate::law::{Magnitude, MaterialParameter, Voigt};
use crate::mesh::{CORNERS, NODES, UNKNOWNS};
use crate::number::{Lanes, Packet, closure, each};
use pulp::Simd;

/// Adds the changes of the residual to the loads, which are those by the magnitudes alone.
pub(super) struct LoadsByMagnitude<'a> {
    pub body: &'a Body<'a>,
    pub stage: &'a Stage<'a>,
    pub loads: &'a mut [f64],
}

impl ElementLoop for LoadsByMagnitude<'_> {
    #[inline(always)]
    fn group<S: Simd>(&mut self, group: &Group<S>) -> Option<()> {
        let Self { body: Body { geometry, map, material }, stage: Stage { x, old: history, dt }, loads } =
            self;
        let branches = material.branches();
        let zero = group.splat(0.0);
        let mut own_loads = [[zero; UNKNOWNS]; Magnitude::OF_LAWS];
        let places = group.geometry(geometry);
        let load = closure!(|packet: &Packet| group.load(packet));
        let scaled =
            closure!(|tau: &Voigt<Lanes<S>>, by: Lanes<S>| each(tau, closure!(|tau: Lanes<S>| tau * by)));
        let (x_e, history) = (group.unknowns(map, x), group.history(history));
        for (k, place) in places.points.iter().enumerate() {
            let place = place.load(load);
            let point = Point::at(&place, &x_e)?;
            let step = ConvergedStep {
                f: &point.f,
                history: &history.cv_inverse[k * branches..(k + 1) * branches],
                dt: *dt,
            };
            let undamaged = material.elasticity(&point.f, step.history, *dt)?.kirchhoff_stress;
            let mut stress = [[zero; 4]; Magnitude::OF_LAWS];
            material.add_stress_by_magnitude(step, &undamaged, &mut stress)?;
            if let Some(softening) = &material.softening {
                let past = *history.past_strain.get(k)?;
                let left = softening.factor(softening.remember(&point.f, past, (*dt, 1.0))?.strain);
                for tau in &mut stress {
                    *tau = scaled(tau, left);
                }
                for (magnitude, change) in softening.by_magnitude(&point.f, (past, *dt))? {
                    add(&mut stress[magnitude.index()], &scaled(&undamaged, change));
                }
            }
            let (w, g) = (place.measure, point.grad_p);
            for (own, tau) in own_loads.iter_mut().zip(&stress) {
                add_stress(&point, &scaled(tau, w), own);
            }
            for (magnitude, mobility) in material.mobility_by_magnitude(point.jacobian) {
                let (own, flow) = (&mut own_loads[magnitude.index()], w * mobility * *dt);
                for m in 0..CORNERS {
                    let gm = point.pressure_gradient[m];
                    own[2 * NODES + m] += flow * (gm[0] * g[0] + gm[1] * g[1]);
                }
            }
        }
        for place in &places.volumetric {
            let place = place.load(load);
            let point = Point::at(&place, &x_e)?;
            for (magnitude, tau) in material.volumetric_by_magnitude(point.jacobian) {
                add_pressure(&point, place.measure * tau, &mut own_loads[magnitude.index()]);
            }
        }
        for (own, total) in own_loads.iter().zip(loads.chunks_exact_mut(x.len())) {
            group.scatter(map, own, total);
        }
        Some(())
    }
}

/// Adds the changes of the history by the inverse stress of Eyring flow, the one magnitude that changes it.
pub(super) struct HistoryByInverseStress<'a> {
    pub body: &'a Body<'a>,
    pub stage: &'a Stage<'a>,
    pub reach: f64,
    /// Number of all parameters.
    pub parameters: usize,
    pub new: &'a mut HistorySensitivity,
}

impl ElementLoop for HistoryByInverseStress<'_> {
    #[inline(always)]
    fn group<S: Simd>(&mut self, group: &Group<S>) -> Option<()> {
        let Self { body: Body { geometry, map, material }, stage, reach, parameters, new } = self;
        let Stage { x, old: history, dt } = **stage;
        let branches = material.branches();
        let parameter = MaterialParameter::count(branches) + Magnitude::InverseStress.index();
        let places = group.geometry(geometry);
        let load = closure!(|packet: &Packet| group.load(packet));
        let (x_e, history) = (group.unknowns(map, x), group.history(history));
        let mut changes = vec![[group.splat(0.0); 4]; POINTS * branches];
        for (k, place) in places.points.iter().enumerate() {
            let point = Point::at(&place.load(load), &x_e)?;
            let range = k * branches..(k + 1) * branches;
            let step = ConvergedStep { f: &point.f, history: &history.cv_inverse[range.clone()], dt };
            let own = &mut changes[range];
            let change = closure!(|branch: usize, tensor: Voigt<Lanes<S>>| own[branch] = tensor);
            material.history_by_inverse_stress(step, *reach, change)?;
        }
        // Where one element of a group fails, its elements come again, one by one: none may have been added to yet.
        for (k, changes) in changes.chunks_exact(branches).enumerate() {
            let at = (group.packet() * POINTS + k) * *parameters + parameter;
            for (branch, change) in changes.iter().enumerate() {
                let into = &mut new.cv_inverse[at * branches + branch];
                let mut sum = group.load_tensor(into);
                add(&mut sum, change);
                group.store_tensor(sum, into);
            }
        }
        Some(())
    }
}
