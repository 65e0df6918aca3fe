//! Error of the simulation, from a finer mesh and finer time steps, and from where the punch touches, at the same
//! parameters.

use super::problem::Setup;
use crate::fit::EvaluationFailure;
use crate::noise::Observation;
use crate::noise::{Common, refinement};
use crate::pool::{Job, Priority};

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
        let mut values = setup.parameters.settings(x);
        let Some(value) = setup.value(&values, parameter) else { continue };
        values.insert(parameter.to_owned(), change(value));
        let job = |o: &Observation| o.dataset.job(&values);
        if let Some(fine) = rerun(setup, &job)? {
            all.extend(refinement(&format!("simulation: {name}"), &plain, &fine));
        }
    }
    Ok(all)
}

/// Forces of other runs of all tests (mN); `None` where the model fails.
fn rerun(setup: Setup, job: &dyn Fn(&Observation) -> Job) -> Result<Option<Vec<f64>>, EvaluationFailure> {
    let start = |o: &Observation| setup.engine.submit(&job(o), Priority::Urgent);
    Setup::computable_forces_mn(&setup.observations.iter().map(start).collect::<Vec<_>>())
}

/// Where the punch touches is known to a part of what it travels between two samples of the ramp: programs find the
/// touch within their steps, experimenters within their samples. The deviation of a uniform distribution over that length,
/// as an error of each test (mN).
fn touch(setup: Setup, x: &[f64], plain: &[f64]) -> Result<Vec<Common>, EvaluationFailure> {
    let values = setup.parameters.settings(x);
    let deviation = |o: &Observation| o.ramp_spacing_m() / 12f64.sqrt();
    let job = |o: &Observation| o.dataset.deeper_job(&values, deviation(o));
    let deeper = rerun(setup, &job)?;
    let mut all = deeper.map_or(vec![], |deeper| per_test(setup, plain, &deeper, "touch in"));
    // It is a length, not a part of the force: next to the touch it is all there is.
    all.iter_mut().for_each(|common| common.relative = false);
    Ok(all)
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
