//! Error of the simulation, from a finer mesh and finer time steps at the same parameters.

use super::problem::Setup;
use crate::fit::EvaluationFailure;
use crate::noise::{Common, Observation, refinement};
use crate::pool::{Priority, Run};

const PRESET: &str = "mesh.preset";
const TOLERANCE: &str = "solver.tolerance";
/// The finest preset.
const FINEST: f64 = 3.0;
/// A tolerance ten times smaller leaves a negligible error.
const TIGHTER: f64 = 0.1;

/// A parameter's new value from its old one.
type Change = fn(f64) -> f64;

/// Differences that a finer mesh and finer steps make at `x` (mN); none for an FMU without such parameters. The runs
/// are made only where a test's motion allows them: one that fails adds nothing.
///
/// # Errors
/// When the plain model fails, or the user asked to stop.
pub fn refined(setup: Setup, x: &[f64]) -> Result<Vec<Common>, EvaluationFailure> {
    let plain = Setup::forces_mn(&setup.submit(x, &[], false, Priority::Urgent))?;
    let mut all = Vec::new();
    let changes: [(&str, &str, Change); 2] = [
        ("mesh", PRESET, |preset| (preset + 1.0).min(FINEST)),
        ("time steps", TOLERANCE, |tolerance| tolerance * TIGHTER),
    ];
    for (name, parameter, change) in changes {
        let mut values = setup.parameters.settings(x);
        let Some(value) = setup.value(&values, parameter) else { continue };
        values.insert(parameter.to_owned(), change(value));
        let start = |o: &Observation| setup.engine.submit(&o.dataset.job(&values), Priority::Urgent);
        let runs: Vec<Run> = setup.observations.iter().map(start).collect();
        if let Some(fine) = Setup::computable_forces_mn(&runs)? {
            all.extend(refinement(&format!("simulation: {name}"), &plain, &fine));
        }
    }
    Ok(all)
}
