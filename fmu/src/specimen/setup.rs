//! What a specimen under a punch is made from.

use crate::contact::adhesion::Adhesion;
use crate::contact::parameters::{BoundaryParameters, IndenterParameters};
use crate::law::extensions::Extensions;
use crate::law::parameters::MaterialParameters;
use crate::mesh::parameters::GeometryParameters;
use crate::solver::parameters::SolverParameters;

/// Everything that the stages of a specimen depend on, besides its mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Laws.
    pub material: MaterialParameters,
    /// What the laws leave out.
    pub extensions: Extensions,
    /// Punch and sample.
    pub geometry: GeometryParameters,
    /// Shape of the punch's face.
    pub indenter: IndenterParameters,
    /// Boundary conditions.
    pub boundary: BoundaryParameters,
    /// Adhesion on the punch.
    pub adhesion: Adhesion,
    /// Stiffness of a shear layer under the punch (Pa/m), where there is one; it takes the place of the bond.
    pub shear_layer: Option<f64>,
    /// Compliance of the machine (m/N).
    pub compliance: f64,
    /// Time stepping and Newton iteration.
    pub solver: SolverParameters,
}
