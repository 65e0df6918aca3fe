//! Messages to the master.

use crate::fmi2::abi::CallbackFunctions;
use crate::fmi3::abi::LogMessage;
use crate::guard::{ERROR, OK, Status};
use poropunch::model_description::{LOG_ERROR, LOG_EVENTS};
use std::ffi::{CString, c_void};

/// Where messages go.
enum Sink {
    /// The callbacks, copied, and the instance's name.
    Fmi2(CallbackFunctions, CString),
    /// The callback, where there is one, and what it gets back.
    Fmi3(Option<LogMessage>, *mut c_void),
}

/// The master's callback with what it wants to hear.
pub struct Logger {
    sink: Sink,
    events: bool,
}

impl Logger {
    /// Errors are always logged, events when `logging_on`.
    pub fn fmi2(callbacks: CallbackFunctions, instance: &str, logging_on: bool) -> Self {
        Self { sink: Sink::Fmi2(callbacks, c_string(instance)), events: logging_on }
    }

    /// The same for FMI 3.0.
    pub fn fmi3(log: Option<LogMessage>, environment: *mut c_void, logging_on: bool) -> Self {
        Self { sink: Sink::Fmi3(log, environment), events: logging_on }
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
        let category = c_string(category);
        match &self.sink {
            Sink::Fmi2(callbacks, instance) => {
                let Some(logger) = callbacks.logger else { return };
                let message = c_string(&escaped(message));
                let environment = callbacks.component_environment;
                // SAFETY: the master guarantees that the callback outlives the component; all strings live here.
                unsafe {
                    logger(environment, instance.as_ptr(), status, category.as_ptr(), message.as_ptr());
                }
            }
            Sink::Fmi3(log, environment) => {
                let Some(log) = log else { return };
                let message = c_string(message);
                // SAFETY: as above; FMI 3.0 takes the message as it is.
                unsafe { log(*environment, status, category.as_ptr(), message.as_ptr()) };
            }
        }
    }
}

/// For a master of FMI 2.0, which passes the message to C's printf, where a lone % would read arguments that are not there,
/// and takes a lone # for the beginning of a value reference (FMI 2.0.5, section 2.1.5).
fn escaped(message: &str) -> String {
    message.replace('%', "%%").replace('#', "##")
}

fn c_string(text: &str) -> CString {
    let bytes: Vec<u8> = text.bytes().filter(|&byte| byte != 0).collect();
    CString::new(bytes).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;
    use std::ffi::{CStr, c_char, c_void};
    use std::ptr::null_mut;

    /// As a master reads a message: `%%` and `##` are single characters, a lone one begins something else.
    fn read_by_master(message: &str) -> Option<String> {
        let (mut text, mut rest) = (String::new(), message.chars());
        while let Some(c) = rest.next() {
            if matches!(c, '%' | '#') && rest.next() != Some(c) {
                return None;
            }
            text.push(c);
        }
        Some(text)
    }

    thread_local! {
        static HEARD: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
    }

    unsafe extern "C" fn hear(
        _: *mut c_void,
        _: *const c_char,
        _: Status,
        _: *const c_char,
        message: *const c_char,
    ) {
        // SAFETY: `send` passes a string that ends with a zero.
        let message = unsafe { CStr::from_ptr(message) }.to_str().unwrap().to_owned();
        HEARD.with_borrow_mut(|heard| heard.push(message));
    }

    #[test]
    fn masters_read_what_was_said() {
        let said = "fields.path a#b%20/#r12#.pvd: 100 %";
        Logger::fmi2(CallbackFunctions::hearing(hear, null_mut()), "test", false).error(said);
        let heard = HEARD.with_borrow_mut(Vec::pop).unwrap();
        assert_eq!(read_by_master(&heard).as_deref(), Some(said), "{heard}");
    }
}
