//! The two discretisations: what an instance runs on.

use crate::mesh::parameters::MeshKind;
use crate::parameters::Parameters;
use crate::solid3d::sample::SolidSample;
use crate::solid3d::step::SolidStepper;
use crate::solver::multifrontal::StructureError;
use crate::specimen::{Discretisation, Sample, Stepper};
use std::sync::Arc;

/// A discretised sample, shared by all instances of its geometry and mesh.
#[derive(Debug, Clone)]
pub enum Discretised {
    /// Axisymmetric elements.
    Axisymmetric(Arc<Sample>),
    /// Hexahedra in a quarter of the cylinder.
    Paper3d(Arc<SolidSample>),
}

impl Discretised {
    /// The sample of a parameter set.
    ///
    /// # Errors
    /// When the mesh has too many unknowns.
    pub fn shared(parameters: &Parameters) -> Result<Self, StructureError> {
        Ok(match parameters.mesh.kind {
            MeshKind::Axisymmetric => {
                let Parameters { indenter, geometry, .. } = parameters;
                Self::Axisymmetric(Sample::shared_under(indenter, geometry, &parameters.resolved_mesh())?)
            }
            MeshKind::Paper3d => Self::Paper3d(SolidSample::shared(&parameters.geometry)?),
        })
    }

    /// Number of unknowns; hanging nodes have none.
    pub fn unknowns(&self) -> usize {
        match self {
            Self::Axisymmetric(sample) => sample.mesh.unknowns(),
            Self::Paper3d(sample) => sample.mesh.unknowns(),
        }
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        match self {
            Self::Axisymmetric(sample) => sample.mesh.elements.len(),
            Self::Paper3d(sample) => sample.mesh.cells.len(),
        }
    }
}

/// Makes the steps of one instance.
pub enum Engine {
    /// Axisymmetric elements.
    Axisymmetric(Box<Stepper>),
    /// Hexahedra in a quarter of the cylinder.
    Paper3d(Box<SolidStepper>),
}

impl Engine {
    /// An engine for a parameter set on its sample.
    pub fn new(parameters: &Parameters, sample: &Discretised) -> Self {
        match sample {
            Discretised::Axisymmetric(sample) => {
                Self::Axisymmetric(Box::new(Stepper::new(&parameters.setup(), sample.clone())))
            }
            Discretised::Paper3d(sample) => {
                Self::Paper3d(Box::new(SolidStepper::new(parameters, sample.clone())))
            }
        }
    }

    /// What makes the steps.
    pub fn discretisation(&self) -> &dyn Discretisation {
        match self {
            Self::Axisymmetric(stepper) => &**stepper,
            Self::Paper3d(stepper) => &**stepper,
        }
    }

    /// The same to make them.
    pub fn discretisation_mut(&mut self) -> &mut dyn Discretisation {
        match self {
            Self::Axisymmetric(stepper) => &mut **stepper,
            Self::Paper3d(stepper) => &mut **stepper,
        }
    }
}
