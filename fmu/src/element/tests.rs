//! Several elements at a time against one by one, on every kind of vector that this machine has.

use super::History;
use super::assembly::{Assemble, AssemblyMap, Body, Inadmissible, Stage, element_history, undeformed};
use super::field::Update;
use super::geometry::Geometry;
use super::group::Groups;
use super::kernel::evaluate;
use super::magnitudes::{HistoryByInverseStress, LoadsByMagnitude};
use super::sensitivity::{HistorySensitivity, ResidualSensitivity, UpdateSensitivity};
use super::shape::POINTS;
use crate::law::extensions::Extensions;
use crate::law::parameters::MaterialParameters;
use crate::law::softening::Softening;
use crate::law::{Magnitude, MaterialParameter, PointMaterial};
use crate::mesh::{Mesh, NODES, UNKNOWNS};
use crate::number::{Packet, on_every_machine};
use pulp::{Simd, WithSimd};

/// One and a half packets, or nearly.
const ELEMENTS: usize = 11;
const DT: f64 = 0.02;
/// Changes with the parameters of two branches and the magnitudes.
const COUNT: usize = MaterialParameter::count(2) + Magnitude::OF_SPECIMEN;

/// A number between -0.5 and 0.5.
fn noise(k: usize) -> f64 {
    ((k * 7919 + 13) % 1009) as f64 / 1009.0 - 0.5
}

struct Case {
    geometry: Geometry,
    map: AssemblyMap,
    material: PointMaterial,
    x: Vec<f64>,
    is_pressure: Vec<bool>,
    history: History,
    changes: HistorySensitivity,
}

impl Case {
    fn new(extensions: &Extensions) -> Self {
        let radii: Vec<f64> = (0..=ELEMENTS).map(|k| k as f64 * 1e-4).collect();
        let mesh = Mesh::tensor(&radii, &[0.0, 1.3e-4], 3e-4);
        let (geometry, map) = (Geometry::new(&mesh), AssemblyMap::new(&mesh));
        let mut is_pressure = vec![false; mesh.unknowns()];
        for unknowns in &map.unknowns {
            unknowns[2 * NODES..].iter().for_each(|&u| is_pressure[u as usize] = true);
        }
        let at = |(k, p): (usize, &bool)| if *p { 3e3 * noise(k) } else { 1.5e-5 * noise(k) };
        let x = is_pressure.iter().enumerate().map(at).collect();
        let softens = extensions.softening.is_some();
        let mut history = undeformed(ELEMENTS, 2).remembering(softens);
        for (k, c) in history.tensors_mut().iter_mut().enumerate() {
            let (rr, zz, rz) = (1.0 + 0.2 * noise(k), 1.0 + 0.2 * noise(2 * k + 1), 0.1 * noise(3 * k));
            *c = [rr, zz, 1.0 / (rr * zz - rz * rz), rz];
        }
        history.jacobian.iter_mut().enumerate().for_each(|(k, j)| *j += 0.02 * noise(k));
        history.past_strain.iter_mut().enumerate().for_each(|(k, e)| *e = 0.1 + 0.2 * noise(k));
        let mut changes = HistorySensitivity::undeformed(ELEMENTS, 2, COUNT).remembering(softens);
        let fill = |(k, packet): (usize, &mut Packet)| {
            packet.0.iter_mut().enumerate().for_each(|(lane, v)| *v = noise(8 * k + lane));
        };
        changes.jacobian.iter_mut().enumerate().for_each(fill);
        changes.cv_inverse.as_flattened_mut().iter_mut().enumerate().for_each(fill);
        changes.past_strain.iter_mut().enumerate().for_each(fill);
        let material = PointMaterial::extended(&MaterialParameters::default(), extensions, 3.0);
        Self { geometry, map, material, x, is_pressure, history, changes }
    }

    fn body(&self) -> Body<'_> {
        Body { geometry: &self.geometry, map: &self.map, material: &self.material }
    }

    fn stage(&self) -> Stage<'_> {
        Stage { x: &self.x, old: &self.history, dt: DT }
    }

    /// Residual and tangent from elements that are evaluated one by one in `f64`.
    fn reference(&self) -> Result<[Vec<f64>; 2], Inadmissible> {
        let mut sums = [vec![0.0; self.x.len()], vec![0.0; self.map.pattern.rows.len()]];
        for element in 0..ELEMENTS {
            let (mut residual, mut tangent) = ([0.0; UNKNOWNS], [[0.0; UNKNOWNS]; UNKNOWNS]);
            let places = (&self.geometry.elements[element], |v: &f64| *v);
            let (x, old) = (self.map.gather(element, &self.x), element_history(&self.history, element, 2));
            evaluate(places, &self.material, &x, old, DT, &mut residual, Some(&mut tangent))
                .ok_or(Inadmissible { element })?;
            let unknowns = &self.map.unknowns[element];
            for (i, &row) in unknowns.iter().enumerate() {
                sums[0][row as usize] += residual[i];
                for (j, &column) in unknowns.iter().enumerate() {
                    sums[1][self.map.pattern.position(row, column) as usize] += tangent[i][j];
                }
            }
        }
        Ok(sums)
    }

    /// Which entries of residual and tangent have the same unit.
    fn units(&self) -> [Vec<usize>; 2] {
        let unit = |row: usize| usize::from(self.is_pressure[row]);
        let mut tangent = vec![0; self.map.pattern.rows.len()];
        for column in 0..self.x.len() {
            let (first, rows) = self.map.pattern.column(column);
            for (k, &row) in rows.iter().enumerate() {
                tangent[first + k] = 2 * unit(column) + unit(row as usize);
            }
        }
        [(0..self.x.len()).map(unit).collect(), tangent]
    }
}

