//! From elements to the global sparse system.

use super::History;
use super::geometry::{FacePoint, Geometry};
use super::group::{ElementLoop, Group};
use super::kernel::{self, PointState, Tangent};
use super::shape::POINTS;
use crate::law::{IDENTITY, PointMaterial};
use crate::mesh::{Mesh, NODES, UNKNOWNS};
use crate::number::{Lanes, PACKET, Packet, closure};
use crate::solver::linear::CscPattern;
use pulp::Simd;

/// History of the undeformed state of an axisymmetric mesh.
pub fn undeformed(elements: usize, branches: usize) -> History {
    History::undeformed(elements * POINTS, branches, &IDENTITY)
}

/// History of one element.
#[inline(always)]
pub fn element_history(history: &History, element: usize, branches: usize) -> PointState<'_> {
    let first = element * POINTS;
    PointState {
        jacobian: &history.jacobian[first..first + POINTS],
        cv_inverse: &history.tensors()[first * branches..(first + POINTS) * branches],
        past_strain: history.past_strain.get(first..first + POINTS).unwrap_or(&[]),
    }
}

/// Where every entry of every element goes, computed once per mesh.
#[derive(Debug, Clone)]
pub struct AssemblyMap {
    /// Unknowns of every element.
    pub unknowns: Vec<[u32; UNKNOWNS]>,
    /// Positions in the CSC values, entry by entry of [`PACKET`] elements at a time; elements that fill up the
    /// last packet add nothing, anywhere.
    positions: Vec<[u32; PACKET]>,
    /// Pattern of the matrix, structurally symmetric.
    pub pattern: CscPattern,
}

impl AssemblyMap {
    /// Builds pattern and positions.
    pub fn new(mesh: &Mesh) -> Self {
        let unknowns: Vec<_> = mesh.elements.iter().map(|e| mesh.element_unknowns(e)).collect();
        let pattern = CscPattern::from_elements(mesh.unknowns(), &unknowns);
        let mut positions = Vec::with_capacity(unknowns.len().div_ceil(PACKET) * ENTRIES);
        for elements in unknowns.chunks(PACKET) {
            for (i, j) in (0..ENTRIES).map(|entry| (entry / UNKNOWNS, entry % UNKNOWNS)) {
                positions.push(std::array::from_fn(|lane| {
                    elements.get(lane).map_or(0, |element| pattern.position(element[i], element[j]))
                }));
            }
        }
        Self { unknowns, positions, pattern }
    }

    /// Where an entry of an element goes.
    #[inline(always)]
    fn position(&self, element: usize, i: usize, j: usize) -> usize {
        self.positions[element / PACKET * ENTRIES + i * UNKNOWNS + j][element % PACKET] as usize
    }

    /// Unknowns `x` of one element.
    #[inline(always)]
    pub fn gather(&self, element: usize, x: &[f64]) -> [f64; UNKNOWNS] {
        self.unknowns[element].map(|u| x[u as usize])
    }

    /// Adds the tangents of a group's elements, entry by entry.
    #[inline(always)]
    fn scatter_tangent<S: Simd>(&self, group: &Group<S>, tangent: &Tangent<Lanes<S>>, values: &mut [f64]) {
        let positions = &self.positions[group.packet() * ENTRIES..][..ENTRIES];
        for (value, targets) in tangent.as_flattened().iter().zip(positions) {
            for (&value, &target) in value.as_slice().iter().zip(&targets[group.places()]) {
                values[target as usize] += value;
            }
        }
    }
}

/// Entries of an element's tangent.
const ENTRIES: usize = UNKNOWNS * UNKNOWNS;

/// The element where an evaluation failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Inadmissible {
    /// Element index.
    pub element: usize,
}

/// A material on a mesh.
#[derive(Debug, Clone, Copy)]
pub struct Body<'a> {
    /// Integration points.
    pub geometry: &'a Geometry,
    /// Unknowns and pattern.
    pub map: &'a AssemblyMap,
    /// Constitutive laws.
    pub material: &'a PointMaterial,
}

