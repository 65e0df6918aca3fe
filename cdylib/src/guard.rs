//! What every entry point goes through: pointer, life cycle, panics, the reason of a failure.

use crate::component::Component;
use crate::phase::{Allowed, Phase};
use std::ffi::{CStr, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

/// `fmi2Status`, `fmi3Status`: their numbers are the same.
pub type Status = c_int;
/// Done.
pub const OK: Status = 0;
/// Not done; the reason is logged.
pub const ERROR: Status = 3;

/// Success, or the reason to log.
pub type Outcome = Result<(), String>;

/// Runs `body` on a component, when `function` is allowed in its phase.
///
/// # Safety
/// `component` is NULL or comes from an instantiation, is not freed, and is used by one thread at a time.
pub unsafe fn call(
    component: *mut c_void,
    function: &str,
    allowed: Allowed,
    body: impl FnOnce(&mut Component) -> Outcome,
) -> Status {
    // SAFETY: the caller's promise.
    let Some(component) = (unsafe { component.cast::<Component>().as_mut() }) else { return ERROR };
    run(component, function, allowed, body)
}

fn run(
    component: &mut Component,
    function: &str,
    allowed: Allowed,
    body: impl FnOnce(&mut Component) -> Outcome,
) -> Status {
    if !allowed.contains(&component.phase) {
        let phase = component.phase;
        component.logger.error(&format!(
            "{function}: not allowed in state {phase:?}, only in {allowed:?}; Reset leads out of any state"
        ));
        return ERROR;
    }
    match catch_unwind(AssertUnwindSafe(|| body(component))) {
        Ok(Ok(())) => OK,
        Ok(Err(reason)) => {
            component.logger.error(&format!("{function}: {reason}"));
            ERROR
        }
        Err(panic) => {
            component.phase = Phase::Error;
            component.logger.error(&format!("{function}: internal error: {}", panic_text(&*panic)));
            ERROR
        }
    }
}

/// Defines C functions that run their body on an instance, in the phases where they are allowed; that argument, the first, is not
/// written.
macro_rules! entry_points {
    ($($(#[$doc:meta])+ fn $name:ident($($argument:ident: $type:ty),* $(,)?) in $allowed:expr, $body:expr;)+) => {
        $($(#[$doc])+
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: *mut c_void, $($argument: $type),*) -> $crate::guard::Status {
            // SAFETY: see the top of the file that names the function.
            unsafe { $crate::guard::call(instance, stringify!($name), $allowed, $body) }
        })+
    };
}
pub(crate) use entry_points;

/// Why an instance is refused: a name that is none, or a description of another binary.
pub fn refusal(name: Option<&str>, asked: Option<&str>, own: &str) -> Option<String> {
    if name.is_none_or(|name| name.trim().is_empty()) {
        return Some("the instance name is missing or not UTF-8".to_owned());
    }
    let asked = asked.unwrap_or("none");
    (asked != own).then(|| {
        format!("GUID {asked} of modelDescription.xml is not {own} of the binary: take both from one archive")
    })
}

/// Frees an instance and all states it still holds; NULL is ignored, and one that is just calling its master.
///
/// # Safety
/// `component` is NULL or comes from an instantiation and is not used afterwards.
pub unsafe fn free(component: *mut c_void) {
    let component = component.cast::<Component>();
    // SAFETY: the caller's promise.
    if unsafe { component.as_ref() }.is_none_or(|c| c.phase == Phase::IntermediateUpdate) {
        return;
    }
    // SAFETY: the pointer was made by `Box::into_raw` at the instantiation.
    let component = unsafe { Box::from_raw(component) };
    let _ = catch_unwind(AssertUnwindSafe(|| drop(component)));
}

/// Keeps panics off the host's stderr. The hook belongs to this library's copy of the Rust runtime.
pub fn quiet_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| std::panic::set_hook(Box::new(|_| {})));
}

/// What a panic said.
pub fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "unknown".to_owned())
}

/// Most values of one call: each variable many times over. A greater count is not one, and must not be trusted with
/// memory.
const MOST_VALUES: usize = 1 << 16;

