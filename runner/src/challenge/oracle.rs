//! Whether anybody could see a cause, and whether it matters: what a refit leaves of its true change of the force, for somebody who
//! knows the true parameters and the forms of all causes; of one of a pair, what a refit with the other one in any size leaves. No
//! candidate of the catalogue comes into it. A refit linear at the true parameters tells at once what is far from visible. The others
//! are carried to the minimum, as parameters that move far absorb more or less than their derivatives say: from the true parameters
//! and, while the cause is visible, from where the data themselves would let a fit start, since the lowest minimum may be far from the
//! truth.

use super::draw::Drawn;
use super::key::VISIBLE;
use super::make::MakeError;
use crate::data::Measurement;
use crate::diagnosis::gap::gap_percent;
use crate::diagnosis::plain_start::PlainStarts;
use crate::engine::Engine;
use crate::fit::{Problem as _, Whitening as _};
use crate::inference::fit::{Fit, FitPlan, fit, foreseen_below, linearised};
use crate::inference::{ForceProblem, Requests, Setup, Unknowns};
use crate::noise::observation::observe;
use crate::noise::{Common, Covariance, Observation, Weights, noise_model};
use crate::setting::written;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;

/// Singular values below this are none.
const ROUNDING: f64 = 1e-12;

/// Size of another cause, over its true one, that a refit takes for nothing unusual: any.
const ANY_SIZE: f64 = 100.0;

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

/// What a refit that is linear at the true parameters leaves is hidden, however far a refit would go, where it is this part of what is
/// visible.
const SURELY_HIDDEN: f64 = 0.5;

impl Seen {
    /// Whether what is left by a refit that is linear at the true parameters can surely not be seen.
    pub fn is_surely_hidden(&self) -> bool {
        self.score < SURELY_HIDDEN * VISIBLE
    }
}

/// Who knows the truth of a case.
pub struct Oracle<'a> {
    engine: &'a Engine,
    observations: Vec<Observation>,
    unknowns: Unknowns,
    requests: Requests,
    plain_mn: Vec<f64>,
    jacobian_mn: DMatrix<f64>,
    covariance: Covariance,
    /// The Jacobian and the prior in units of the noise.
    design: DMatrix<f64>,
}

/// Where refits start.
struct Starts {
    /// The true parameters.
    truth: Vec<f64>,
    /// Where fits to the data would.
    of_data: Vec<Vec<f64>>,
}

impl<'a> Oracle<'a> {
    /// Of what was measured of a drawn case.
    ///
    /// # Errors
    /// When the plain model cannot be computed.
    pub fn new(
        engine: &'a Engine,
        drawn: &Drawn,
        numerics: &BTreeMap<String, f64>,
        measurements: &[Measurement],
    ) -> Result<Self, MakeError> {
        let pairs = |map: &BTreeMap<String, f64>| {
            map.iter().map(|(name, value)| written(engine.wiring(), name, *value)).collect::<Vec<_>>()
        };
        let is_free =
            |name: &str| poropunch::variables::identifiable().any(|(v, i)| i.free && v.name == name);
        let (start, known) = drawn.material.clone().into_iter().partition(|(name, _)| is_free(name));
        let (start, known): (BTreeMap<_, _>, BTreeMap<_, _>) = (start, known);
        let set = [pairs(numerics), pairs(&known)].concat();
        let requests = Requests { set, start: pairs(&start), ..Requests::default() };
        let unknowns = Unknowns::new(engine.wiring(), engine.is_own(), &requests)?;
        let observations = observe(measurements, None)?;
        let setup = Setup::new(engine, &observations, &unknowns);
        let x = unknowns.start();
        let (difference_mn, jacobian_mn) = ForceProblem::new(setup, &[]).with_jacobian(x)?;
        let plain_mn: Vec<f64> = difference_mn.iter().zip(setup.measured_mn()).map(|(d, m)| d + m).collect();
        let covariance = noise_model(&observations, &plain_mn, vec![], &Weights::default())?.covariance;
        let gap_mn = -DVector::from_vec(difference_mn);
        let design = linearised(&jacobian_mn, &gap_mn, &covariance, &unknowns.prior(), x).design;
        Ok(Self { engine, observations, unknowns, requests, plain_mn, jacobian_mn, covariance, design })
    }

    /// Of changes of the reading (mN, all tests one after the other) against the plain reading: what a linear refit leaves of each.
    ///
    /// # Errors
    /// When one is no number.
    pub fn seen_linearly(&self, changes_mn: &[Vec<f64>]) -> Result<Vec<Seen>, MakeError> {
        let seen = |k: usize| {
            let (own, others) = apart(changes_mn, k);
            self.left(&self.covariance, &own, &others, (&self.jacobian_mn, &self.design))
        };
        (0..changes_mn.len()).map(seen).collect()
    }

