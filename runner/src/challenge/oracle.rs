//! Whether anybody could see a cause, and whether it matters: what a refit leaves of its true change of the force, for somebody who
//! knows the true parameters and the forms of all causes; of one of a pair, what a refit with the other one in any size leaves. No
//! candidate of the catalogue comes into it. The refit is linear at the true parameters; of a single cause it is carried to the
//! minimum, as parameters that move far absorb more or less than their derivatives say: from the true parameters and, while the cause
//! is visible, from where the data themselves would let a fit start, since the lowest minimum may be far from the truth.

use super::draw::Drawn;
use super::key::VISIBLE;
use super::make::MakeError;
use crate::data::Measurement;
use crate::diagnosis::gap::gap_percent;
use crate::diagnosis::plain_start::{PlainStarts, plain_starts};
use crate::engine::Engine;
use crate::fit::{FitError, Problem as _, Whitening as _};
use crate::inference::fit::{Depth, Fit, FitFailure, FitPlan, fit, linearised};
use crate::inference::requests::Defaults;
use crate::inference::{ForceProblem, Requests, Setup, Unknowns};
use crate::noise::observation::observe;
use crate::noise::{Covariance, Weights, noise_model};
use crate::setting::written;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// Singular values below this are none.
const ROUNDING: f64 = 1e-12;

/// Evaluations of a refit to its minimum.
const EVALUATIONS: usize = 40;

/// What a refit leaves of a cause.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// In units of the noise.
    pub score: f64,
    /// Largest mean over half a decade of time, as part of the test's largest force (%).
    pub gap_percent: f64,
}

/// Of changes of the reading (mN, all tests one after the other) against the plain reading.
pub fn seen(
    engine: &Engine,
    drawn: &Drawn,
    numerics: &BTreeMap<String, f64>,
    measurements: &[Measurement],
    changes_mn: &[Vec<f64>],
) -> Result<Vec<Seen>, MakeError> {
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
    let (difference_mn, jacobian_mn) = ForceProblem::new(setup, &[]).with_jacobian(&x)?;
    let plain_mn: Vec<f64> = difference_mn.iter().zip(setup.measured_mn()).map(|(d, m)| d + m).collect();
    let covariance = noise_model(&observations, &plain_mn, vec![], &Weights::default())?.covariance;
    let gap_mn = -DVector::from_vec(difference_mn);
    let design = linearised(&jacobian_mn, &gap_mn, &covariance, &unknowns.prior(), &x).design;
    let changes_mn =
        DMatrix::from_columns(&changes_mn.iter().map(|d| DVector::from_row_slice(d)).collect::<Vec<_>>());
    let whitened = covariance.apply_columns(&changes_mn).resize_vertically(design.nrows(), 0.0);
    let left = |k: usize| {
        let others = (0..changes_mn.ncols()).filter(|j| *j != k).collect::<Vec<_>>();
        let taken = beside(&design, &whitened.select_columns(&others));
        let by = taken.clone().svd(true, true).solve(&whitened.column(k), ROUNDING).ok()?;
        let score = (whitened.column(k) - taken * &by).norm();
        let left_mn = changes_mn.column(k) - beside(&jacobian_mn, &changes_mn.select_columns(&others)) * by;
        Some(Seen { score, gap_percent: gap_percent(&observations, &left_mn) })
    };
    let mut all: Vec<Seen> =
        (0..changes_mn.ncols()).map(|k| left(k).ok_or(MakeError::NotFinite)).collect::<Result<_, _>>()?;
    if let [single] = &mut all[..] {
        let mut starts = vec![x];
        for of_data in starts_of_data(setup, &requests)? {
            starts.push(unknowns.clone().starting_at(&of_data).start().to_vec());
        }
        *single = refitted(setup, &covariance, &starts, &plain_mn, &changes_mn)?;
    }
    Ok(all)
}

/// Where fits to these data would start.
fn starts_of_data(setup: Setup, requests: &Requests) -> Result<Vec<Vec<f64>>, MakeError> {
    let engine = setup.engine;
    let one = |defaults: Defaults| {
        let requests = Requests { start: vec![], defaults, ..requests.clone() };
        Ok(Unknowns::new(engine.wiring(), engine.is_own(), &requests)?.start().to_vec())
    };
    let starts = plain_starts(engine, setup.observations, requests)?;
    starts.into_iter().flat_map(PlainStarts::all).map(one).collect()
}

/// What the best fit of the plain model leaves of a change (mN), of searches from several starts.
fn refitted(
    setup: Setup,
    covariance: &Covariance,
    starts: &[Vec<f64>],
    plain_mn: &[f64],
    change_mn: &DMatrix<f64>,
) -> Result<Seen, MakeError> {
    let measured_mn = setup.measured_mn();
    // A fit compares with what was measured: what this differs by from the force without noise is added to the model's.
    let offset_mn: Vec<f64> = measured_mn
        .iter()
        .zip(plain_mn.iter().zip(change_mn.column(0).iter()))
        .map(|(measured, (plain, change))| measured - plain - change)
        .collect();
    let setup = Setup { offset_mn: &offset_mn, ..setup };
    let score = |fit: &Fit| covariance.apply(&fit.gap_mn).norm();
    let mut found: Option<Fit> = None;
    for start in starts {
        let plan = FitPlan { start: start.clone(), evaluations: EVALUATIONS, depth: Depth::Minimum };
        let other = match fit(setup, &[], covariance, &plan, &mut |_| ()) {
            // The truth can be computed; another start need not.
            Err(FitFailure::Fit(FitError::StartFailed(_))) if found.is_some() => continue,
            other => other?,
        };
        if found.as_ref().is_none_or(|best| other.solution.chi_square < best.solution.chi_square) {
            found = Some(other);
        }
        // What one fit hides needs no other.
        if found.as_ref().is_some_and(|best| score(best) < VISIBLE) {
            break;
        }
    }
    let found = found.ok_or(MakeError::NotFinite)?;
    Ok(Seen { score: score(&found), gap_percent: gap_percent(setup.observations, &found.gap_mn) })
}

/// Columns of both.
fn beside(first: &DMatrix<f64>, second: &DMatrix<f64>) -> DMatrix<f64> {
    let columns: Vec<_> = first.column_iter().chain(second.column_iter()).collect();
    DMatrix::from_columns(&columns)
}
