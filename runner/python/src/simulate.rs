//! One run of the model.

use crate::motion::history;
use crate::parameters::values;
use numpy::{IntoPyArray, PyArrayMethods, PyReadonlyArray1};
use poropunch::variables::sensitivities;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use runner::fmi::Fmu;
use runner::pool::wiring::{Names, Wiring};
use runner::pool::{FmuSimulator, Job, RunFailure, Simulator};
use std::cell::{Cell, RefCell};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How often a run asks whether the user wants to stop it.
const PATIENCE: Duration = Duration::from_millis(100);

/// The FMU, loaded once for all runs and threads.
static LOADED: Mutex<Option<(PathBuf, Arc<Fmu>)>> = Mutex::new(None);

fn fmu(library: PathBuf) -> PyResult<Arc<Fmu>> {
    let mut loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
    match &*loaded {
        Some((from, fmu)) if *from == library => Ok(Arc::clone(fmu)),
        _ => {
            let fmu =
                Fmu::own(library.clone()).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
            let fmu = Arc::new(fmu);
            *loaded = Some((library, Arc::clone(&fmu)));
            Ok(fmu)
        }
    }
}

/// Outputs by name, SI, at `time_s` while the punch follows `displacement_mm`; other threads of Python go on meanwhile.
///
/// `outputs` are recorded beside the force; a name that begins with `sensitivity.` switches the derivatives on.
#[pyfunction]
pub fn simulate<'py>(
    py: Python<'py>,
    library: PathBuf,
    time_s: PyReadonlyArray1<'py, f64>,
    displacement_mm: PyReadonlyArray1<'py, f64>,
    parameters: &Bound<'py, PyDict>,
    outputs: Vec<String>,
    exact_motion: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let (time_s, displacement_mm) = (time_s.to_vec()?, displacement_mm.to_vec()?);
    let protocol = Arc::new(history(&time_s, &displacement_mm, exact_motion)?);
    let fmu = fmu(library)?;
    let names = Names { extra: outputs, ..Names::default() };
    let wiring =
        Wiring::new(fmu.description(), &names).map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
    if let Some(unknown) = names.extra.iter().find(|n| wiring.outputs.iter().all(|port| port.name != **n)) {
        return Err(PyValueError::new_err(match unknown.strip_prefix("sensitivity.force.") {
            Some(parameter) => format!(
                "sensitivities: there is no derivative of the force by `{parameter}`; there is one by every \
                 parameter of the material, material.permeability for one, and by the magnitudes of effects"
            ),
            None => format!("record: the model has no output `{unknown}`"),
        }));
    }
    let mut parameters = values(&wiring, parameters)?;
    for switch in sensitivities::switches(names.extra.iter().map(String::as_str)) {
        parameters.insert(switch.to_owned(), 1.0);
    }
    let job = Job { parameters, protocol, time_s: time_s.into() };
    let wiring = Arc::new(wiring);
    let (ended, interrupt) = py.detach(|| {
        let (asked, interrupt) = (Cell::new(Instant::now()), RefCell::new(None));
        let cancelled = || {
            if asked.get().elapsed() > PATIENCE {
                asked.set(Instant::now());
                interrupt.replace(Python::attach(|py| py.check_signals()).err());
            }
            interrupt.borrow().is_some()
        };
        let simulator = FmuSimulator::new(&fmu, &wiring, "poropunch for Python");
        let ended = simulator.and_then(|mut simulator| simulator.run(&job, &cancelled));
        (ended, interrupt.into_inner())
    });
    if let Some(interrupt) = interrupt {
        return Err(interrupt);
    }
    let curve = ended.map_err(|failure| match failure {
        RunFailure::Cancelled => PyRuntimeError::new_err("the simulation was cancelled"),
        failure => PyRuntimeError::new_err(format!("the simulation failed: {failure}")),
    })?;
    let by_name = PyDict::new(py);
    by_name.set_item("displacement", curve.displacement_m.into_pyarray(py))?;
    for (name, values) in curve.names.into_iter().zip(curve.values) {
        by_name.set_item(name, values.into_pyarray(py))?;
    }
    Ok(by_name)
}