/// The plain material, one with every effect, and that with softening that takes time.
fn cases() -> [Case; 3] {
    let softening = Softening { loss: 0.3, strain: 0.2, delay: 0.0 };
    let all = Extensions {
        inverse_stress: 5e-3,
        permeability_exponent: 4.0,
        softening: Some(softening),
        ..Extensions::default()
    };
    let delayed = Extensions { softening: Some(Softening { delay: 2.0, ..softening }), ..all };
    [&Extensions::default(), &all, &delayed].map(Case::new)
}

/// Everything that loops over elements, in vectors of one kind.
struct Evaluate<'a>(&'a Case);

/// Residual, tangent, changes of the residual, then integrals, new history and its changes.
type Values = ([Vec<f64>; 3], [Vec<f64>; 3]);

impl WithSimd for Evaluate<'_> {
    type Output = Result<Values, Inadmissible>;

    // The loops are the functions that the model calls, not compiled once more.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let (case, body, stage) = (self.0, &self.0.body(), &self.0.stage());
        let count = COUNT;
        let (mut residual, mut values) = (vec![0.0; case.x.len()], vec![0.0; case.map.pattern.rows.len()]);
        let work = &mut Assemble { body, stage, residual: &mut residual, values: Some(&mut values) };
        simd.vectorize(Groups { work, elements: 0..ELEMENTS })?;
        let mut alone = vec![0.0; residual.len()];
        let work = &mut Assemble { body, stage, residual: &mut alone, values: None };
        simd.vectorize(Groups { work, elements: 0..ELEMENTS })?;
        assert_eq!(alone, residual, "without its tangent");
        let mut loads = vec![0.0; case.x.len() * count];
        let old = &case.changes;
        let work = &mut ResidualSensitivity { body, stage, old, loads: &mut loads };
        simd.vectorize(Groups { work, elements: 0..ELEMENTS })?;
        let own = &mut loads[case.x.len() * MaterialParameter::count(2)..];
        let work = &mut LoadsByMagnitude { body, stage, loads: own };
        simd.vectorize(Groups { work, elements: 0..ELEMENTS })?;

        let (mut sums, reach) = ([0.0; 4], 2.4);
        let mut new = case.history.clone();
        let work = &mut Update { body, stage, reach, new: &mut new, sums: &mut sums };
        simd.vectorize(Groups { work, elements: 0..ELEMENTS })?;
        let mut changed = case.changes.clone();
        let changes: Vec<f64> = (0..loads.len()).map(|k| 1e-5 * noise(k)).collect();
        let work = &mut UpdateSensitivity { body, stage, reach, changes: &changes, old, new: &mut changed };
        simd.vectorize(Groups { work, elements: 0..ELEMENTS })?;
        let work = &mut HistoryByInverseStress { body, stage, reach, parameters: count, new: &mut changed };
        simd.vectorize(Groups { work, elements: 0..ELEMENTS })?;

        let mut history = new.jacobian;
        history.extend(new.cv_inverse.iter().chain(&new.past_strain));
        // Of the last packet only the elements that there are.
        let own = |(k, packet): (usize, &Packet)| {
            let first = k / (POINTS * count) * 8;
            packet.0[..(ELEMENTS - first).min(8)].to_vec()
        };
        let mut history_changes: Vec<f64> = changed.jacobian.iter().enumerate().flat_map(own).collect();
        history_changes.extend(changed.past_strain.iter().enumerate().flat_map(own));
        let tensor = |(k, packet): (usize, &Packet)| own((k / 8, packet));
        history_changes.extend(changed.cv_inverse.as_flattened().iter().enumerate().flat_map(tensor));
        Ok(([residual, values, loads], [sums.to_vec(), history, history_changes]))
    }
}

fn assert_close(values: &[f64], exact: &[f64], unit: impl Fn(usize) -> usize) {
    assert_eq!(values.len(), exact.len());
    let mut largest = [0.0_f64; 2 * COUNT];
    exact.iter().enumerate().for_each(|(k, v)| largest[unit(k)] = largest[unit(k)].max(v.abs()));
    for (k, (value, exact)) in values.iter().zip(exact).enumerate() {
        let error = (value - exact).abs();
        assert!(error <= 1e-12 * largest[unit(k)], "{k}: {value:e}, not {exact:e}");
    }
}

#[test]
fn groups_add_up_like_single_elements() {
    for case in cases() {
        let ([residual, tangent], [residual_units, tangent_units]) =
            (case.reference().unwrap(), case.units());
        let all = on_every_machine(&|| Evaluate(&case));
        let first = all[0].as_ref().unwrap();
        for values in &all {
            let ([r, t, loads], [sums, history, history_changes]) = values.as_ref().unwrap();
            assert_close(r, &residual, |k| residual_units[k]);
            assert_close(t, &tangent, |k| tangent_units[k]);
            // The first are those of one lane.
            let n = case.x.len();
            assert_close(loads, &first.0[2], |k| 2 * (k / n) + residual_units[k % n]);
            assert_close(sums, &first.1[0], |k| k);
            assert_close(history, &first.1[1], |_| 0);
            assert_close(history_changes, &first.1[2], |_| 0);
        }
    }
}

#[test]
fn the_first_element_that_fails_is_told() {
    for element in [0, 3, 6, 9, 10] {
        let mut case = Case::new(&Extensions::default());
        // The middle node belongs to this element alone.
        let middle = case.map.unknowns[element][8] as usize;
        case.x[middle] += 2e-4;
        let failed = case.reference().unwrap_err();
        assert_eq!(failed, Inadmissible { element });
        for result in on_every_machine(&|| Evaluate(&case)) {
            assert_eq!(result.unwrap_err(), failed);
        }
    }
}
