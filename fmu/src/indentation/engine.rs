//! The two discretisations behind one type: what an instance runs on.

use super::contact::Touch;
use super::discretisation::{Discretisation, Patience, Reached};
use super::sample::Sample;
use super::step::{State, Stepper};
use crate::outputs::{ForceSensitivity, Outputs, Statistics};
use crate::parameters::{MeshKind, Parameters};
use crate::solid3d::sample::SolidSample;
use crate::solid3d::step::{SolidState, SolidStepper};
use crate::solver::multifrontal::StructureError;
use crate::solver::newton::NewtonFailure;
use serde::{Deserialize, Serialize};
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
                let Parameters { indenter, geometry, mesh, .. } = parameters;
                Self::Axisymmetric(Sample::shared_under(indenter, geometry, mesh)?)
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
                Self::Axisymmetric(Box::new(Stepper::new(parameters, sample.clone())))
            }
            Discretised::Paper3d(sample) => {
                Self::Paper3d(Box::new(SolidStepper::new(parameters, sample.clone())))
            }
        }
    }
}

/// A state of either discretisation.
// A path keeps its few states behind an `Arc` each.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum EngineState {
    /// Of the axisymmetric one.
    Axisymmetric(State),
    /// Of the quarter cylinder.
    Paper3d(SolidState),
}

impl Discretisation for Engine {
    type State = EngineState;

    fn undeformed(&self, time: f64) -> EngineState {
        match self {
            Self::Axisymmetric(stepper) => EngineState::Axisymmetric(stepper.undeformed(time)),
            Self::Paper3d(stepper) => EngineState::Paper3d(stepper.undeformed(time)),
        }
    }

    fn fits(&self, state: &EngineState) -> bool {
        match (self, state) {
            (Self::Axisymmetric(stepper), EngineState::Axisymmetric(state)) => stepper.fits(state),
            (Self::Paper3d(stepper), EngineState::Paper3d(state)) => stepper.fits(state),
            _ => false,
        }
    }

    fn force_scale(&self) -> f64 {
        match self {
            Self::Axisymmetric(stepper) => stepper.force_scale(),
            Self::Paper3d(stepper) => stepper.force_scale(),
        }
    }

    fn separates(&self) -> bool {
        match self {
            Self::Axisymmetric(stepper) => stepper.separates(),
            Self::Paper3d(stepper) => stepper.separates(),
        }
    }

    fn step(
        &mut self,
        old: &EngineState,
        start: f64,
        velocity: f64,
        dt: f64,
        patience: Patience,
        statistics: &mut Statistics,
    ) -> Result<EngineState, NewtonFailure> {
        match (self, old) {
            (Self::Axisymmetric(stepper), EngineState::Axisymmetric(old)) => stepper
                .step_with(old, (start, velocity), dt, patience, statistics)
                .map(EngineState::Axisymmetric),
            (Self::Paper3d(stepper), EngineState::Paper3d(old)) => {
                stepper.step(old, start, velocity, dt, statistics).map(EngineState::Paper3d)
            }
            _ => Err(NewtonFailure::ForeignState),
        }
    }
}

impl Reached for EngineState {
    fn time(&self) -> f64 {
        match self {
            Self::Axisymmetric(state) => state.time(),
            Self::Paper3d(state) => state.time(),
        }
    }

    fn outputs(&self) -> Outputs {
        match self {
            Self::Axisymmetric(state) => state.outputs(),
            Self::Paper3d(state) => state.outputs(),
        }
    }

    fn sensitivities(&self) -> Vec<ForceSensitivity> {
        match self {
            Self::Axisymmetric(state) => state.sensitivities(),
            Self::Paper3d(state) => state.sensitivities(),
        }
    }

    fn touch(&self) -> Touch {
        match self {
            Self::Axisymmetric(state) => state.touch(),
            Self::Paper3d(state) => state.touch(),
        }
    }

    fn touches_as(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Axisymmetric(a), Self::Axisymmetric(b)) => a.touches_as(b),
            _ => true,
        }
    }
}
