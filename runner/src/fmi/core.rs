//! What an instance consists of, alike in FMI 2.0 and 3.0.
#![allow(unsafe_code)]

use super::archive::Files;
use super::states::StateFunctions;
use super::{FmiError, ModelDescription};
use std::any::Any;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::null;
use std::sync::{Arc, Mutex, PoisonError};

/// `fmi2Component`, `fmi3Instance`.
pub type Component = *mut c_void;
/// A function that takes nothing but the component.
pub type Plain = unsafe extern "C" fn(Component) -> c_int;

/// Messages of an instance; the FMU's logger callback writes here.
#[derive(Default)]
pub struct Messages(Mutex<Vec<String>>);

impl Messages {
    /// One more.
    pub fn push(&self, message: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    }

    /// All of them; none is left.
    pub fn take(&self) -> Vec<String> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Why the last call failed.
    pub fn reason(&self) -> String {
        let messages = self.take();
        if messages.is_empty() { "the FMU gave no reason".to_owned() } else { messages.join("; ") }
    }

    /// Turns a status into a result: warnings pass, anything worse carries the logged messages.
    pub fn check(&self, function: &'static str, status: c_int) -> Result<(), FmiError> {
        let status = match status {
            0 | 1 => return Ok(()),
            2 => "discarded".to_owned(),
            3 => "error".to_owned(),
            4 => "fatal error".to_owned(),
            other => format!("status {other}"),
        };
        Err(FmiError::Call { function, status, messages: self.reason() })
    }
}

/// A C string.
pub fn c_text(text: &str) -> Result<CString, FmiError> {
    CString::new(text).map_err(|_| FmiError::Refused(format!("`{text}` contains a zero byte")))
}

/// What an instance is made of, alive until the instantiation returns.
pub struct Call<'a> {
    /// The instance's name.
    pub name: &'a CStr,
    /// GUID or token of the description.
    pub guid: &'a CStr,
    /// Where its resources are, or NULL.
    pub resources: *const c_char,
    /// Its [`Messages`], which live as long as the instance.
    pub environment: *mut c_void,
}

/// One instance's component with what lives as long as it; freed with it.
pub struct Core {
    /// The component, alive.
    pub component: Component,
    /// What it logged.
    pub messages: Box<Messages>,
    /// Its FMU's description.
    pub description: Arc<ModelDescription>,
    pub(super) states: StateFunctions,
    free: unsafe extern "C" fn(Component),
    // The library of all functions, and the files it was loaded from.
    _library: Arc<dyn Any + Send + Sync>,
    _files: Option<Arc<Files>>,
}

// SAFETY: FMI allows an instance to be called from any thread, one at a time; its owner's `&mut self` sees to that.
unsafe impl Send for Core {}

impl Core {
    /// A component of a library, made by `instantiate` and freed by `free`; `resources` tells where the files are in the
    /// words of the version.
    ///
    /// # Safety
    /// `states`, `free` and `instantiate` are of `library`.
    pub unsafe fn new(
        library: Arc<dyn Any + Send + Sync>,
        (states, free): (StateFunctions, unsafe extern "C" fn(Component)),
        description: &Arc<ModelDescription>,
        (files, resources): (Option<&Arc<Files>>, Option<String>),
        name: &str,
        instantiate: impl FnOnce(Call<'_>) -> Component,
    ) -> Result<Self, FmiError> {
        let messages = Box::<Messages>::default();
        let environment = (&raw const *messages).cast_mut().cast();
        let (name, guid) = (c_text(name)?, c_text(&description.guid)?);
        let resources = resources.map(|place| c_text(&place)).transpose()?;
        let resources = resources.as_ref().map_or(null(), |place| place.as_ptr());
        let component = instantiate(Call { name: &name, guid: &guid, resources, environment });
        if component.is_null() {
            return Err(FmiError::Refused(messages.reason()));
        }
        let (description, files) = (description.clone(), files.cloned());
        Ok(Self { component, messages, description, states, free, _library: library, _files: files })
    }

    /// Calls a function of this library.
    pub fn call(&self, name: &'static str, function: Plain) -> Result<(), FmiError> {
        // SAFETY: a live component; instances hand over functions of its own library.
        let status = unsafe { function(self.component) };
        self.messages.check(name, status)
    }
}

impl Drop for Core {
    fn drop(&mut self) {
        // SAFETY: a live component of this library, not used afterwards.
        unsafe { (self.free)(self.component) };
    }
}

/// The messages behind an environment and the text of a message, where there is something to keep: events, whose status
/// is 0, are no failures.
///
/// # Safety
/// `environment` is NULL or the [`Messages`] of a living instance, `message` NULL or a C string.
pub unsafe fn heard<'a>(
    environment: *mut c_void,
    status: c_int,
    message: *const c_char,
) -> Option<(&'a Messages, String)> {
    if environment.is_null() || message.is_null() || status == 0 {
        return None;
    }
    // SAFETY: not NULL, and the caller's promise.
    let (messages, text) = unsafe { (&*environment.cast::<Messages>(), CStr::from_ptr(message)) };
    Some((messages, text.to_string_lossy().into_owned()))
}
