//! Error of the simulation, from a finer mesh and finer time steps, and from where the punch touches, at the same
//! parameters.

use super::covariance::{Common, refinement};
use super::effect::{Candidate, Effect, Place, Scope, Sign};
use super::observation::Observation;
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
    all.extend(touch(setup, x, &plain)?);
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

/// Where the punch touches is known to a part of what it travels between two samples of the ramp: programs find the
/// touch within their steps, experimenters within their samples. The deviation of a uniform distribution over that length,
/// as an error of each test (mN).
fn touch(setup: Setup, x: &[f64], plain: &[f64]) -> Result<Vec<Common>, EvaluationFailure> {
    let values = setup.parameters.settings(x);
    let deviation = |o: &Observation| o.ramp_spacing_m() / 12f64.sqrt();
    let start =
        |o: &Observation| setup.engine.submit(&o.dataset.deeper_job(&values, deviation(o)), Priority::Urgent);
    let runs: Vec<_> = setup.observations.iter().map(start).collect();
    match Setup::forces_mn(&runs) {
        Ok(deeper) => {
            let mut all = per_test(setup, plain, &deeper, "touch in");
            // It is a length, not a part of the force: next to the touch it is all there is.
            all.iter_mut().for_each(|common| common.relative = false);
            Ok(all)
        }
        Err(EvaluationFailure::Interrupted) => Err(EvaluationFailure::Interrupted),
        Err(EvaluationFailure::Failed(_)) => Ok(vec![]),
    }
}

/// The difference as one error for each test.
fn per_test(setup: Setup, plain: &[f64], other: &[f64], what: &str) -> Vec<Common> {
    let offsets = setup.offsets();
    let one = |(test, w): (usize, &[usize])| {
        let mut shown = plain.to_vec();
        shown[w[0]..w[1]].copy_from_slice(&other[w[0]..w[1]]);
        refinement(&format!("{what} {}", setup.observations[test].name()), plain, &shown)
    };
    offsets.windows(2).enumerate().filter_map(one).collect()
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
