//! The native API: `Model -> Instance`, set displacement, advance, outputs, save and restore.

use crate::engine::{Discretised, Engine};
use crate::fields::{Fields, FieldsError};
use crate::motion::{Path, Reached, Stops};
use crate::outputs::ForceSensitivity;
use crate::specimen::Discretisation;
use crate::{Outputs, ParameterError, Parameters, Statistics, StepError};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A pull beyond this fraction of the force scale counts as tension.
const TENSION: f64 = 1e-6;

/// A validated parameter set with its mesh and matrix structure; cheap to clone.
#[derive(Debug, Clone)]
pub struct Model {
    parameters: Arc<Parameters>,
    sample: Discretised,
}

impl Model {
    /// Builds the mesh and everything that does not change in time.
    ///
    /// # Errors
    /// When a parameter is not admissible.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        let sample = Discretised::shared(&parameters).map_err(|_| ParameterError::TooLarge)?;
        Ok(Self { parameters: Arc::new(parameters), sample })
    }

    /// The parameters it was built from.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Number of unknowns, prescribed ones included; hanging nodes have none.
    pub fn unknowns(&self) -> usize {
        self.sample.unknowns()
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        self.sample.elements()
    }
}

/// Everything that changes in time; restoring it is bit-identical.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    time: f64,
    target: f64,
    outputs: Outputs,
    statistics: Statistics,
    /// The integrated path since first touch.
    path: Option<Path>,
}

impl Snapshot {
    /// Whether a run could have reached it, as far as that can be told: it may come from anywhere.
    pub(crate) fn is_sound(&self) -> bool {
        self.time.is_finite()
            && self.target.is_finite()
            && self.outputs.displacement.is_finite()
            && self.path.as_ref().is_none_or(Path::is_sound)
    }
}

/// One running experiment. Send, not Sync: one instance, one thread.
pub struct Instance {
    model: Model,
    engine: Engine,
    state: Snapshot,
}

impl std::fmt::Debug for Instance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Instance").field("time", &self.state.time).finish_non_exhaustive()
    }
}

impl Instance {
    /// The undeformed sample at time 0 with the punch at `displacement` (m) (0 touches, negative is above).
    ///
    /// # Errors
    /// When the punch would start inside the sample (`displacement > 0`) or is not a number.
    pub fn new(model: &Model, displacement: f64) -> Result<Self, StepError> {
        if !displacement.is_finite() {
            return Err(StepError::BadDisplacement(displacement));
        }
        // From here on and in the state, displacements count from the true surface.
        let displacement = displacement + model.parameters.effect.offset.height;
        if displacement > 0.0 {
            return Err(StepError::StartsInside(displacement));
        }
        let outputs = Outputs { displacement, ..Outputs::default() };
        let state = Snapshot {
            time: 0.0,
            target: displacement,
            outputs,
            statistics: Statistics::default(),
            path: None,
        };
        let engine = Engine::new(&model.parameters, &model.sample);
        Ok(Self { model: model.clone(), engine, state })
    }

    /// Model time since the start (s).
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Where the punch shall be at the end of the next `advance` (m).
    pub fn set_displacement(&mut self, displacement: f64) {
        self.state.target = displacement + self.model.parameters.effect.offset.height;
    }

    /// Moves the punch at constant velocity to the set displacement within `duration` (s).
    ///
    /// # Errors
    /// When the step cannot be made; the state is then unchanged.
    pub fn advance(&mut self, duration: f64) -> Result<(), StepError> {
        self.advance_until(duration, Stops::default()).map(|_| ())
    }

