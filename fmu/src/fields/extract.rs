//! The fields of a state of the axisymmetric sample.

use super::quantity::{Local, QUANTITIES, Support};
use super::smooth::{Smoothing, place};
use super::{Field, Fields, FieldsError};
use crate::element::assembly::AssemblyMap;
use crate::element::geometry::{ElementGeometry, Geometry};
use crate::element::kernel::{Point, PointState};
use crate::element::shape::Shape;
use crate::element::{History, element_history};
use crate::law::{IDENTITY, PointMaterial};
use crate::mesh::{CORNERS, Mesh, NODES, UNKNOWNS};

/// Local nodes in the order of VTK's biquadratic quadrilateral.
const VTK_ORDER: [usize; NODES] = [0, 2, 8, 6, 1, 5, 7, 3, 4];

/// The sample and its state, at rest in time: nothing flows any further.
#[derive(Debug, Clone, Copy)]
pub struct FieldSource<'a> {
    /// Nodes and elements.
    pub mesh: &'a Mesh,
    /// Quadrature points.
    pub geometry: &'a Geometry,
    /// Unknowns of the elements.
    pub map: &'a AssemblyMap,
    /// Constitutive laws at this time.
    pub material: &'a PointMaterial,
    /// Displacements (m) and pressures (Pa).
    pub x: &'a [f64],
    /// History at this very time.
    pub history: &'a History,
    /// Nodes that the punch touches.
    pub touched: &'a [u32],
}

/// Quantities of the 3 x 3 points: extra stress without its volumetric part, seepage, dissipations, stretch.
const GAUSS: usize = 9;
/// Quantities of the 2 x 2 points: J and the volumetric stress.
const VOLUMETRIC: usize = 2;

/// Values of one element's quadrature points.
struct ElementValues {
    gauss: [[f64; GAUSS]; NODES],
    volumetric: [[f64; VOLUMETRIC]; CORNERS],
    /// Mean pressure (Pa) and volume (m^3).
    pressure: f64,
    volume: f64,
}

/// Sums over the elements around a node.
#[derive(Clone, Copy, Default)]
struct Gathered {
    gauss: [f64; GAUSS],
    volumetric: [f64; VOLUMETRIC],
    pressure: f64,
    count: f64,
}

/// All fields.
///
/// # Errors
/// When an element cannot be evaluated.
pub fn extract(source: &FieldSource<'_>) -> Result<Fields, FieldsError> {
    let FieldSource { mesh, geometry, map, x, .. } = *source;
    let smoothing = Smoothing::new();
    let corner_weights: [[f64; CORNERS]; NODES] = std::array::from_fn(|k| Shape::at(place(k), 0.0).p);
    let mut nodes = vec![Gathered::default(); mesh.nodes.len()];
    let mut means = Vec::with_capacity(mesh.elements.len());
    for (index, (element, places)) in mesh.elements.iter().zip(&geometry.elements).enumerate() {
        let x_e = map.gather(index, x);
        let state = element_history(source.history, index, source.material.branches());
        let values =
            evaluate(source.material, places, &x_e, state).ok_or(FieldsError::Inadmissible(index))?;
        for (k, &node) in element.nodes.iter().enumerate() {
            let node = &mut nodes[node as usize];
            add(&mut node.gauss, &smoothing.gauss[k], &values.gauss);
            add(&mut node.volumetric, &smoothing.volumetric[k], &values.volumetric);
            node.pressure += corner_weights[k].iter().zip(&x_e[2 * NODES..]).map(|(w, p)| w * p).sum::<f64>();
            node.count += 1.0;
        }
        means.push(mean(source.material, places, &values));
    }
    let mut touched = vec![false; mesh.nodes.len()];
    source.touched.iter().for_each(|&node| touched[node as usize] = true);
    let at_node = |(index, node): (usize, &Gathered)| {
        let unknown = mesh.displacement(index as u32);
        let average = |sum: f64| sum / node.count;
        Local {
            displacement: [x[unknown], x[unknown + 1]],
            contact: touched[index],
            ..local(
                source.material,
                &node.gauss.map(average),
                &node.volumetric.map(average),
                average(node.pressure),
            )
        }
    };
    let nodes: Vec<Local> = nodes.iter().enumerate().map(at_node).collect();
    Ok(Fields {
        points: mesh.nodes.iter().map(|&[r, z]| [r, 0.0, z]).collect(),
        cells: mesh.elements.iter().map(|e| VTK_ORDER.map(|k| e.nodes[k])).collect(),
        point_data: fields(&nodes, Support::Cells),
        cell_data: fields(&means, Support::Points),
    })
}

