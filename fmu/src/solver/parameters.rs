//! Time stepping and Newton iteration.

use crate::law::{Magnitude, MaterialParameter};
use serde::{Deserialize, Serialize};

/// Integration scheme in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum TimeScheme {
    /// Two-stage, stiffly accurate, L-stable SDIRK: second order.
    #[default]
    Sdirk2,
    /// Backward Euler, the paper's: first order.
    BackwardEuler,
}

/// Direct solver of the linear systems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum LinearSolverKind {
    /// Multifrontal LU along the mesh's nested dissection; faer's LU where its pivots do not suffice.
    #[default]
    Multifrontal,
    /// faer's sparse LU with partial pivoting.
    Faer,
}

/// Time stepping and Newton iteration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SolverParameters {
    /// Integration scheme.
    pub time_scheme: TimeScheme,
    /// Direct solver of the linear systems.
    pub linear_solver: LinearSolverKind,
    /// Relative error of the force that steps are chosen for [-]; one with up to eight times as much is still taken.
    pub tolerance: f64,
    /// Travel of the punch within the first step after a change of its velocity (m).
    pub initial_increment: f64,
    /// Largest step (s).
    pub max_step: f64,
    /// Newton iteration ends when the scaled residual is below this [-].
    pub newton_tolerance: f64,
    /// Whether the derivatives of the force by the material's parameters are computed along.
    pub sensitivities: bool,
    /// Whether those by the magnitudes of effects are computed, too.
    pub effect_sensitivities: bool,
}

impl SolverParameters {
    /// How many parameters of a specimen of so many branches its force is differentiated by.
    pub fn differentiated(&self, branches: usize) -> usize {
        let magnitudes = if self.effect_sensitivities { Magnitude::OF_SPECIMEN } else { 0 };
        if self.sensitivities { MaterialParameter::count(branches) + magnitudes } else { 0 }
    }
}

impl Default for SolverParameters {
    fn default() -> Self {
        Self {
            time_scheme: TimeScheme::Sdirk2,
            linear_solver: LinearSolverKind::Multifrontal,
            tolerance: 3e-4,
            initial_increment: 2e-6,
            max_step: 1e6,
            newton_tolerance: 1e-9,
            sensitivities: false,
            effect_sensitivities: false,
        }
    }
}
