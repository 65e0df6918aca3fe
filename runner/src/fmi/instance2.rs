//! One instance of an FMI 2.0 FMU.
#![allow(unsafe_code)]

use super::archive::Files;
use super::binary2::{Binary2, Callbacks, Component, calloc, free};
use super::instance::{Face, FmuState, Messages, c_text};
use super::states::states;
use super::{FmiError, ModelDescription};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::sync::Arc;

unsafe extern "C" fn log(
    environment: *mut c_void,
    _instance: *const c_char,
    status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    // 0 is fmi2OK: events, not failures.
    if environment.is_null() || message.is_null() || status == 0 {
        return;
    }
    // SAFETY: the environment is the `Messages` of the instance that called, alive until it is freed.
    let messages = unsafe { &*environment.cast::<Messages>() };
    // SAFETY: the standard promises a C string.
    let text = unsafe { CStr::from_ptr(message) }.to_string_lossy().replace("%%", "%").replace("##", "#");
    messages.push(text);
}

/// One instance. Send: it may move between threads, but is used by one at a time.
pub struct Instance2 {
    component: Component,
    messages: Box<Messages>,
    // The struct must stay where it is: some FMUs keep the pointer instead of a copy.
    _callbacks: Box<Callbacks>,
    binary: Arc<Binary2>,
    description: Arc<ModelDescription>,
    _files: Option<Arc<Files>>,
}

// SAFETY: FMI allows an instance to be called from any thread, one at a time; `&mut self` sees to that.
unsafe impl Send for Instance2 {}

impl Instance2 {
    pub fn new(
        binary: &Arc<Binary2>,
        description: &Arc<ModelDescription>,
        files: Option<&Arc<Files>>,
        name: &str,
    ) -> Result<Self, FmiError> {
        let messages = Box::<Messages>::default();
        let environment = (&raw const *messages).cast_mut().cast();
        let callbacks = Box::new(Callbacks {
            logger: log,
            allocate: calloc,
            free,
            step_finished: std::ptr::null(),
            environment,
        });
        let description = description.clone();
        let (name, guid) = (c_text(name)?, c_text(&description.guid)?);
        let resources = files.map(|files| c_text(&files.resource_uri())).transpose()?;
        let resources = resources.as_ref().map_or(std::ptr::null(), |uri| uri.as_ptr());
        let binary = binary.clone();
        // SAFETY: all strings live until the call returns; callbacks and messages as long as the component.
        let component = unsafe {
            (binary.instantiate)(name.as_ptr(), 1, guid.as_ptr(), resources, &raw const *callbacks, 0, 0)
        };
        if component.is_null() {
            return Err(FmiError::Refused(messages.reason()));
        }
        let files = files.cloned();
        Ok(Self { component, messages, _callbacks: callbacks, binary, description, _files: files })
    }
}

/// Defines a get and a set function of one type.
macro_rules! access {
    ($get:ident, $set:ident, $rust:ty, $c:ty, $get_name:literal, $set_name:literal, $from:expr, $to:expr) => {
        fn $get(&mut self, references: &[u32]) -> Result<Vec<$rust>, FmiError> {
            let mut values = vec![<$c>::default(); references.len()];
            // SAFETY: a live component of this library; the arrays have the stated length.
            let status = unsafe {
                (self.binary.$get)(self.component, references.as_ptr(), references.len(), values.as_mut_ptr())
            };
            self.messages.check($get_name, status)?;
            Ok(values.into_iter().map($from).collect())
        }

        fn $set(&mut self, references: &[u32], values: &[$rust]) -> Result<(), FmiError> {
            assert_eq!(references.len(), values.len(), "slices differ in length");
            let values: Vec<$c> = values.iter().copied().map($to).collect();
            // SAFETY: a live component of this library; the arrays have the stated length.
            let status = unsafe {
                (self.binary.$set)(self.component, references.as_ptr(), references.len(), values.as_ptr())
            };
            self.messages.check($set_name, status)
        }
    };
}

impl Face for Instance2 {
    fn messages(&self) -> &Messages {
        &self.messages
    }

    fn setup_experiment(&mut self, start_time: f64, stop_time: Option<f64>) -> Result<(), FmiError> {
        let (defined, stop) = (c_int::from(stop_time.is_some()), stop_time.unwrap_or(0.0));
        // SAFETY: a live component of this library; so for all calls below.
        let status =
            unsafe { (self.binary.setup_experiment)(self.component, 0, 0.0, start_time, defined, stop) };
        self.messages.check("fmi2SetupExperiment", status)
    }