fn evaluate(
    material: &PointMaterial,
    places: &ElementGeometry,
    x: &[f64; UNKNOWNS],
    state: PointState<'_>,
) -> Option<ElementValues> {
    let branches = material.branches();
    let (mut unused, mut pressure, mut volume) = (vec![IDENTITY; branches], 0.0, 0.0);
    let (mut gauss, mut volumetric) = ([[0.0; GAUSS]; NODES], [[0.0; VOLUMETRIC]; CORNERS]);
    for (k, place) in places.points.iter().enumerate() {
        let point = Point::at(place, x)?;
        let (f, j, cv) = (&point.f, point.jacobian, &state.cv_inverse[k * branches..(k + 1) * branches]);
        // No time passes: the history is that of this very time.
        let mut elasticity = material.elasticity(f, cv, 0.0)?;
        let mut viscous = material.update(f, cv, 0.0, 1.0, &mut unused)?.viscous_dissipation_rate;
        if let Some(softening) = &material.softening {
            let past = *state.past_strain.get(k)?;
            softening.apply(f, (past, 0.0), &mut elasticity)?;
            viscous *= softening.factor(past);
        }
        let [rr, zz, tt, rz] = elasticity.kirchhoff_stress.map(|tau| tau / j);
        let (mobility, _) = material.darcy.referential_mobility(j);
        let g = point.grad_p;
        let (seepage, porous) = (g.map(|g| -mobility / j * g), mobility * (g[0] * g[0] + g[1] * g[1]));
        let stretch = f.plane[0][1].hypot(f.plane[1][1]);
        gauss[k] = [rr, zz, tt, rz, seepage[0], seepage[1], viscous, porous, stretch];
        pressure += place.measure * point.pressure;
        volume += place.measure;
    }
    for (values, place) in volumetric.iter_mut().zip(&places.volumetric) {
        let Point { jacobian: j, dilatation, .. } = Point::at(place, x)?;
        *values = [j, material.volumetric_stress(dilatation)?.0 / j];
    }
    Some(ElementValues { gauss, volumetric, pressure: pressure / volume, volume })
}

fn mean(material: &PointMaterial, places: &ElementGeometry, values: &ElementValues) -> Local {
    let gauss = places.points.each_ref().map(|p| p.measure / values.volume);
    let whole: f64 = places.volumetric.iter().map(|p| p.measure).sum();
    let volumetric = places.volumetric.each_ref().map(|p| p.measure / whole);
    let (mut a, mut b) = ([0.0; GAUSS], [0.0; VOLUMETRIC]);
    add(&mut a, &gauss, &values.gauss);
    add(&mut b, &volumetric, &values.volumetric);
    Local { volume: values.volume, ..local(material, &a, &b, values.pressure) }
}

/// `sum += weights . rows`.
fn add<const Q: usize>(sum: &mut [f64; Q], weights: &[f64], rows: &[[f64; Q]]) {
    for (weight, row) in weights.iter().zip(rows) {
        sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
    }
}

fn local(
    material: &PointMaterial,
    gauss: &[f64; GAUSS],
    volumetric: &[f64; VOLUMETRIC],
    pressure: f64,
) -> Local {
    let [rr, zz, tt, rz, seepage_r, seepage_z, viscous, porous, stretch] = *gauss;
    let [jacobian, bulk] = *volumetric;
    Local {
        n0s: material.n0s(),
        pressure,
        jacobian,
        stretch,
        effective: [rr + bulk, zz + bulk, tt + bulk, rz],
        seepage: [seepage_r, seepage_z],
        viscous,
        porous,
        ..Local::default()
    }
}

fn fields(locals: &[Local], absent: Support) -> Vec<Field> {
    let one = |quantity: &'static super::Quantity| {
        let row = |local| (quantity.of)(local).into_iter().take(quantity.components.len());
        Field { quantity, values: locals.iter().flat_map(row).collect() }
    };
    QUANTITIES.iter().filter(|quantity| quantity.place != absent).map(one).collect()
}
