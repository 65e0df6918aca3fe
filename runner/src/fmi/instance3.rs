//! One instance of an FMI 3.0 FMU, without event mode and early return.
#![allow(unsafe_code)]

use super::archive::Files;
use super::binary3::{Binary3, Get, Set};
use super::core::{Call, Core, c_text, heard};
use super::instance::Face;
use super::places::{Base, Place};
use super::{FmiError, ModelDescription};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::null;
use std::sync::Arc;

unsafe extern "C" fn log(
    environment: *mut c_void,
    status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the `Messages` of the instance that called, alive until it is freed; the message is a C string.
    if let Some((messages, text)) = unsafe { heard(environment, status, message) } {
        messages.push(text);
    }
}

/// One instance. Send: it may move between threads, but is used by one at a time.
pub struct Instance3 {
    core: Core,
    binary: Arc<Binary3>,
    experiment: (f64, Option<f64>),
    /// Whether variables may be read.
    readable: bool,
    /// Numbers of the arrays as they were set: FMI sets whole arrays, this program elements.
    arrays: BTreeMap<u32, Vec<f64>>,
}

impl Instance3 {
    pub fn new(
        binary: &Arc<Binary3>,
        description: &Arc<ModelDescription>,
        files: Option<&Arc<Files>>,
        name: &str,
    ) -> Result<Self, FmiError> {
        let instantiate = |Call { name, guid, resources, environment }: Call<'_>| {
            let (name, token) = (name.as_ptr(), guid.as_ptr());
            let no = false;
            // SAFETY: all strings live until the call returns; the messages as long as the component.
            unsafe {
                (binary.instantiate)(
                    name,
                    token,
                    resources,
                    no,
                    no,
                    no,
                    no,
                    null(),
                    0,
                    environment,
                    log,
                    null(),
                )
            }
        };
        let resources = files.map(|files| files.resource_path());
        let own = (binary.states, binary.free_instance);
        // SAFETY: all functions are of this library.
        let core =
            unsafe { Core::new(binary.clone(), own, description, (files, resources), name, instantiate)? };
        let binary = binary.clone();
        let mut instance =
            Self { core, binary, experiment: (0.0, None), readable: false, arrays: BTreeMap::new() };
        instance.forget();
        Ok(instance)
    }

    /// As after the instantiation.
    fn forget(&mut self) {
        (self.experiment, self.readable) = ((0.0, None), false);
        let starts = self.core.description.places.starts.iter();
        let arrays = starts.filter(|(_, elements)| elements.numbers.len() > 1);
        self.arrays = arrays.map(|(&reference, elements)| (reference, elements.numbers.clone())).collect();
    }

    fn place(&self, reference: u32) -> Result<Place, FmiError> {
        let place = self.core.description.places.scalars.get(&reference);
        place.copied().ok_or_else(|| FmiError::UnknownVariable(format!("reference {reference}")))
    }

    fn length(&self, reference: u32) -> usize {
        self.core.description.places.starts.get(&reference).map_or(1, |elements| elements.numbers.len())
    }

    /// Values of scalars as numbers (Booleans: 0 or 1): one call for every type.
    fn numbers(&self, references: &[u32]) -> Result<Vec<f64>, FmiError> {
        let places = references.iter().map(|&r| self.place(r)).collect::<Result<Vec<_>, _>>()?;
        let mut wanted: BTreeMap<Base, Vec<u32>> = BTreeMap::new();
        for place in &places {
            let of_type = wanted.entry(place.base).or_default();
            // Neighbours are often of one array.
            if of_type.last() != Some(&place.reference) {
                of_type.push(place.reference);
            }
        }
        let mut read: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
        for (base, mut variables) in wanted {
            variables.sort_unstable();
            variables.dedup();
            let mut values = self.get(base, &variables)?.into_iter();
            for variable in variables {
                read.insert(variable, values.by_ref().take(self.length(variable)).collect());
            }
        }
        Ok(places.iter().map(|place| read[&place.reference][place.index]).collect())
    }

    /// Sets scalars: one call for every type, with whole arrays.
    fn set_numbers(&mut self, references: &[u32], values: &[f64]) -> Result<(), FmiError> {
        assert_eq!(references.len(), values.len(), "slices differ in length");
        let mut given: BTreeMap<Base, BTreeMap<u32, Vec<f64>>> = BTreeMap::new();
        for (&reference, &value) in references.iter().zip(values) {
            let place = self.place(reference)?;
            let elements = match given.entry(place.base).or_default().entry(place.reference) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => new.insert(self.whole(place)?),
            };
            elements[place.index] = value;
        }
        for (base, variables) in given {
            let own: Vec<u32> = variables.keys().copied().collect();
            let values: Vec<f64> = variables.values().flatten().copied().collect();
            self.set(base, &own, &values)?;
            self.arrays.extend(variables.into_iter().filter(|(_, elements)| elements.len() > 1));
        }
        Ok(())
    }

    /// All elements of a variable as they are.
    fn whole(&self, place: Place) -> Result<Vec<f64>, FmiError> {
        match self.arrays.get(&place.reference) {
            Some(_) if self.readable => self.get(place.base, &[place.reference]),
            Some(elements) => Ok(elements.clone()),
            None => Ok(vec![0.0; self.length(place.reference)]),
        }
    }

    fn get(&self, base: Base, variables: &[u32]) -> Result<Vec<f64>, FmiError> {
        let b = &self.binary;
        match base {
            Base::Float64 => self.get_with("fmi3GetFloat64", Some(b.get_float64), variables, |v| v),
            Base::Float32 => self.get_with("fmi3GetFloat32", b.get_float32, variables, f64::from),
            Base::Int8 => self.get_with("fmi3GetInt8", b.get_int8, variables, f64::from),
            Base::UInt8 => self.get_with("fmi3GetUInt8", b.get_uint8, variables, f64::from),
            Base::Int16 => self.get_with("fmi3GetInt16", b.get_int16, variables, f64::from),
            Base::UInt16 => self.get_with("fmi3GetUInt16", b.get_uint16, variables, f64::from),
            Base::Int32 => self.get_with("fmi3GetInt32", b.get_int32, variables, f64::from),
            Base::UInt32 => self.get_with("fmi3GetUInt32", b.get_uint32, variables, f64::from),
            Base::Int64 => self.get_with("fmi3GetInt64", b.get_int64, variables, |v| v as f64),
            Base::UInt64 => self.get_with("fmi3GetUInt64", b.get_uint64, variables, |v| v as f64),
            Base::Boolean => {
                self.get_with("fmi3GetBoolean", b.get_boolean, variables, |v| f64::from(u8::from(v != 0)))
            }
            Base::String => Err(FmiError::NotSupported("give texts as numbers")),
        }
    }

    fn set(&self, base: Base, variables: &[u32], values: &[f64]) -> Result<(), FmiError> {
        let b = &self.binary;
        match base {
            Base::Float64 => self.set_with("fmi3SetFloat64", Some(b.set_float64), variables, values, |v| v),
            Base::Float32 => self.set_with("fmi3SetFloat32", b.set_float32, variables, values, |v| v as f32),
            Base::Int8 => self.set_with("fmi3SetInt8", b.set_int8, variables, values, |v| v as i8),
            Base::UInt8 => self.set_with("fmi3SetUInt8", b.set_uint8, variables, values, |v| v as u8),
            Base::Int16 => self.set_with("fmi3SetInt16", b.set_int16, variables, values, |v| v as i16),
            Base::UInt16 => self.set_with("fmi3SetUInt16", b.set_uint16, variables, values, |v| v as u16),
            Base::Int32 => self.set_with("fmi3SetInt32", b.set_int32, variables, values, |v| v as i32),
            Base::UInt32 => self.set_with("fmi3SetUInt32", b.set_uint32, variables, values, |v| v as u32),
            Base::Int64 => self.set_with("fmi3SetInt64", b.set_int64, variables, values, |v| v as i64),
            Base::UInt64 => self.set_with("fmi3SetUInt64", b.set_uint64, variables, values, |v| v as u64),
            Base::Boolean => {
                self.set_with("fmi3SetBoolean", b.set_boolean, variables, values, |v| u8::from(v != 0.0))
            }
            Base::String => Err(FmiError::NotSupported("set texts as numbers")),
        }
    }

    fn get_with<T: Copy + Default>(
        &self,
        function: &'static str,
        get: Option<Get<T>>,
        variables: &[u32],
        from: impl Fn(T) -> f64,
    ) -> Result<Vec<f64>, FmiError> {
        let get = get.ok_or(FmiError::NotSupported("read a variable of its own type"))?;
        let mut values = vec![T::default(); variables.iter().map(|&v| self.length(v)).sum()];
        let (n, n_values) = (variables.len(), values.len());
        // SAFETY: a live component of this library; the arrays have the stated length.
        let status =
            unsafe { get(self.core.component, variables.as_ptr(), n, values.as_mut_ptr(), n_values) };
        self.core.messages.check(function, status)?;
        Ok(values.into_iter().map(from).collect())
    }

    fn set_with<T: Copy>(
        &self,
        function: &'static str,
        set: Option<Set<T>>,
        variables: &[u32],
        values: &[f64],
        to: impl Fn(f64) -> T,
    ) -> Result<(), FmiError> {
        let set = set.ok_or(FmiError::NotSupported("set a variable of its own type"))?;
        let values: Vec<T> = values.iter().copied().map(to).collect();
        let n = variables.len();
        // SAFETY: a live component of this library; the arrays have the stated length.
        let status =
            unsafe { set(self.core.component, variables.as_ptr(), n, values.as_ptr(), values.len()) };
        self.core.messages.check(function, status)
    }
}

