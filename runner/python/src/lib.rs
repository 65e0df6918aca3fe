//! The extension module `poropunch._native`: the model in the Python process, through the FMU as everywhere.

mod motion;
mod parameters;
mod simulate;

use pyo3::prelude::*;

#[pymodule]
mod _native {
    #[pymodule_export]
    use super::motion::protocol;
    #[pymodule_export]
    use super::parameters::parameters;
    #[pymodule_export]
    use super::simulate::simulate;
}
