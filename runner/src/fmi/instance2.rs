//! One instance of an FMI 2.0 FMU.
#![allow(unsafe_code)]

use super::archive::Files;
use super::binary2::{Binary2, Callbacks, calloc, free};
use super::core::{Call, Core, c_text, heard};
use super::instance::Face;
use super::{FmiError, ModelDescription};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use std::sync::Arc;

unsafe extern "C" fn log(
    environment: *mut c_void,
    _instance: *const c_char,
    status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the `Messages` of the instance that called, alive until it is freed; the message is a C string.
    if let Some((messages, text)) = unsafe { heard(environment, status, message) } {
        messages.push(text.replace("%%", "%").replace("##", "#"));
    }
}

/// One instance. Send: it may move between threads, but is used by one at a time.
pub struct Instance2 {
    core: Core,
    // The struct must stay where it is: some FMUs keep the pointer instead of a copy.
    _callbacks: Box<Callbacks>,
    binary: Arc<Binary2>,
}

// SAFETY: as a `Core`; the callbacks are only handed to the FMU.
unsafe impl Send for Instance2 {}

impl Instance2 {
    pub fn new(
        binary: &Arc<Binary2>,
        description: &Arc<ModelDescription>,
        files: Option<&Arc<Files>>,
        name: &str,
    ) -> Result<Self, FmiError> {
        let mut callbacks = Box::new(Callbacks {
            logger: log,
            allocate: calloc,
            free,
            step_finished: null(),
            environment: null_mut(),
        });
        let instantiate = |Call { name, guid, resources, environment }: Call<'_>| {
            callbacks.environment = environment;
            let callbacks = &raw const *callbacks;
            // SAFETY: all strings live until the call returns; callbacks and messages as long as the component.
            unsafe { (binary.instantiate)(name.as_ptr(), 1, guid.as_ptr(), resources, callbacks, 0, 0) }
        };
        let resources = files.map(|files| files.resource_uri());
        let own = (binary.states, binary.free_instance);
        // SAFETY: all functions are of this library.
        let core =
            unsafe { Core::new(binary.clone(), own, description, (files, resources), name, instantiate)? };
        Ok(Self { core, _callbacks: callbacks, binary: binary.clone() })
    }
}

/// Defines a get and a set function of one type.
macro_rules! access {
    ($get:ident, $set:ident, $rust:ty, $c:ty, $get_name:literal, $set_name:literal, $from:expr, $to:expr) => {
        fn $get(&mut self, references: &[u32]) -> Result<Vec<$rust>, FmiError> {
            let (component, n) = (self.core.component, references.len());
            let mut values = vec![<$c>::default(); n];
            // SAFETY: a live component of this library; the arrays have the stated length.
            let status =
                unsafe { (self.binary.$get)(component, references.as_ptr(), n, values.as_mut_ptr()) };
            self.core.messages.check($get_name, status)?;
            Ok(values.into_iter().map($from).collect())
        }

        fn $set(&mut self, references: &[u32], values: &[$rust]) -> Result<(), FmiError> {
            let (component, n) = (self.core.component, references.len());
            assert_eq!(n, values.len(), "slices differ in length");
            let values: Vec<$c> = values.iter().copied().map($to).collect();
            // SAFETY: a live component of this library; the arrays have the stated length.
            let status = unsafe { (self.binary.$set)(component, references.as_ptr(), n, values.as_ptr()) };
            self.core.messages.check($set_name, status)
        }
    };
}

impl Face for Instance2 {
    fn core(&self) -> &Core {
        &self.core
    }

    fn setup_experiment(&mut self, start_time: f64, stop_time: Option<f64>) -> Result<(), FmiError> {
        let (defined, stop) = (c_int::from(stop_time.is_some()), stop_time.unwrap_or(0.0));
        // SAFETY: a live component of this library; so for all calls below.
        let status =
            unsafe { (self.binary.setup_experiment)(self.core.component, 0, 0.0, start_time, defined, stop) };
        self.core.messages.check("fmi2SetupExperiment", status)
    }

    fn enter_initialization_mode(&mut self) -> Result<(), FmiError> {
        self.core.call("fmi2EnterInitializationMode", self.binary.enter_initialization)
    }

    fn exit_initialization_mode(&mut self) -> Result<(), FmiError> {
        self.core.call("fmi2ExitInitializationMode", self.binary.exit_initialization)
    }

    fn do_step(&mut self, current_time: f64, step_size: f64) -> Result<(), FmiError> {
        // SAFETY: a live component of this library.
        let status = unsafe { (self.binary.do_step)(self.core.component, current_time, step_size, 1) };
        self.core.messages.check("fmi2DoStep", status)
    }

    fn terminate(&mut self) -> Result<(), FmiError> {
        self.core.call("fmi2Terminate", self.binary.terminate)
    }

    fn reset(&mut self) -> Result<(), FmiError> {
        self.core.messages.take();
        self.core.call("fmi2Reset", self.binary.reset)
    }

    fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), FmiError> {
        assert!(references.len() == orders.len() && orders.len() == values.len(), "slices differ in length");
        let set = self
            .binary
            .set_input_derivatives
            .filter(|_| self.core.description.capabilities.interpolate_inputs);
        let set = set.ok_or(FmiError::NotSupported("take derivatives of inputs"))?;
        // SAFETY: a live component of this library; the arrays have the stated length.
        let status = unsafe {
            set(self.core.component, references.as_ptr(), references.len(), orders.as_ptr(), values.as_ptr())
        };
        self.core.messages.check("fmi2SetRealInputDerivatives", status)
    }

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
            unsafe { get(self.core.component, references.as_ptr(), references.len(), values.as_mut_ptr()) };
        self.core.messages.check("fmi2GetString", status)?;
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
        let status =
            unsafe { set(self.core.component, references.as_ptr(), references.len(), pointers.as_ptr()) };
        self.core.messages.check("fmi2SetString", status)
    }
}
