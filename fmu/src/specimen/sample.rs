//! The discretised sample: mesh, assembly map and matrix structure, shared by all instances.

use crate::contact::parameters::IndenterParameters;
use crate::element::geometry::Geometry;
use crate::element::{AssemblyMap, Body};
use crate::law::PointMaterial;
use crate::mesh::Mesh;
use crate::mesh::parameters::{GeometryParameters, MeshParameters};
use crate::registry::Registry;
use crate::solver::linear::Structure;
use crate::solver::multifrontal::{self, StructureError};
use std::sync::Arc;

/// Everything that depends on the mesh alone.
#[derive(Debug)]
pub struct Sample {
    /// The mesh.
    pub mesh: Mesh,
    /// Reference geometry of the integration points.
    pub geometry: Geometry,
    /// Element unknowns and positions in the matrix.
    pub map: AssemblyMap,
    /// Pattern and symbolic factorisation.
    pub structure: Arc<Structure>,
}

impl Sample {
    /// Builds the sample of a mesh.
    ///
    /// # Errors
    /// When the mesh has too many unknowns.
    pub fn from_mesh(mesh: Mesh) -> Result<Self, StructureError> {
        let map = AssemblyMap::new(&mesh);
        let geometry = Geometry::new(&mesh);
        let structure = Arc::new(Structure::analyse(map.pattern.clone(), &connectivity(&mesh))?);
        Ok(Self { mesh, geometry, map, structure })
    }

    /// The sample made of a material.
    pub fn body<'a>(&'a self, material: &'a PointMaterial) -> Body<'a> {
        Body { geometry: &self.geometry, map: &self.map, material }
    }

    /// The sample of a geometry under a flat punch.
    ///
    /// # Errors
    /// When the mesh has too many unknowns.
    pub fn shared(geometry: &GeometryParameters, mesh: &MeshParameters) -> Result<Arc<Self>, StructureError> {
        Self::shared_under(&IndenterParameters::default(), geometry, mesh)
    }

    /// The sample of a geometry under an indenter; equal ones with equal meshes that are alive share one.
    ///
    /// # Errors
    /// When the mesh has too many unknowns.
    pub fn shared_under(
        indenter: &IndenterParameters,
        geometry: &GeometryParameters,
        mesh: &MeshParameters,
    ) -> Result<Arc<Self>, StructureError> {
        let contact_edge = indenter.contact_edge_from(geometry.punch_radius);
        LIVE.share((contact_edge, geometry.clone(), mesh.clone()), || {
            if Mesh::is_too_large(contact_edge, geometry, mesh) {
                return Err(StructureError::TooLarge);
            }
            Self::from_mesh(Mesh::under(contact_edge, geometry, mesh))
        })
    }
}

type Key = (Option<f64>, GeometryParameters, MeshParameters);
static LIVE: Registry<Key, Sample> = Registry::new();

impl Drop for Sample {
    fn drop(&mut self) {
        LIVE.forget_dead();
    }
}

/// The mesh as the ordering sees it.
pub fn connectivity(mesh: &Mesh) -> multifrontal::Connectivity {
    let mut elements = Vec::with_capacity(mesh.elements.len());
    let mut centroids = Vec::with_capacity(mesh.elements.len());
    for element in &mesh.elements {
        // A collapsed side names its node three times.
        let mut unknowns = mesh.element_unknowns(element).to_vec();
        unknowns.sort_unstable();
        unknowns.dedup();
        elements.push(unknowns);
        let mean = |d: usize| 0.25 * element.corners.iter().map(|c| c[d]).sum::<f64>();
        centroids.push([mean(0), mean(1), 0.0]);
    }
    let rank = mesh.pressure_mask().into_iter().map(u8::from).collect();
    multifrontal::Connectivity { unknowns: mesh.unknowns(), elements, centroids, rank }
}