impl Face for Instance3 {
    fn core(&self) -> &Core {
        &self.core
    }

    fn setup_experiment(&mut self, start_time: f64, stop_time: Option<f64>) -> Result<(), FmiError> {
        self.experiment = (start_time, stop_time);
        Ok(())
    }

    fn enter_initialization_mode(&mut self) -> Result<(), FmiError> {
        let (start, stop) = self.experiment;
        let (defined, stop) = (stop.is_some(), stop.unwrap_or(0.0));
        // SAFETY: a live component of this library; so for all calls below.
        let status = unsafe {
            (self.binary.enter_initialization)(self.core.component, false, 0.0, start, defined, stop)
        };
        self.core.messages.check("fmi3EnterInitializationMode", status)?;
        self.readable = true;
        Ok(())
    }

    fn exit_initialization_mode(&mut self) -> Result<(), FmiError> {
        self.core.call("fmi3ExitInitializationMode", self.binary.exit_initialization)
    }

    fn do_step(&mut self, current_time: f64, step_size: f64) -> Result<(), FmiError> {
        let (mut event, mut ends, mut early, mut last) = (0, 0, 0, 0.0);
        let places = (&raw mut event, &raw mut ends, &raw mut early, &raw mut last);
        // SAFETY: a live component of this library; the places live here.
        let status = unsafe {
            (self.binary.do_step)(
                self.core.component,
                current_time,
                step_size,
                true,
                places.0,
                places.1,
                places.2,
                places.3,
            )
        };
        self.core.messages.check("fmi3DoStep", status)?;
        let cut = if ends != 0 {
            "the FMU wants to end the simulation"
        } else if early != 0 {
            "the FMU ended the step early, which it was not allowed to"
        } else {
            return Ok(());
        };
        let (status, messages) = ("discarded".to_owned(), format!("{cut} at {last} s"));
        Err(FmiError::Call { function: "fmi3DoStep", status, messages })
    }