    /// The same of refits that are carried to the minimum, unless all are surely hidden.
    ///
    /// # Errors
    /// When one fails.
    pub fn seen(&self, changes_mn: &[Vec<f64>]) -> Result<Vec<Seen>, MakeError> {
        let linearly = self.seen_linearly(changes_mn)?;
        if linearly.iter().all(Seen::is_surely_hidden) {
            return Ok(linearly);
        }
        let starts = self.starts()?;
        (0..changes_mn.len()).map(|k| self.refitted(changes_mn, k, &starts)).collect()
    }

    /// The true parameters, and where fits to these data would start.
    fn starts(&self) -> Result<Starts, MakeError> {
        let untold = Requests { start: vec![], ..self.requests.clone() };
        let of_data = PlainStarts::of(self.engine, &self.observations, &untold)?;
        let within_bounds = |x: &[f64]| self.unknowns.within_bounds(x);
        Ok(Starts {
            truth: within_bounds(self.unknowns.start()),
            of_data: of_data.all().map(within_bounds).collect(),
        })
    }

    /// What others in any size and some columns (mN, and with the prior in units of the noise) leave of a change.
    fn left(
        &self,
        covariance: &Covariance,
        change_mn: &DVector<f64>,
        others_mn: &DMatrix<f64>,
        (columns_mn, whitened): (&DMatrix<f64>, &DMatrix<f64>),
    ) -> Result<Seen, MakeError> {
        let rows = whitened.nrows();
        let white = |mn: &DMatrix<f64>| covariance.apply_columns(mn).resize_vertically(rows, 0.0);
        let change = white(&DMatrix::from_columns(std::slice::from_ref(change_mn)));
        let taken = beside(whitened, &white(others_mn));
        let by = match taken.ncols() {
            0 => DMatrix::zeros(0, 1),
            _ => taken.clone().svd(true, true).solve(&change, ROUNDING).map_err(|_| MakeError::NotFinite)?,
        };
        let left_mn = change_mn - (beside(columns_mn, others_mn) * &by).column(0);
        Ok(Seen {
            score: (change - taken * by).norm(),
            gap_percent: gap_percent(&self.observations, &left_mn),
        })
    }

    /// What the best fit of the plain model, with the other changes in any size, leaves of one, of searches from several starts.
    fn refitted(&self, changes_mn: &[Vec<f64>], k: usize, starts: &Starts) -> Result<Seen, MakeError> {
        let (own, others) = apart(changes_mn, k);
        let setup = Setup::new(self.engine, &self.observations, &self.unknowns);
        let measured_mn = setup.measured_mn();
        // A fit compares with what was measured: what this differs by from the force without noise is added to the model's.
        let without_noise = self.plain_mn.iter().zip(own.iter());
        let offset_mn: Vec<f64> =
            measured_mn.iter().zip(without_noise).map(|(m, (plain, change))| m - plain - change).collect();
        let setup = Setup { offset_mn: &offset_mn, ..setup };
        let any_size =
            others.column_iter().map(|mn| Common::additive("another cause".to_owned(), mn * ANY_SIZE));
        let covariance = self.covariance.with(any_size);
        let to_minimum = |start: &[f64]| {
            fit(setup, &[], &covariance, &FitPlan::to_minimum(start, EVALUATIONS), &mut |_| ())
        };
        let nothing = DMatrix::zeros(own.len(), 0);
        // Errors in proportion to the force are those at the force of the refit, which may be far from the true one.
        let left = |fit: &Fit| self.left(&fit.covariance, &fit.gap_mn, &others, (&nothing, &nothing));
        let mut best = to_minimum(&starts.truth)?;
        let mut seen = left(&best)?;
        for start in &starts.of_data {
            // What one fit hides needs no other.
            if seen.score < VISIBLE {
                break;
            }
            let least = best.solution.chi_square;
            // The truth can be computed; another start need not.
            let lower = foreseen_below(setup, &covariance, (start, EVALUATIONS), least, &mut |_| ())?;
            if let Some((end, _)) = lower {
                let other = to_minimum(&end)?;
                if other.solution.chi_square < least {
                    (seen, best) = (left(&other)?, other);
                }
            }
        }
        Ok(seen)
    }
}

/// One of some changes (mN), and the others.
fn apart(changes_mn: &[Vec<f64>], k: usize) -> (DVector<f64>, DMatrix<f64>) {
    let all =
        DMatrix::from_columns(&changes_mn.iter().map(|d| DVector::from_row_slice(d)).collect::<Vec<_>>());
    (all.column(k).into_owned(), all.remove_column(k))
}

/// Columns of both.
fn beside(first: &DMatrix<f64>, second: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = first.clone().resize_horizontally(first.ncols() + second.ncols(), 0.0);
    both.columns_mut(first.ncols(), second.ncols()).copy_from(second);
    both
}