    /// The same, but no further than to the first of what `stops` names: how long it took (s), and what is there.
    ///
    /// # Errors
    /// As [`Instance::advance`].
    pub fn advance_until(&mut self, duration: f64, stops: Stops) -> Result<(f64, Reached), StepError> {
        let target = self.state.target;
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(StepError::BadDuration(duration));
        }
        if !target.is_finite() {
            return Err(StepError::BadDisplacement(target));
        }
        let sample_height = self.model.parameters.geometry.sample_height;
        if target >= sample_height {
            return Err(StepError::TooDeep { displacement: target, sample_height });
        }
        let mut next = self.state.clone();
        let reached = self.advance_state(&mut next, duration, stops)?;
        let begun = std::mem::replace(&mut self.state, next).time;
        let is_end = matches!(reached, Reached::End) || self.state.time >= begun + duration;
        Ok((if is_end { duration } else { self.state.time - begun }, reached))
    }

    fn advance_state(
        &mut self,
        state: &mut Snapshot,
        duration: f64,
        stops: Stops,
    ) -> Result<Reached, StepError> {
        let (mut now, mut from) = (state.time, state.outputs.displacement);
        let (end, to) = (state.time + duration, state.target);
        state.time = end;
        if state.path.is_none() {
            if to > 0.0 {
                now += duration * (-from / (to - from));
            }
            let lands = from < 0.0 && to >= 0.0;
            // A punch that arrives at the surface within rounding has not touched it yet.
            if to <= 0.0 || now >= end {
                state.outputs.displacement = to.min(0.0);
                return Ok(if lands { Reached::Contact } else { Reached::End });
            }
            if lands && stops.events {
                (state.time, state.outputs.displacement) = (now, 0.0);
                return Ok(Reached::Contact);
            }
            from = 0.0;
            let cell = self.model.parameters.load_cell();
            state.path = Some(Path::touch(self.engine.discretisation(), now).with_load_cell(&cell));
        }
        let Some(path) = &mut state.path else { return Ok(Reached::End) };
        let retraction = StepError::Retraction { time: end, displacement: to };
        // Where the punch cannot leave the sample, it must not pull at it.
        let bonded = !self.engine.discretisation().constants().separates;
        if bonded && to < 0.0 {
            return Err(retraction);
        }
        let mut reached = Reached::End;
        if end > now {
            let Parameters { solver, geometry, .. } = self.model.parameters();
            let radius = geometry.reach();
            let statistics = &mut state.statistics;
            let discretisation = self.engine.discretisation_mut();
            (state.outputs, state.time, reached) = path.advance_until(
                discretisation,
                solver,
                radius,
                (now, from),
                (end, to),
                stops,
                statistics,
            )?;
        }
        if bonded
            && state.outputs.force_specimen < -TENSION * self.engine.discretisation().constants().force_scale
        {
            return Err(retraction);
        }
        Ok(reached)
    }

    /// Results at the present time.
    pub fn outputs(&self) -> Outputs {
        let effect = &self.model.parameters.effect;
        let mut outputs = self.state.outputs;
        outputs.indentation = outputs.displacement - effect.compliance.per_newton * outputs.force_specimen;
        outputs.displacement -= effect.offset.height;
        outputs.force = self.model.parameters.load_cell().drifted(outputs.force, self.state.time);
        outputs
    }

    /// Fields at the present time, computed beside the run, which goes on as if nobody had asked.
    ///
    /// # Errors
    /// When the model is three-dimensional, or the state at this very time cannot be computed.
    pub fn fields(&mut self) -> Result<Fields, FieldsError> {
        let Engine::Axisymmetric(stepper) = &mut self.engine else { return Err(FieldsError::NotIn3d) };
        let (time, path) = (self.state.time, &self.state.path);
        let state = match path {
            None => Arc::new(stepper.undeformed(time)),
            Some(path) => path.state_at(&mut **stepper, time)?,
        };
        stepper.fields(&state, path.is_some())
    }

    /// The parameters of its model.
    pub fn parameters(&self) -> &Parameters {
        self.model.parameters()
    }

    /// Derivatives of the force at the present time by the material's parameters, in the order of
    /// [`crate::law::MaterialParameter::index`]; empty before contact and unless
    /// [`crate::solver::parameters::SolverParameters::sensitivities`] asks for them. Those by the magnitudes of effects,
    /// [`crate::law::Magnitude::ALL`], follow where `effect_sensitivities` asks for them; the load cell drifts before contact, too.
    pub fn sensitivities(&self) -> Vec<ForceSensitivity> {
        let (state, Parameters { solver, material, .. }) = (&self.state, self.model.parameters());
        let path = state.path.as_ref();
        let mut all = path.map(|path| path.sensitivities(state.time)).unwrap_or_default();
        if solver.effect_sensitivities {
            all.resize(solver.differentiated(material.branches.len()), ForceSensitivity::default());
            let lag = path.map_or(0.0, |path| path.lag_derivative(state.time));
            let read = |force| ForceSensitivity { force, ..ForceSensitivity::default() };
            all.extend([read(state.time), read(lag)]);
        }
        all
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
        if snapshot.path.as_ref().is_some_and(|p| !p.fits(self.engine.discretisation())) {
            return Err(ParameterError::ForeignSnapshot);
        }
        self.state = snapshot.clone();
        Ok(())
    }
}
