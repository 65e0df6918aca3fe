//! Whether anybody could see a cause: what a refit leaves of its true change of the force, in units of the noise, for
//! somebody who knows the true parameters and the forms of all causes; of one of a pair, what a refit with the other one in any size
//! leaves. No candidate of the catalogue comes into it.

use super::draw::Drawn;
use super::make::MakeError;
use crate::data::Measurement;
use crate::engine::Engine;
use crate::fit::Problem as _;
use crate::inference::Signature;
use crate::inference::fit::linearised;
use crate::inference::{ForceProblem, Setup};
use crate::inference::{Requests, Unknowns};
use crate::noise::observation::observe;
use crate::noise::{Weights, noise_model};
use crate::setting::written;
use nalgebra::DVector;
use std::collections::BTreeMap;

/// Scores of changes of the reading (mN, all tests one after the other) against the plain reading.
pub fn visibility(
    engine: &Engine,
    drawn: &Drawn,
    numerics: &BTreeMap<String, f64>,
    measurements: &[Measurement],
    changes_mn: &[Vec<f64>],
) -> Result<Vec<f64>, MakeError> {
    if changes_mn.is_empty() {
        return Ok(vec![]);
    }
    let pairs = |map: &BTreeMap<String, f64>| {
        map.iter().map(|(name, value)| written(engine.wiring(), name, *value)).collect::<Vec<_>>()
    };
    let is_free = |name: &str| poropunch::variables::identifiable().any(|(v, i)| i.free && v.name == name);
    let (start, known) = drawn.material.clone().into_iter().partition(|(name, _)| is_free(name));
    let (start, known): (BTreeMap<_, _>, BTreeMap<_, _>) = (start, known);
    let set = [pairs(numerics), pairs(&known)].concat();
    let requests = Requests { set, start: pairs(&start), ..Requests::default() };
    let unknowns = Unknowns::new(engine.wiring(), engine.is_own(), &requests)?;
    let observations = observe(measurements, None)?;
    let setup = Setup::new(engine, &observations, &unknowns);
    let x = unknowns.start().to_vec();
    let mut problem = ForceProblem::new(setup, &[]);
    let difference_mn = problem.residual(&x)?;
    let jacobian_mn = problem.jacobian(&x, &difference_mn)?;
    let plain_mn: Vec<f64> = difference_mn.iter().zip(setup.measured_mn()).map(|(d, m)| d + m).collect();
    let covariance = noise_model(&observations, &plain_mn, vec![], &Weights::default())?.covariance;
    let gap_mn = -DVector::from_vec(difference_mn);
    let linear = linearised(&jacobian_mn, &gap_mn, &covariance, &unknowns.prior(), &x);
    let signatures: Vec<Signature> =
        changes_mn.iter().map(|d| linear.signature(&covariance, &DVector::from_row_slice(d))).collect();
    // Of two causes, what is across the other one.
    let seen = |(k, own): (usize, &Signature)| {
        let others = signatures.iter().enumerate().filter(|(j, _)| *j != k);
        others.fold(own.strength(), |left, (_, other)| left * (1.0 - own.cosine(other).powi(2)).sqrt())
    };
    Ok(signatures.iter().enumerate().map(seen).collect())
}
