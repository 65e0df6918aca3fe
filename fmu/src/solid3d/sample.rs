//! The discretised quarter: mesh, assembly map and matrix structure, shared by all instances.

use super::assembly::{AssemblyMap, SolidBody};
use super::forest::{PAPER, Refinement};
use super::geometry::Geometry;
use super::linear::analyse;
use super::mesh::Mesh;
use super::point::SolidMaterial;
use crate::mesh::parameters::GeometryParameters;
use crate::registry::Registry;
use crate::solver::multifrontal::{StructureError, Symbolic};
use std::sync::Arc;

/// Everything that depends on the mesh alone.
#[derive(Debug)]
pub struct SolidSample {
    /// The mesh.
    pub mesh: Mesh,
    /// Reference geometry of the integration points.
    pub geometry: Geometry,
    /// Cell unknowns and positions in the matrix.
    pub map: AssemblyMap,
    /// Symbolic factorisation.
    pub symbolic: Arc<Symbolic>,
}

impl SolidSample {
    /// The sample of a geometry.
    ///
    /// # Errors
    /// When the mesh has too many unknowns.
    pub fn new(geometry: &GeometryParameters, refinement: Refinement<'_>) -> Result<Self, StructureError> {
        let mesh = Mesh::new(geometry, refinement);
        let map = AssemblyMap::new(&mesh);
        let symbolic = analyse(&mesh, &map)?;
        Ok(Self { geometry: Geometry::new(&mesh), mesh, map, symbolic })
    }

    /// The sample made of a material.
    pub fn body<'a>(&'a self, material: &'a SolidMaterial) -> SolidBody<'a> {
        SolidBody { geometry: &self.geometry, map: &self.map, material }
    }

    /// The sample of a geometry with the paper's refinement; equal ones that are alive share it.
    ///
    /// # Errors
    /// When the mesh has too many unknowns.
    pub fn shared(geometry: &GeometryParameters) -> Result<Arc<Self>, StructureError> {
        LIVE.share(geometry.clone(), || Self::new(geometry, PAPER))
    }
}

static LIVE: Registry<GeometryParameters, SolidSample> = Registry::new();

impl Drop for SolidSample {
    fn drop(&mut self) {
        LIVE.forget_dead();
    }
}
