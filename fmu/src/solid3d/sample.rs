//! The discretised quarter: mesh, assembly map and matrix structure, shared by all instances.

use super::assembly::AssemblyMap;
use super::forest::{PAPER, Refinement};
use super::geometry::Geometry;
use super::linear::analyse;
use super::mesh::Mesh;
use crate::mesh::parameters::GeometryParameters;
use crate::solver::multifrontal::{StructureError, Symbolic};
use std::sync::{Arc, Mutex, PoisonError, Weak};

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

    /// The sample of a geometry with the paper's refinement; equal ones that are alive share it.
    ///
    /// # Errors
    /// When the mesh has too many unknowns.
    pub fn shared(geometry: &GeometryParameters) -> Result<Arc<Self>, StructureError> {
        let mut live = LIVE.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(sample) = live.iter().find(|(g, _)| g == geometry).and_then(|(_, s)| s.upgrade()) {
            return Ok(sample);
        }
        let sample = Arc::new(Self::new(geometry, PAPER)?);
        live.push((geometry.clone(), Arc::downgrade(&sample)));
        Ok(sample)
    }
}

static LIVE: Mutex<Vec<(GeometryParameters, Weak<SolidSample>)>> = Mutex::new(Vec::new());

impl Drop for SolidSample {
    /// Forgets dead entries at once: a host that unloads the library shall not keep their memory.
    fn drop(&mut self) {
        let mut live = LIVE.lock().unwrap_or_else(PoisonError::into_inner);
        live.retain(|(_, sample)| sample.strong_count() > 0);
        live.shrink_to_fit();
    }
}
