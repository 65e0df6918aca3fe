//! The FMI co-simulation slave without any C: settings by value reference, initialise, step, save.

mod state;
mod step;

pub use state::SlaveState;
pub use step::{Leg, Progress};

use crate::fields::FieldsError;
use crate::interface::recording::Recorder;
use crate::interface::variables::ports::{BaseType, Port};
use crate::interface::variables::{
    Causality, ProtocolSource, Readings, Settings, SettingsError, Value, VariableError, by_name, by_reference,
};
use crate::motion::protocol::{Protocol, ProtocolError};
use crate::{Instance, Model, Outputs, ParameterError, Parameters, StepError};
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
    /// Two motions at once.
    #[error("protocol.source is inputs, but protocol.history has {0} points: the punch cannot follow both")]
    TwoMotions(usize),
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
        self.accept(settings)
    }

    /// Sets variables of FMI 3.0, arrays among them, to `values` one after the other: all, or none when one is refused.
    ///
    /// # Errors
    /// As [`Slave::set`], on another type than `asked`, and when there are more or fewer values than elements.
    pub fn set_ports(
        &mut self,
        asked: BaseType,
        references: &[u32],
        values: Vec<Value>,
    ) -> Result<(), SlaveError> {
        let mut settings = self.settings.clone();
        let given = values.len();
        let mut values = values.into_iter();
        for &reference in references {
            let port = port_of_type(reference, asked)?;
            port.write(&mut settings, &mut values)?;
            if self.run.is_some() && port.causality() == Causality::Parameter {
                return Err(SlaveError::Fixed(port.name()));
            }
        }
        if values.len() > 0 {
            let elements = given - values.len();
            return Err(VariableError::Count { given, elements }.into());
        }
        self.accept(settings)
    }

    /// Values of variables of FMI 3.0, those of arrays one after the other.
    ///
    /// # Errors
    /// When one of them does not exist or has another type than `asked`.
    pub fn get_ports(&self, asked: BaseType, references: &[u32]) -> Result<Vec<Value>, SlaveError> {
        let (readings, time) = (self.readings(), self.time().unwrap_or_default());
        let mut values = Vec::with_capacity(references.len());
        for &reference in references {
            port_of_type(reference, asked)?.read(&self.settings, &readings, time, &mut values);
        }
        Ok(values)
    }

    /// Takes new settings, unless they change inputs that move nothing.
    fn accept(&mut self, settings: Settings) -> Result<(), SlaveError> {
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
        if let Some(start) = self.settings.history.start() {
            return start;
        }
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

/// The variable of FMI 3.0 with a value reference, when it has the type that is `asked` for.
fn port_of_type(reference: u32, asked: BaseType) -> Result<Port, VariableError> {
    let port = Port::by_reference(reference)?;
    if port.base_type() == asked {
        return Ok(port);
    }
    Err(VariableError::WrongType { name: port.name(), asked: asked.name() })
}

/// The motion that is not given by the inputs: the user's history where there is one, else the built-in protocol where
/// it is switched on.
fn protocol(settings: &Settings) -> Result<Option<Protocol>, SlaveError> {
    match (settings.source, settings.history.protocol()?) {
        (ProtocolSource::Trapezoid, None) => Ok(Some(settings.trapezoid.protocol()?)),
        (ProtocolSource::Inputs, Some(_)) => Err(SlaveError::TwoMotions(settings.history.points())),
        (_, history) => Ok(history),
    }
}
