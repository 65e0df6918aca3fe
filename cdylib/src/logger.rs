//! Messages to the master.

use crate::abi::{CallbackFunctions, ERROR, OK, Status};
use poropunch::model_description::{LOG_ERROR, LOG_EVENTS};
use std::ffi::CString;

/// The master's callback, copied, with what it wants to hear.
pub struct Logger {
    callbacks: CallbackFunctions,
    instance: CString,
    events: bool,
}

impl Logger {
    /// Errors are always logged, events when `logging_on`.
    pub fn new(callbacks: CallbackFunctions, instance: &str, logging_on: bool) -> Self {
        Self { callbacks, instance: c_string(instance), events: logging_on }
    }

    /// Switches categories; no category means all. Errors stay on: a failure without a reason helps nobody.
    pub fn select(&mut self, on: bool, categories: &[&str]) -> Result<(), String> {
        let known = [LOG_EVENTS.0, LOG_ERROR.0];
        if let Some(unknown) = categories.iter().find(|c| !known.contains(c)) {
            return Err(format!("there is no log category `{unknown}`; categories are {}", known.join(", ")));
        }
        if categories.is_empty() || categories.contains(&LOG_EVENTS.0) {
            self.events = on;
        }
        Ok(())
    }

    /// Why a call failed.
    pub fn error(&self, message: &str) {
        self.send(ERROR, LOG_ERROR.0, message);
    }

    /// What happened; the message is only formed when somebody listens.
    pub fn event(&self, message: impl FnOnce() -> String) {
        if self.events {
            self.send(OK, LOG_EVENTS.0, &message());
        }
    }

    fn send(&self, status: Status, category: &str, message: &str) {
        let Some(logger) = self.callbacks.logger else { return };
        // The master passes the message to C's printf: a lone % would read arguments that are not there.
        let message = c_string(&message.replace('%', "%%"));
        let category = c_string(category);
        let environment = self.callbacks.component_environment;
        // SAFETY: the master guarantees that the callback outlives the component; all strings live here.
        unsafe { logger(environment, self.instance.as_ptr(), status, category.as_ptr(), message.as_ptr()) };
    }
}

fn c_string(text: &str) -> CString {
    let bytes: Vec<u8> = text.bytes().filter(|&byte| byte != 0).collect();
    CString::new(bytes).unwrap_or_default()
}
