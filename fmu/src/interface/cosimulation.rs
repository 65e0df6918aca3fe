//! The FMI co-simulation slave without any C: settings by value reference, initialise, step, save.

use crate::fields::FieldsError;
use crate::interface::hash::hash_128;
use crate::interface::model_description::guid_bytes;
use crate::interface::recording::{Recorder, RecorderState};
use crate::interface::variables::{
    Causality, ProtocolSource, Readings, Settings, SettingsError, Value, VariableError, by_name, by_reference,
};
use crate::motion::protocol::{Protocol, ProtocolError};
use crate::{Instance, Model, Outputs, ParameterError, Parameters, Snapshot, StepError};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Relative slack of communication times: masters sum up step sizes.
pub const TIME_SLACK: f64 = 1e-9;

/// Why a call failed. The slave is as it was before the call.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SlaveError {
    /// A value reference, type or value.
    #[error(transparent)]
    Variable(#[from] VariableError),
    /// A parameter set the model cannot be built from.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The built-in protocol.
    #[error("built-in protocol: {0}")]
    Protocol(#[from] ProtocolError),
    /// A step that could not be made.
    #[error(transparent)]
    Step(#[from] StepError),
    /// Fields that could not be computed or written.
    #[error(transparent)]
    Fields(#[from] FieldsError),
    /// A parameter set while running.
    #[error("{0} is fixed: set it before the end of the initialisation")]
    Fixed(String),
    /// An input that moves nothing.
    #[error(
        "{0} has no effect: the punch follows the built-in protocol; to give the inputs, set protocol.source or \
         protocol.source_number to 1 (inputs) before the end of the initialisation"
    )]
    IgnoredInput(String),
    /// Only an input has a derivative.
    #[error("{0} is not the input `displacement`: only its derivative can be set")]
    NotInterpolated(String),
    /// Only first derivatives are used.
    #[error("order {0} of an input derivative: only order 1 is supported")]
    DerivativeOrder(i32),
    /// A step before initialisation.
    #[error("the slave is not initialised")]
    NotInitialised,
    /// A communication point that the slave is not at.
    #[error("communication point {asked} s, but the slave is at {actual} s")]
    WrongTime {
        /// Asked for (s).
        asked: f64,
        /// Where the slave is (s).
        actual: f64,
    },
    /// Bytes that are not a saved state of this slave.
    #[error("not a saved state of this FMU: {0}")]
    BadState(&'static str),
    /// A saved state with settings that nobody could have set.
    #[error("not a saved state of this FMU: {0}")]
    BadSettings(#[from] SettingsError),
}

#[derive(Debug)]
struct Run {
    instance: Instance,
    start_time: f64,
    time: f64,
    protocol: Option<Protocol>,
    /// Writes the fields, where they are asked for.
    recorder: Option<Recorder>,
}

/// One co-simulation slave.
#[derive(Debug, Default)]
pub struct Slave {
    settings: Settings,
    derivative: Option<f64>,
    run: Option<Run>,
    /// The last model built, kept because masters reset and start again with the same parameters.
    model: Option<Model>,
}

/// A complete saved state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SlaveState {
    settings: Settings,
    derivative: Option<f64>,
    run: Option<RunState>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct RunState {
    start_time: f64,
    time: f64,
    snapshot: Snapshot,
    recorder: Option<RecorderState>,
}

impl Slave {
    /// A slave with the start values of the table.
    pub fn new() -> Self {
        Self::default()
    }

    /// Value of a variable; outputs are those of the last step.
    ///
    /// # Errors
    /// When there is no such variable.
    pub fn get(&self, reference: u32) -> Result<Value, SlaveError> {
        Ok(by_reference(reference)?.get(&self.settings, &self.readings()))
    }

    /// Values of many variables, with the outputs read once.
    ///
    /// # Errors
    /// When one of them does not exist or `pick` finds another type than it wants.
    pub fn get_each<T>(
        &self,
        references: &[u32],
        pick: impl Fn(Value) -> Option<T>,
        asked: Value,
    ) -> Result<Vec<T>, SlaveError> {
        let readings = self.readings();
        let one = |&reference: &u32| -> Result<T, SlaveError> {
            let variable = by_reference(reference)?;
            Ok(pick(variable.get(&self.settings, &readings)).ok_or_else(|| variable.wrong_type(&asked))?)
        };
        references.iter().map(one).collect()
    }

    /// Sets parameters and inputs: all, or none when one is refused.
    ///
    /// # Errors
    /// On an unknown variable, another type, a value out of range, or a parameter after initialisation.
    pub fn set(&mut self, values: &[(u32, Value)]) -> Result<(), SlaveError> {
        let mut settings = self.settings.clone();
        for (reference, value) in values {
            let variable = by_reference(*reference)?;
            variable.set(&mut settings, value.clone())?;
            if self.run.is_some() && variable.causality == Causality::Parameter {
                return Err(SlaveError::Fixed(variable.name.to_owned()));
            }
        }
        if self.follows_protocol() {
            refuse_other_inputs(&settings, &self.settings)?;
        }
        self.settings = settings;
        Ok(())
    }

    /// Sets the velocity of the punch for the next step (m/s); it takes the place of `displacement_rate`.
    ///
    /// # Errors
    /// Unless the variable is `displacement`, the order 1 and the value finite.
    pub fn set_input_derivative(&mut self, reference: u32, order: i32, value: f64) -> Result<(), SlaveError> {
        let variable = by_reference(reference)?;
        if by_name("displacement").is_none_or(|(displacement, _)| displacement != reference) {
            return Err(SlaveError::NotInterpolated(variable.name.to_owned()));
        }
        if order != 1 {
            return Err(SlaveError::DerivativeOrder(order));
        }
        if !value.is_finite() {
            return Err(VariableError::NotFinite { name: format!("der({})", variable.name), value }.into());
        }
        if self.follows_protocol() && value != 0.0 {
            return Err(SlaveError::IgnoredInput(format!("der({})", variable.name)));
        }
        self.derivative = Some(value);
        Ok(())
    }

    /// Whether the slave runs along the built-in protocol.
    fn follows_protocol(&self) -> bool {
        self.run.as_ref().is_some_and(|run| run.protocol.is_some())
    }

    /// Builds the model from the parameters and puts the punch at its first position.
    ///
    /// # Errors
    /// When the parameters are not admissible or the punch would start inside the sample.
    pub fn initialise(&mut self, start_time: f64) -> Result<(), SlaveError> {
        let settings = self.settings.chosen();
        let protocol = protocol(&settings)?;
        if protocol.is_some() {
            // Masters that set all start values set the inputs' too: 0 asks for nothing.
            refuse_other_inputs(&settings, &Settings::default())?;
            if self.derivative.is_some_and(|rate| rate != 0.0) {
                return Err(SlaveError::IgnoredInput("der(displacement)".to_owned()));
            }
        }
        settings.validate_branches()?;
        let model = self.model(settings.parameters())?;
        let mut instance = Instance::new(&model, self.start_displacement())?;
        let recorder = Recorder::begin(&settings.fields, &mut instance, start_time)?;
        self.model = Some(model);
        self.run = Some(Run { instance, start_time, time: start_time, protocol, recorder });
        Ok(())
    }

    /// The last model where it fits, otherwise a new one.
    fn model(&self, parameters: Parameters) -> Result<Model, ParameterError> {
        match &self.model {
            Some(model) if *model.parameters() == parameters => Ok(model.clone()),
            _ => Model::new(parameters),
        }
    }

    fn start_displacement(&self) -> f64 {
        match self.settings.chosen().source {
            ProtocolSource::Inputs => self.settings.displacement,
            ProtocolSource::Trapezoid => -self.settings.trapezoid.start_gap,
        }
    }

    /// Before initialisation the sample is undeformed: nothing but the punch's position is not zero.
    fn readings(&self) -> Readings {
        match &self.run {
            Some(Run { instance, .. }) => Readings {
                outputs: instance.outputs(),
                statistics: instance.statistics(),
                sensitivities: self.settings.spread(&instance.sensitivities()),
            },
            None => Readings {
                outputs: Outputs {
                    displacement: self.start_displacement(),
                    indentation: self.start_displacement() + self.settings.padded.effect.offset.height,
                    ..Outputs::default()
                },
                ..Readings::default()
            },
        }
    }

    /// Communication time (s), once initialised.
    pub fn time(&self) -> Option<f64> {
        self.run.as_ref().map(|run| run.time)
    }

    /// From the communication point `current` over a step of `size` (s).
    ///
    /// # Errors
    /// When the slave is elsewhere, the size is not positive, or the model cannot make the step; nothing
    /// has changed then.
    pub fn step(&mut self, current: f64, size: f64) -> Result<(), SlaveError> {
        let run = self.run.as_mut().ok_or(SlaveError::NotInitialised)?;
        if !(size > 0.0 && size.is_finite()) {
            return Err(StepError::BadDuration(size).into());
        }
        let slack = TIME_SLACK * run.time.abs().max(1.0);
        if current.is_nan() || (current - run.time).abs() > slack {
            return Err(SlaveError::WrongTime { asked: current, actual: run.time });
        }
        let from = current - run.start_time;
        let target = match &run.protocol {
            None => {
                let rate = self.derivative.unwrap_or(self.settings.displacement_rate);
                self.settings.displacement + rate * size
            }
            Some(protocol) => protocol.displacement(from + size),
        };
        match run.recorder.take() {
            None => run.go(from, size, target)?,
            Some(mut recorder) => {
                let made = run.go_recorded(&mut recorder, from, size, target);
                run.recorder = Some(recorder);
                made?;
            }
        }
        run.time = current + size;
        self.derivative = None;
        Ok(())
    }

    /// Ends the run: the last frame of the fields, where they are written.
    ///
    /// # Errors
    /// When that frame cannot be made.
    pub fn finish(&mut self) -> Result<(), SlaveError> {
        let Some(run) = &mut self.run else { return Ok(()) };
        let Some(recorder) = &mut run.recorder else { return Ok(()) };
        Ok(recorder.finish(&mut run.instance, run.time)?)
    }

    /// Back to the state after `new`.
    pub fn reset(&mut self) {
        *self = Self { model: self.model.take(), ..Self::default() };
    }

    /// The complete state.
    pub fn save(&self) -> SlaveState {
        let run = self.run.as_ref().map(|run| RunState {
            start_time: run.start_time,
            time: run.time,
            snapshot: run.instance.save(),
            recorder: run.recorder.as_ref().map(Recorder::save),
        });
        SlaveState { settings: self.settings.clone(), derivative: self.derivative, run }
    }

    /// Returns to a saved state, bit for bit.
    ///
    /// # Errors
    /// When the state does not fit its own parameters; nothing has changed then.
    pub fn restore(&mut self, state: &SlaveState) -> Result<(), SlaveError> {
        match &state.run {
            None => self.run = None,
            Some(saved) => self.restore_run(&state.settings, saved)?,
        }
        self.settings = state.settings.clone();
        self.derivative = state.derivative;
        Ok(())
    }

    fn restore_run(&mut self, settings: &Settings, saved: &RunState) -> Result<(), SlaveError> {
        let settings = &settings.chosen();
        settings.validate_branches()?;
        let (start_time, time, protocol) = (saved.start_time, saved.time, protocol(settings)?);
        let parameters = settings.parameters();
        let (path, recorded) = (&settings.fields.path, saved.recorder.as_ref());
        let same = self.model.as_ref().is_some_and(|model| *model.parameters() == parameters);
        if let Some(run) = self.run.as_mut().filter(|_| same) {
            let before = run.instance.save();
            run.instance.restore(&saved.snapshot)?;
            if let Err(error) = Recorder::restore(&mut run.recorder, path, recorded) {
                // Cannot fail: the state was saved by this very instance.
                let _ = run.instance.restore(&before);
                return Err(error.into());
            }
            (run.start_time, run.time, run.protocol) = (start_time, time, protocol);
            return Ok(());
        }
        let model = self.model(parameters)?;
        // The snapshot overwrites the punch's position: any admissible one will do, like the true surface.
        let surface = -settings.padded.effect.offset.height;
        let mut instance = Instance::new(&model, surface)?;
        instance.restore(&saved.snapshot)?;
        let mut recorder = self.run.as_mut().and_then(|run| run.recorder.take());
        Recorder::restore(&mut recorder, path, recorded)?;
        self.model = Some(model);
        self.run = Some(Run { instance, start_time, time, protocol, recorder });
        Ok(())
    }
}

impl Run {
    /// A step of `size` (s) from the protocol's time `from` (s): along the protocol, or straight to `target` (m).
    fn go(&mut self, from: f64, size: f64, target: f64) -> Result<(), StepError> {
        if let Some(protocol) = &self.protocol {
            return follow(&mut self.instance, protocol, from, from + size);
        }
        self.instance.set_displacement(target);
        self.instance.advance(size)
    }

    /// The same with the frames that are due at its ends; without them the step is not made.
    fn go_recorded(
        &mut self,
        recorder: &mut Recorder,
        from: f64,
        size: f64,
        target: f64,
    ) -> Result<(), SlaveError> {
        let velocity = (target - self.instance.outputs().displacement) / size;
        let pace = recorder.before_step(&mut self.instance, self.time, velocity)?;
        let state = self.instance.save();
        let moved = self.go(from, size, target).map_err(SlaveError::from);
        let end = self.start_time + from + size;
        moved.and_then(|()| Ok(recorder.after_step(&mut self.instance, end)?)).inspect_err(|_| {
            recorder.undo(&pace);
            // Cannot fail: the state was saved by this very instance.
            let _ = self.instance.restore(&state);
        })
    }
}

/// Refuses inputs that differ from those `before`, where the punch does not follow them.
fn refuse_other_inputs(settings: &Settings, before: &Settings) -> Result<(), SlaveError> {
    let refused = |name: &str| Err(SlaveError::IgnoredInput(name.to_owned()));
    if settings.displacement != before.displacement {
        return refused("displacement");
    }
    if settings.displacement_rate != before.displacement_rate {
        return refused("displacement_rate");
    }
    Ok(())
}

/// The built-in protocol, where it is switched on.
fn protocol(settings: &Settings) -> Result<Option<Protocol>, ProtocolError> {
    match settings.source {
        ProtocolSource::Inputs => Ok(None),
        ProtocolSource::Trapezoid => settings.trapezoid.protocol().map(Some),
    }
}

/// Follows the protocol, honouring the breakpoints inside the step.
fn follow(instance: &mut Instance, protocol: &Protocol, from: f64, to: f64) -> Result<(), StepError> {
    // A breakpoint this close to an end of the step belongs to it, however long the step is.
    let slack = TIME_SLACK * (to - from).min(1.0);
    let inside = protocol.breakpoints_between(from + slack, to - slack);
    let before = (!inside.is_empty()).then(|| instance.save());
    let mut time = from;
    for (end, displacement) in inside.iter().copied().chain([(to, protocol.displacement(to))]) {
        instance.set_displacement(displacement);
        if let Err(error) = instance.advance(end - time) {
            if let Some(before) = &before {
                // Cannot fail: the state was saved by this very instance.
                let _ = instance.restore(before);
            }
            return Err(error);
        }
        time = end;
    }
    Ok(())
}

const MAGIC: [u8; 8] = *b"POROFMU\0";
const VERSION: u32 = 3;
/// Magic, version, GUID, length of the payload.
const HEADER: usize = 8 + 4 + 16 + 8;
const CHECKSUM: usize = 16;

impl SlaveState {
    /// Header, payload, checksum; little-endian, valid in another process and on another machine.
    /// `attachment` is stored beside the state: the caller's own.
    ///
    /// # Errors
    /// When the state cannot be written.
    pub fn to_bytes(&self, attachment: &[u8]) -> Result<Vec<u8>, SlaveError> {
        let payload = postcard::to_allocvec(&(attachment, self))
            .map_err(|_| SlaveError::BadState("it cannot be serialised"))?;
        let mut bytes = Vec::with_capacity(HEADER + payload.len() + CHECKSUM);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(guid_bytes());
        bytes.extend((payload.len() as u64).to_le_bytes());
        bytes.extend(payload);
        bytes.extend(hash_128(&bytes));
        Ok(bytes)
    }

    /// Reads what [`SlaveState::to_bytes`] wrote: state and attachment.
    ///
    /// # Errors
    /// When anything about the bytes is wrong: they may come from anywhere.
    pub fn from_bytes(bytes: &[u8]) -> Result<(Self, Vec<u8>), SlaveError> {
        let bad = SlaveError::BadState;
        let body =
            bytes.len().checked_sub(CHECKSUM).filter(|&n| n >= HEADER).ok_or(bad("it is too short"))?;
        let (body, checksum) = bytes.split_at(body);
        if body[..8] != MAGIC {
            return Err(bad("it does not begin like one"));
        }
        if body[8..12] != VERSION.to_le_bytes() {
            return Err(bad("another version of the format"));
        }
        if body[12..28] != *guid_bytes() {
            return Err(bad("written by an FMU with another GUID"));
        }
        if body[28..HEADER] != ((body.len() - HEADER) as u64).to_le_bytes() {
            return Err(bad("its length is wrong"));
        }
        if *checksum != hash_128(body) {
            return Err(bad("its checksum is wrong"));
        }
        let (attachment, state): (_, Self) =
            postcard::from_bytes(&body[HEADER..]).map_err(|_| bad("its contents cannot be read"))?;
        state.validate()?;
        Ok((state, attachment))
    }

    /// Checks what a checksum does not: nothing may be restored that could not have been set or reached.
    fn validate(&self) -> Result<(), SlaveError> {
        self.settings.validate()?;
        let run = self.run.as_ref();
        let times = run.map_or([0.0; 2], |run| [run.start_time, run.time]);
        if !(times.iter().chain(&self.derivative).all(|number| number.is_finite())) {
            return Err(SlaveError::BadState("a time or derivative is no number"));
        }
        if run.is_some_and(|run| !run.snapshot.is_sound()) {
            return Err(SlaveError::BadState("its path could not have been reached"));
        }
        Ok(())
    }
}
