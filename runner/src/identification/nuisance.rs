//! Contact point and load cell's zero as unknowns of each test: `--zero fit`, `--tare fit`.
//!
//! Each is an error that all points of its test share, with the shape of the force's change: `dF/dh` for a surface that lies `h`
//! higher, 1 for a force that reads too high. With a wide normal prior this is the same as fitting them with the rest. The contact
//! point is not linear: the motion is moved to where it is found, and everything is fitted again, until it stays.

use super::{Identification, IdentificationError, concluded, searched};
use crate::fit::{EvaluationFailure, IterationRecord, Whitening};
use crate::inference::fit::{Fit, refit};
use crate::inference::setup::{job, wait};
use crate::inference::{SearchPlan, Setup, noise_at_start};
use crate::noise::{Common, Observation, Weights};
use crate::pool::Priority;
use crate::report::NuisanceRow;
use nalgebra::{DMatrix, DVector};

/// Which are unknown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Nuisances {
    /// Where each test's surface is.
    pub zero: bool,
    /// What its load cell reads without load.
    pub tare: bool,
}

/// The surface is found by the onset of the force to a tenth of the depth; a wide prior, the data decide.
const ZERO_PART: f64 = 0.1;
/// A load cell that reads a third of the largest force without load is still possible.
const TARE_PART: f64 = 0.3;
/// Step for `dF/dh`, as a part of the depth.
const STEP_PART: f64 = 2e-3;
/// Rounds at most; each corrects the error of the one before to second order.
const ROUNDS: usize = 6;
/// A correction of less than this part of the value's deviation moves nothing.
const SETTLED: f64 = 0.1;
/// Half-width of a 95 % interval of a normal value in deviations.
const DEVIATIONS_95: f64 = 1.96;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Zero,
    Tare,
}

/// One unknown of one test.
#[derive(Debug, Clone)]
struct Nuisance {
    kind: Kind,
    test: usize,
    /// Before the measurement (m or N).
    deviation: f64,
    /// What has been corrected (m or N).
    value: f64,
    /// Afterwards (m or N).
    sigma: f64,
}

/// A fit with the observations as corrected.
#[derive(Debug)]
pub struct Corrected {
    /// The fit.
    pub identification: Identification,
    /// The tests with their zeros where they were found.
    pub observations: Vec<Observation>,
    /// What was found.
    pub rows: Vec<NuisanceRow>,
}

/// Fits the unknowns and the nuisances together, as [`super::identify`] does without; `observe` sees the steps of the first round.
///
/// # Errors
/// As [`super::identify`]; when a test would begin inside the sample.
pub fn identify_with_zeros(
    setup: Setup,
    asked: Nuisances,
    weights: &Weights,
    plan: &SearchPlan,
    is_robust: bool,
    observe: &mut dyn FnMut(usize, &IterationRecord),
) -> Result<Corrected, IdentificationError> {
    let mut observations = setup.observations.to_vec();
    let mut nuisances = asked.of(&observations);
    let noise = noise_at_start(setup, weights)?;
    let covariance = noise.covariance.with(shapes(setup, setup.unknowns.start(), &nuisances)?);
    let mut found = searched(setup, &covariance, plan, observe)?;
    for _ in 0..ROUNDS {
        let is_settled =
            !found.fit.solution.stop.converged() || found_values(setup, &found.fit, &mut nuisances) < SETTLED;
        if is_settled {
            break;
        }
        observations = corrected(setup.observations, &nuisances)?;
        let here = Setup { observations: &observations, ..setup };
        let x = found.fit.solution.x.clone();
        let covariance = noise.covariance.with(shapes(here, &x, &nuisances)?);
        let earlier = found.fit.solution.iterations;
        found.fit = refit(here, &covariance, &x, plan.evaluations)?;
        found.fit.solution.go_on_from(earlier);
    }
    let here = Setup { observations: &observations, ..setup };
    let identification = concluded(here, noise, found, plan, is_robust)?;
    let rows = nuisances.iter().map(|n| n.row(&observations)).collect();
    Ok(Corrected { identification, observations, rows })
}

impl Nuisances {
    fn of(self, observations: &[Observation]) -> Vec<Nuisance> {
        let one = |(test, o): (usize, &Observation)| {
            let largest = o.measurement.force_n.iter().fold(0.0_f64, |a, f| a.max(f.abs()));
            let zero = (Kind::Zero, ZERO_PART * o.measurement.depth_m(), self.zero);
            let tare = (Kind::Tare, TARE_PART * largest, self.tare);
            [zero, tare].into_iter().filter(|(.., is_asked)| *is_asked).map(move |(kind, deviation, _)| {
                Nuisance { kind, test, deviation, value: 0.0, sigma: deviation }
            })
        };
        observations.iter().enumerate().flat_map(one).collect()
    }
}

