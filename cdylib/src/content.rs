//! What a value holds, as C takes it; `None` where it is of another type.

use poropunch::variables::Value;
use std::ffi::CString;

pub fn real(value: Value) -> Option<f64> {
    if let Value::Real(v) = value { Some(v) } else { None }
}

pub fn integer<T: From<i32>>(value: Value) -> Option<T> {
    if let Value::Integer(v) = value { Some(T::from(v)) } else { None }
}

pub fn boolean<T: From<bool>>(value: Value) -> Option<T> {
    if let Value::Boolean(v) = value { Some(T::from(v)) } else { None }
}

pub fn count(value: Value) -> Option<u64> {
    if let Value::Count(v) = value { Some(v) } else { None }
}

pub fn string(value: Value) -> Option<CString> {
    // A text that was set through C has no zero inside.
    if let Value::Text(v) = value { CString::new(v).ok() } else { None }
}
