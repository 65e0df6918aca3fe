//! Error of the simulation, from a finer mesh and finer time steps at the same parameters.

use super::covariance::{Common, refinement};
use super::effect::{Candidate, Effect, Place, Scope, Sign};
use super::problem::Setup;
use crate::fit::EvaluationFailure;
use crate::pool::Priority;
use std::collections::BTreeMap;
use std::sync::Arc;

const PRESET: &str = "mesh.preset";
const TOLERANCE: &str = "solver.tolerance";
/// The finest preset.
const FINEST: f64 = 3.0;
/// A tolerance ten times smaller leaves a negligible error.
const TIGHTER: f64 = 0.1;

/// Differences that a finer mesh and finer steps make at `x` (mN); none for an FMU without such parameters. The runs
/// are made only where a test's motion allows them: one that fails adds nothing.
///
/// # Errors
/// When the plain model fails, or the user asked to stop.
pub fn refined(setup: Setup, x: &[f64]) -> Result<Vec<Common>, EvaluationFailure> {
    let plain = Setup::forces_mn(&setup.submit(x, &[], false, Priority::Urgent))?;
    let mut all = Vec::new();
    let changes: [(&str, &str, fn(f64) -> f64); 2] = [
        ("mesh", PRESET, |preset| (preset + 1.0).min(FINEST)),
        ("time steps", TOLERANCE, |tolerance| tolerance * TIGHTER),
    ];
    for (name, parameter, change) in changes {
        if !setup.engine.wiring().parameters.contains_key(parameter) {
            continue;
        }
        let candidate = finer(name, parameter, change);
        match Setup::forces_mn(&setup.submit(x, &[(&candidate, 1.0)], false, Priority::Urgent)) {
            Ok(fine) => all.extend(refinement(&format!("simulation: {name}"), &plain, &fine)),
            Err(EvaluationFailure::Interrupted) => return Err(EvaluationFailure::Interrupted),
            Err(EvaluationFailure::Failed(_)) => {}
        }
    }
    Ok(all)
}

/// A change of a numerical parameter, in the form of an effect.
fn finer(name: &str, parameter: &'static str, change: fn(f64) -> f64) -> Candidate {
    let effect = Effect {
        name: name.to_owned(),
        family: name.to_owned(),
        title: name.to_owned(),
        place: Place::Numerics,
        sign: Sign::Switch,
        scope: Scope::Shared,
        scale: 1.0,
        unit: String::new(),
        largest: 1.0,
        mimics: String::new(),
        reveals: String::new(),
        differentiable: false,
        parameters: vec![parameter.to_owned()],
        action: Arc::new(move |values: &mut BTreeMap<String, f64>, _| {
            if let Some(value) = values.get_mut(parameter) {
                *value = change(*value);
            }
        }),
    };
    Candidate { name: name.to_owned(), test: None, effect: Arc::new(effect) }
}