impl Nuisance {
    fn row(&self, observations: &[Observation]) -> NuisanceRow {
        let (what, unit) = match self.kind {
            Kind::Zero => ("contact point", "mm"),
            Kind::Tare => ("load cell's zero", "mN"),
        };
        let (value, half) = (self.value * 1e3, DEVIATIONS_95 * self.sigma * 1e3);
        NuisanceRow {
            name: format!("{what} of {}", observations[self.test].name()),
            unit: unit.to_owned(),
            value,
            lower: value - half,
            upper: value + half,
        }
    }
}

/// Errors that the nuisances make at variables `x`, one prior deviation large (mN).
fn shapes(setup: Setup, x: &[f64], nuisances: &[Nuisance]) -> Result<Vec<Common>, IdentificationError> {
    let columns = columns(setup, x, nuisances)?;
    let named = columns.column_iter().zip(nuisances).map(|(shape, n)| {
        let name = n.row(setup.observations).name;
        Common::additive(name, shape.into_owned())
    });
    Ok(named.collect())
}

fn columns(setup: Setup, x: &[f64], nuisances: &[Nuisance]) -> Result<DMatrix<f64>, IdentificationError> {
    let values = setup.unknowns.settings(x);
    let total = setup.observations.iter().map(Observation::len).sum();
    let mut columns = DMatrix::zeros(total, nuisances.len());
    let mut runs = Vec::new();
    for n in nuisances.iter().filter(|n| n.kind == Kind::Zero) {
        let o = &setup.observations[n.test];
        let step = STEP_PART * o.measurement.depth_m();
        // Away from the sample: a motion that begins at the surface stays outside.
        let lower = o.moved(-step, 0.0)?;
        let submit = |o: &Observation| setup.engine.submit(&job(o, &values), Priority::Urgent);
        runs.push((step, submit(o), submit(&lower)));
    }
    let mut runs = runs.into_iter();
    for (k, n) in nuisances.iter().enumerate() {
        let before: usize = setup.observations[..n.test].iter().map(Observation::len).sum();
        let mut own = columns.view_mut((before, k), (setup.observations[n.test].len(), 1));
        match (n.kind, runs.len()) {
            (Kind::Zero, 1..) => {
                let Some((step, here, lower)) = runs.next() else { continue };
                let (here, lower) = (curve(&here)?, curve(&lower)?);
                let slopes = here.iter().zip(&lower).map(|(a, b)| 1e3 * (a - b) / step * n.deviation);
                own.copy_from_slice(&slopes.collect::<Vec<f64>>());
            }
            _ => own.fill(1e3 * n.deviation),
        }
    }
    Ok(columns)
}

fn curve(run: &crate::pool::Run) -> Result<Vec<f64>, EvaluationFailure> {
    Ok(wait(run)?.force_n().to_vec())
}

/// Adds to the values what the fit says of them; returns the largest change in deviations.
fn found_values(setup: Setup, fit: &Fit, nuisances: &mut [Nuisance]) -> f64 {
    // The shapes are those in the covariance of the fit, by their names.
    let shape = |n: &Nuisance| {
        let name = n.row(setup.observations).name;
        fit.covariance.common().iter().find(|c| c.name == name).map(|c| c.shape_mn.clone())
    };
    let rest = fit.covariance.apply(&fit.gap_mn);
    let design = fit.covariance.apply_columns(&fit.jacobian_mn);
    let mut curvature = design.tr_mul(&design);
    for (k, deviation) in fit.prior.deviation.iter().enumerate() {
        curvature[(k, k)] += 1.0 / (deviation * deviation);
    }
    let inverse = curvature.pseudo_inverse(1e-12).unwrap_or_else(|_| DMatrix::zeros(0, 0));
    let mut largest = 0.0_f64;
    for n in nuisances {
        let Some(shape) = shape(n) else { continue };
        let white: DVector<f64> = fit.covariance.apply(&shape);
        let shared = design.tr_mul(&white);
        // In prior deviations: mean and variance of a normal value after a linear measurement, the fitted variables unknown, too.
        let mean = white.dot(&rest);
        let variance = 1.0 - white.norm_squared() + shared.dot(&(&inverse * &shared));
        n.sigma = n.deviation * variance.clamp(1e-12, 1.0).sqrt();
        n.value += n.deviation * mean;
        largest = largest.max(n.deviation * mean.abs() / n.sigma);
    }
    largest
}

/// The tests with their zeros where they were found.
fn corrected(
    observations: &[Observation],
    nuisances: &[Nuisance],
) -> Result<Vec<Observation>, IdentificationError> {
    let sum = |test: usize, kind: Kind| -> f64 {
        nuisances.iter().filter(|n| n.test == test && n.kind == kind).map(|n| n.value).sum()
    };
    let one = |(test, o): (usize, &Observation)| o.moved(sum(test, Kind::Zero), sum(test, Kind::Tare));
    Ok(observations.iter().enumerate().map(one).collect::<Result<_, _>>()?)
}
