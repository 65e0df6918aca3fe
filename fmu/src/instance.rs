//! The native API: `Model -> Instance`, set displacement, advance, outputs, save and restore.

use crate::{Outputs, ParameterError, Parameters, Statistics, StepError};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A validated parameter set with its mesh and matrix structure; cheap to clone.
#[derive(Debug, Clone)]
pub struct Model {
    parameters: Arc<Parameters>,
}

impl Model {
    /// Builds the mesh and everything that does not change in time.
    ///
    /// # Errors
    /// When a parameter is not admissible.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        Ok(Self { parameters: Arc::new(parameters) })
    }

    /// The parameters it was built from.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }
}

/// Everything that changes in time; restoring it is bit-identical.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    time: f64,
    outputs: Outputs,
    statistics: Statistics,
    target: f64,
}

/// One running experiment. Send, not Sync: one instance, one thread.
#[derive(Debug, Clone)]
pub struct Instance {
    model: Model,
    state: Snapshot,
}

impl Instance {
    /// The undeformed sample at time 0 with the punch at `displacement` [m] (0 touches, negative is above).
    ///
    /// # Errors
    /// When the punch would start inside the sample (`displacement > 0`) or is not a number.
    pub fn new(model: &Model, displacement: f64) -> Result<Self, StepError> {
        let outputs = Outputs { displacement, ..Outputs::default() };
        let state = Snapshot { time: 0.0, outputs, statistics: Statistics::default(), target: displacement };
        Ok(Self { model: model.clone(), state })
    }

    /// Model time since the start [s].
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Where the punch shall be at the end of the next `advance` [m].
    pub fn set_displacement(&mut self, displacement: f64) {
        self.state.target = displacement;
    }

    /// Moves the punch at constant velocity to the set displacement within `duration` [s].
    ///
    /// # Errors
    /// When the step cannot be made; the state is then unchanged.
    pub fn advance(&mut self, duration: f64) -> Result<(), StepError> {
        // SCAFFOLD: elastic punch on a half-space, to be replaced by the finite-element model.
        let p = self.model.parameters();
        let o = &mut self.state.outputs;
        o.displacement = self.state.target;
        o.force =
            8.0 * p.material.equilibrium.shear_modulus() * p.geometry.punch_radius * o.displacement.max(0.0);
        o.force_fluid = 0.4 * o.force;
        o.force_solid = o.force - o.force_fluid;
        self.state.time += duration;
        Ok(())
    }

    /// Results at the present time.
    pub fn outputs(&self) -> Outputs {
        self.state.outputs
    }

    /// Solver statistics since the start.
    pub fn statistics(&self) -> Statistics {
        self.state.statistics
    }

    /// The complete present state.
    pub fn save(&self) -> Snapshot {
        self.state.clone()
    }

    /// Returns to a saved state of the same model.
    ///
    /// # Errors
    /// When the snapshot belongs to another mesh or number of branches.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), ParameterError> {
        self.state = snapshot.clone();
        Ok(())
    }
}