    fn terminate(&mut self) -> Result<(), FmiError> {
        self.core.call("fmi3Terminate", self.binary.terminate)
    }

    fn reset(&mut self) -> Result<(), FmiError> {
        self.core.messages.take();
        self.core.call("fmi3Reset", self.binary.reset)?;
        self.forget();
        Ok(())
    }

    fn set_input_derivatives(&mut self, _: &[u32], _: &[i32], _: &[f64]) -> Result<(), FmiError> {
        Err(FmiError::NotSupported("take derivatives of inputs"))
    }

    fn get_real(&mut self, references: &[u32]) -> Result<Vec<f64>, FmiError> {
        self.numbers(references)
    }

    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), FmiError> {
        self.set_numbers(references, values)
    }

    fn get_integer(&mut self, references: &[u32]) -> Result<Vec<i32>, FmiError> {
        Ok(self.numbers(references)?.into_iter().map(|v| v as i32).collect())
    }

    fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Result<(), FmiError> {
        let values: Vec<f64> = values.iter().copied().map(f64::from).collect();
        self.set_numbers(references, &values)
    }

    fn get_boolean(&mut self, references: &[u32]) -> Result<Vec<bool>, FmiError> {
        Ok(self.numbers(references)?.into_iter().map(|v| v != 0.0).collect())
    }

    fn set_boolean(&mut self, references: &[u32], values: &[bool]) -> Result<(), FmiError> {
        let values: Vec<f64> = values.iter().map(|&v| f64::from(u8::from(v))).collect();
        self.set_numbers(references, &values)
    }

    fn get_string(&mut self, references: &[u32]) -> Result<Vec<String>, FmiError> {
        let get = self.binary.get_string.ok_or(FmiError::NotSupported("give texts"))?;
        let mut texts = Vec::with_capacity(references.len());
        for &reference in references {
            let place = self.place(reference)?;
            let mut values: Vec<*const c_char> = vec![null(); self.length(place.reference)];
            // SAFETY: a live component of this library; the arrays have the stated length.
            let status = unsafe {
                get(self.core.component, &raw const place.reference, 1, values.as_mut_ptr(), values.len())
            };
            self.core.messages.check("fmi3GetString", status)?;
            let text = values.get(place.index).copied().filter(|text| !text.is_null());
            // SAFETY: not NULL, and a C string of the FMU's that lives until its next call.
            let text = text.map(|text| unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned());
            texts.push(text.unwrap_or_default());
        }
        Ok(texts)
    }

    fn set_string(&mut self, references: &[u32], values: &[&str]) -> Result<(), FmiError> {
        assert_eq!(references.len(), values.len(), "slices differ in length");
        let set = self.binary.set_string.ok_or(FmiError::NotSupported("take texts"))?;
        let own = references.iter().map(|&r| self.place(r)).collect::<Result<Vec<_>, _>>()?;
        if own.iter().any(|place| self.length(place.reference) > 1) {
            return Err(FmiError::NotSupported("take single texts of an array"));
        }
        let own: Vec<u32> = own.iter().map(|place| place.reference).collect();
        let texts: Vec<CString> = values.iter().map(|value| c_text(value)).collect::<Result<_, _>>()?;
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        let n = own.len();
        // SAFETY: a live component of this library; the arrays have the stated length and outlive the call.
        let status = unsafe { set(self.core.component, own.as_ptr(), n, pointers.as_ptr(), n) };
        self.core.messages.check("fmi3SetString", status)
    }
}