    fn enter_initialization_mode(&mut self) -> Result<(), FmiError> {
        // SAFETY: a live component of this library.
        let status = unsafe { (self.binary.enter_initialization)(self.component) };
        self.messages.check("fmi2EnterInitializationMode", status)
    }

    fn exit_initialization_mode(&mut self) -> Result<(), FmiError> {
        // SAFETY: a live component of this library.
        let status = unsafe { (self.binary.exit_initialization)(self.component) };
        self.messages.check("fmi2ExitInitializationMode", status)
    }

    fn do_step(&mut self, current_time: f64, step_size: f64) -> Result<(), FmiError> {
        // SAFETY: a live component of this library.
        let status = unsafe { (self.binary.do_step)(self.component, current_time, step_size, 1) };
        self.messages.check("fmi2DoStep", status)
    }

    fn terminate(&mut self) -> Result<(), FmiError> {
        // SAFETY: a live component of this library.
        let status = unsafe { (self.binary.terminate)(self.component) };
        self.messages.check("fmi2Terminate", status)
    }

    fn reset(&mut self) -> Result<(), FmiError> {
        self.messages.take();
        // SAFETY: a live component of this library.
        let status = unsafe { (self.binary.reset)(self.component) };
        self.messages.check("fmi2Reset", status)
    }

    fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), FmiError> {
        assert!(references.len() == orders.len() && orders.len() == values.len(), "slices differ in length");
        let set =
            self.binary.set_input_derivatives.filter(|_| self.description.capabilities.interpolate_inputs);
        let set = set.ok_or(FmiError::NotSupported("take derivatives of inputs"))?;
        // SAFETY: a live component of this library; the arrays have the stated length.
        let status = unsafe {
            set(self.component, references.as_ptr(), references.len(), orders.as_ptr(), values.as_ptr())
        };
        self.messages.check("fmi2SetRealInputDerivatives", status)
    }

    states!(
        "fmi2GetFMUstate",
        "fmi2SetFMUstate",
        "fmi2FreeFMUstate",
        "fmi2SerializedFMUstateSize",
        "fmi2SerializeFMUstate",
        "fmi2DeSerializeFMUstate"
    );

    access!(get_real, set_real, f64, f64, "fmi2GetReal", "fmi2SetReal", |v| v, |v| v);
    access!(get_integer, set_integer, i32, c_int, "fmi2GetInteger", "fmi2SetInteger", |v| v, |v| v);
    access!(
        get_boolean,
        set_boolean,
        bool,
        c_int,
        "fmi2GetBoolean",
        "fmi2SetBoolean",
        |v| v != 0,
        c_int::from
    );

    fn get_string(&mut self, references: &[u32]) -> Result<Vec<String>, FmiError> {
        let get = self.binary.get_string.ok_or(FmiError::NotSupported("give texts"))?;
        let mut values = vec![std::ptr::null(); references.len()];
        // SAFETY: a live component of this library; the arrays have the stated length.
        let status =
            unsafe { get(self.component, references.as_ptr(), references.len(), values.as_mut_ptr()) };
        self.messages.check("fmi2GetString", status)?;
        let copy = |value: *const c_char| {
            if value.is_null() {
                return String::new();
            }
            // SAFETY: not NULL, and a C string of the FMU's that lives until its next call.
            unsafe { CStr::from_ptr(value) }.to_string_lossy().into_owned()
        };
        Ok(values.into_iter().map(copy).collect())
    }

    fn set_string(&mut self, references: &[u32], values: &[&str]) -> Result<(), FmiError> {
        assert_eq!(references.len(), values.len(), "slices differ in length");
        let set = self.binary.set_string.ok_or(FmiError::NotSupported("take texts"))?;
        let texts: Vec<CString> = values.iter().map(|value| c_text(value)).collect::<Result<_, _>>()?;
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        // SAFETY: a live component of this library; the arrays have the stated length and outlive the call.
        let status = unsafe { set(self.component, references.as_ptr(), references.len(), pointers.as_ptr()) };
        self.messages.check("fmi2SetString", status)
    }
}

impl Drop for Instance2 {
    fn drop(&mut self) {
        // SAFETY: a live component of this library, not used afterwards.
        unsafe { (self.binary.free_instance)(self.component) };
    }
}