/// One implicit stage: the unknowns at its end and what it started from.
#[derive(Debug, Clone, Copy)]
pub struct Stage<'a> {
    /// Displacements (m) and pressures (Pa).
    pub x: &'a [f64],
    /// History at its start.
    pub old: &'a History,
    /// Its length (s).
    pub dt: f64,
}

impl Body<'_> {
    /// Residual of the whole mesh, and its tangent where it is asked for, in SI units and without boundary conditions.
    ///
    /// # Errors
    /// The first element that is turned inside out, compacted or too strained.
    pub fn assemble(
        &self,
        stage: &Stage<'_>,
        residual: &mut [f64],
        mut values: Option<&mut [f64]>,
    ) -> Result<(), Inadmissible> {
        residual.fill(0.0);
        if let Some(values) = values.as_deref_mut() {
            values.fill(0.0);
        }
        Assemble { body: self, stage, residual, values }.run(self.geometry.elements.len())
    }

    /// Adds a layer under the punch that holds back radial displacement: `stiffness` (Pa/m) per reference area,
    /// at those of the face's points that are in contact.
    pub fn add_shear_layer(
        &self,
        (stiffness, closed): (f64, &[bool]),
        x: &[f64],
        residual: &mut [f64],
        values: Option<&mut [f64]>,
    ) {
        self.add_layer_forces((stiffness, closed), x, residual);
        let Some(values) = values else { return };
        for face in self.layer_points(closed) {
            let place = &face.geometry;
            let traction = stiffness * place.measure;
            for a in 0..NODES {
                for b in 0..NODES {
                    values[self.map.position(face.element, 2 * a, 2 * b)] +=
                        traction * place.n[a] * place.n[b];
                }
            }
        }
    }

    /// The forces of that layer (N) alone.
    pub fn add_layer_forces(&self, (stiffness, closed): (f64, &[bool]), x: &[f64], residual: &mut [f64]) {
        for face in self.layer_points(closed) {
            let (place, x_e) = (&face.geometry, self.map.gather(face.element, x));
            let slip: f64 = (0..NODES).map(|a| place.n[a] * x_e[2 * a]).sum();
            let traction = stiffness * place.measure;
            let unknowns = &self.map.unknowns[face.element];
            for a in 0..NODES {
                residual[unknowns[2 * a] as usize] += traction * place.n[a] * slip;
            }
        }
    }

    /// The face's points where the layer is sheared: those in contact.
    fn layer_points<'b>(&'b self, closed: &'b [bool]) -> impl Iterator<Item = &'b FacePoint> {
        let sheared = |(face, closed): &(&FacePoint, &bool)| **closed && face.is_under_punch();
        self.geometry.face.iter().zip(closed).filter(sheared).map(|(face, _)| face)
    }
}

/// The loop of [`Body::assemble`].
pub(super) struct Assemble<'a> {
    pub body: &'a Body<'a>,
    pub stage: &'a Stage<'a>,
    pub residual: &'a mut [f64],
    pub values: Option<&'a mut [f64]>,
}

impl ElementLoop for Assemble<'_> {
    #[inline(always)]
    fn group<S: Simd>(&mut self, group: &Group<S>) -> Option<()> {
        let Self { body: Body { geometry, map, material }, stage, residual, values } = self;
        let places = group.geometry(geometry);
        let load = closure!(|packet: &Packet| group.load(packet));
        let x = group.unknowns(map, stage.x);
        let old = group.history(stage.old);
        let zero = group.splat(0.0);
        let (at, old, mut own) = ((places, load), old.state(), [zero; UNKNOWNS]);
        match values {
            None => kernel::evaluate(at, material, &x, old, stage.dt, &mut own, None)?,
            Some(values) => {
                let mut tangent = [[zero; UNKNOWNS]; UNKNOWNS];
                kernel::evaluate(at, material, &x, old, stage.dt, &mut own, Some(&mut tangent))?;
                map.scatter_tangent(group, &tangent, values);
            }
        }
        group.scatter(map, &own, residual);
        Some(())
    }
}
