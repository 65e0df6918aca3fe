//! Motions of the punch.

use numpy::{IntoPyArray, PyArray1};
use poropunch::motion::protocol::{Protocol, ProtocolError};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use runner::cli::protocols::paper;
use runner::data::straight_pieces;

type Array<'py> = Bound<'py, PyArray1<f64>>;

/// Times (s) and displacements (mm) of the paper's P1 or P2.
#[pyfunction]
#[pyo3(signature = (name, cycles, points))]
pub fn protocol<'py>(
    py: Python<'py>,
    name: &str,
    cycles: Option<i32>,
    points: usize,
) -> PyResult<(Array<'py>, Array<'py>)> {
    let refused = |why: String| PyValueError::new_err(why);
    if cycles.is_some_and(|cycles| !(1..=1000).contains(&cycles)) {
        return Err(refused("cycles must be a whole number from 1 to 1000, or None".to_owned()));
    }
    let motion = paper(name, cycles, points).map_err(|error| refused(error.to_string()))?;
    let motion = motion.ok_or_else(|| refused(format!("`{name}` is not a protocol: there are P1 and P2")))?;
    let displacement_mm: Vec<f64> =
        motion.time_s.iter().map(|&t| 1e3 * motion.protocol.displacement(t)).collect();
    Ok((motion.time_s.to_vec().into_pyarray(py), displacement_mm.into_pyarray(py)))
}

/// The motion through samples (s, mm): as straight pieces within their noise, or through each of them.
pub fn history(time_s: &[f64], displacement_mm: &[f64], exact: bool) -> PyResult<Protocol> {
    let (times, displacements) = (time_s.len(), displacement_mm.len());
    if times != displacements || times < 2 {
        return Err(PyValueError::new_err(format!(
            "time_s has {times} values and displacement_mm {displacements}: give as many of both, at least 2"
        )));
    }
    let points: Vec<(f64, f64)> =
        time_s.iter().copied().zip(displacement_mm.iter().map(|d| d * 1e-3)).collect();
    let history = if exact { Protocol::new(points) } else { straight_pieces(&points) };
    history.map_err(|error| PyValueError::new_err(remedy(&error)))
}

fn remedy(error: &ProtocolError) -> String {
    let remedy = match error {
        ProtocolError::NotFinite { .. } => "; leave such samples out",
        ProtocolError::NotIncreasing { .. } => "; sort the samples by time and leave repeated times out",
        ProtocolError::Empty => "",
    };
    format!("time_s, displacement_mm: {error}{remedy}")
}