/// A C array as a slice; `n = 0` needs no array.
///
/// # Safety
/// `array` is NULL or holds `n` values for as long as the slice lives.
pub unsafe fn slice<'a, T>(array: *const T, n: usize) -> Result<&'a [T], String> {
    if n > MOST_VALUES {
        return Err(format!("{n} values in one call: at most {MOST_VALUES} are taken"));
    }
    // SAFETY: the caller's promise.
    unsafe { any_slice(array, n) }
}

/// Bytes that a master kept for this library: as many as there are.
///
/// # Safety
/// As [`slice`].
pub unsafe fn bytes<'a>(array: *const u8, n: usize) -> Result<&'a [u8], String> {
    if isize::try_from(n).is_err() {
        return Err(format!("{n} bytes do not fit into memory"));
    }
    // SAFETY: the caller's promise.
    unsafe { any_slice(array, n) }
}

unsafe fn any_slice<'a, T>(array: *const T, n: usize) -> Result<&'a [T], String> {
    match n {
        0 => Ok(&[]),
        _ if array.is_null() => Err(format!("an array of {n} values is NULL")),
        // SAFETY: not NULL, not larger than memory, and the caller's promise.
        _ => Ok(unsafe { std::slice::from_raw_parts(array, n) }),
    }
}

/// Writes `values` to a C array, which need not be initialised: it is never read.
///
/// # Safety
/// `array` is NULL or has room for as many values as there are, and nothing else refers to them.
pub unsafe fn write_each<T: Copy>(array: *mut T, values: &[T]) -> Outcome {
    if values.is_empty() {
        return Ok(());
    }
    if array.is_null() {
        return Err(format!("an array of {} values is NULL", values.len()));
    }
    // SAFETY: not NULL, and the caller's promise.
    unsafe { array.copy_from_nonoverlapping(values.as_ptr(), values.len()) };
    Ok(())
}

/// Writes one result to where the master wants it; what was there is not read.
///
/// # Safety
/// `place` is NULL or may be written.
pub unsafe fn write<T: Copy>(place: *mut T, value: T) -> Outcome {
    if place.is_null() {
        return Err("the pointer to the result is NULL".to_owned());
    }
    // SAFETY: not NULL, and the caller's promise.
    unsafe { place.write(value) };
    Ok(())
}

/// A C string; `None` when NULL or not UTF-8.
///
/// # Safety
/// `text` is NULL or ends with a zero and lives as long as the result.
pub unsafe fn text<'a>(text: *const c_char) -> Option<&'a str> {
    if text.is_null() {
        return None;
    }
    // SAFETY: not NULL, and the caller's promise.
    unsafe { CStr::from_ptr(text) }.to_str().ok()
}

/// C strings; errors call one of them a `what`.
///
/// # Safety
/// As [`slice`] and [`text`].
pub unsafe fn texts<'a>(array: *const *const c_char, n: usize, what: &str) -> Result<Vec<&'a str>, String> {
    // SAFETY: the caller's promise.
    let read = unsafe { slice(array, n)?.iter().map(|&one| text(one)).collect::<Option<_>>() };
    read.ok_or_else(|| format!("a {what} is NULL or not UTF-8"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi2::abi::CallbackFunctions;
    use crate::logger::Logger;
    use crate::phase::ANY;

    fn component() -> Component {
        Component::new(Logger::fmi2(CallbackFunctions::SILENT, "test", false))
    }

    #[test]
    fn a_panic_is_an_error_of_this_instance_only() {
        quiet_panics();
        let (mut broken, mut other) = (component(), component());
        assert_eq!(run(&mut broken, "test", ANY, |_| panic!("injected")), ERROR);
        assert_eq!(broken.phase, Phase::Error);
        assert_eq!(run(&mut other, "test", ANY, |c| c.slave.initialise(0.0).map_err(|e| e.to_string())), OK);
        broken.reset();
        assert_eq!(run(&mut broken, "test", ANY, |c| c.slave.initialise(0.0).map_err(|e| e.to_string())), OK);
    }
}
