//! Fits by generalised least squares: the plain model, or the model with effects, and their linearisation.

mod side_by_side;
mod tangent;
mod together;

pub(super) use side_by_side::{Searched, searched};
pub use tangent::{Tangent, linearised};
pub use together::least_chi_square;

use super::effect::Candidate;
use super::jacobian_load::JacobianLoad;
use super::linearised::Linearised;
use super::problem::ForceProblem;
use super::rough::{self, Goal, Led, Trust, Twin};
use super::setup::Setup;
use crate::fit::{
    EvaluationFailure, FitError, IterationRecord, Options, Prior, Problem, SharedErrors, Solution,
    StartRecord, minimise,
};
use crate::noise::Covariance;
use nalgebra::{DMatrix, DVector};
use thiserror::Error;

/// A fit with everything that is judged of it.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Optimum.
    pub solution: Solution,
    /// Around it.
    pub linear: Linearised,
    /// Measured minus model (mN).
    pub gap_mn: DVector<f64>,
    /// Derivatives of the force by variables and magnitudes (mN).
    pub jacobian_mn: DMatrix<f64>,
    /// Number of material variables; the rest of the solution are magnitudes.
    pub parameters: usize,
    /// Knowledge of variables and magnitudes before.
    pub prior: Prior,
    /// Of the measured force minus this model's.
    pub covariance: Covariance,
    /// How far it was carried.
    pub end: End,
}

/// How far a fit was carried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// To where a rough fit by a rougher model ends; the model asked for was run there, derivatives are the rougher one's.
    RougherModel,
    /// Until an iteration gained a few per cent of chi^2 only.
    Rough,
    /// To its minimum.
    Minimum,
}

/// A fit ends where the next iteration is expected to lower chi^2 by less than this: a value then moves by a seventh of its deviation.
const FORESEEN: f64 = 0.02;
/// It also ends where an iteration has lowered chi^2 by less than this: the next one lowers it by much less, and below lies the noise
/// of the model's own steps.
const SETTLED: f64 = 0.1;
/// A fit that is compared with others ends so many times earlier: where its chi^2 is known to a tenth of what decides between them.
const AMONG_RIVALS: f64 = 5.0;
/// An iteration that lowers chi^2 by a smaller part ends a rough fit.
pub const ROUGH: f64 = 3e-2;
/// An iteration that is expected to lower chi^2 by less than this part of it is not made in a rough fit, nor a step shorter than one that was rejected.
const ROUGH_FORESEEN: f64 = 3e-3;
/// A Jacobian is not more accurate than this part of its largest singular value: by finite differences, and from the FMU's
/// derivatives.
const JACOBIAN_ACCURACY: [f64; 2] = [1e-4, 1e-6];

/// A fit that could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FitFailure {
    /// No start, or bounds that cannot be used.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The model failed, or the user asked to stop.
    #[error(transparent)]
    Evaluation(#[from] EvaluationFailure),
}

/// How a fit with effects is made.
#[derive(Debug, Clone)]
pub struct FitPlan {
    /// Start of parameters and magnitudes.
    pub start: Vec<f64>,
    /// Largest number of evaluations of each of its parts.
    pub evaluations: usize,
    /// How far it is carried.
    pub depth: Depth,
    /// What a rougher model that leads a rough fit is trusted with.
    pub trust: Trust,
}

impl FitPlan {
    /// Of a fit that is as good as it can be.
    pub fn to_minimum(start: &[f64], evaluations: usize) -> Self {
        let start = start.to_vec();
        Self { start, evaluations, depth: Depth::Minimum, trust: Trust::LITTLE }
    }
}

/// How far a fit is carried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Depth {
    /// By the model asked for alone, until an iteration gains a few per cent of chi^2 only.
    Rough,
    /// To its minimum where a rough fit has a smaller chi^2 than this.
    Below(f64),
    /// To its minimum.
    Minimum,
}

impl Depth {
    /// Whether a rough fit with this chi^2 is carried to its minimum.
    fn goes_on(self, rough_chi_square: f64) -> bool {
        match self {
            Self::Rough => false,
            Self::Below(chi_square) => rough_chi_square < chi_square,
            Self::Minimum => true,
        }
    }
}

/// How a search from several starts is made.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchPlan {
    /// The unknowns' own start, and drawn ones.
    pub starts: usize,
    /// Seed of the drawn ones.
    pub seed: u64,
    /// Other starts that the data tell; they are tried beside these.
    pub others: Vec<Vec<f64>>,
    /// Largest number of evaluations per start.
    pub evaluations: usize,
}

impl SearchPlan {
    /// Starts in all.
    pub fn all_starts(&self) -> usize {
        self.starts + self.others.len()
    }
}

/// What a search from several starts found.
#[derive(Debug, Clone)]
pub struct Found {
    /// The best fit.
    pub fit: Fit,
    /// Which start it came from.
    pub best_start: usize,
    /// The fate of each start.
    pub starts: Vec<StartRecord>,
    /// How busy the pool was while Jacobians were formed.
    pub load: JacobianLoad,
    /// Points at which the model failed.
    pub failed_points: u64,
    /// The rough model that stands for the one asked for around the fit, where one was used.
    pub twin: Option<Twin>,
}

/// What a fit makes small. Where the size of the noise is not known, nor is what the prior weighs against it: then it is left out.
pub(super) fn problem<'a>(
    setup: Setup<'a>,
    active: &[&'a Candidate],
    covariance: &'a Covariance,
) -> SharedErrors<'a, ForceProblem<'a>, Covariance> {
    let measured = DVector::from_vec(setup.measured_mn());
    let forces = ForceProblem::new(setup, active);
    let prior = if covariance.is_known() { forces.prior() } else { forces.prior().flat() };
    SharedErrors::new(forces, covariance, measured, prior)
}

/// The same of the plain model, without what is known before of the variables that `own` names.
pub(super) fn problem_without_prior<'a>(
    setup: Setup<'a>,
    covariance: &'a Covariance,
    own: &dyn Fn(usize) -> bool,
) -> SharedErrors<'a, ForceProblem<'a>, Covariance> {
    let measured = DVector::from_vec(setup.measured_mn());
    let forces = ForceProblem::new(setup, &[]);
    let mut prior = forces.prior();
    for (j, deviation) in prior.deviation.iter_mut().enumerate() {
        if own(j) || !covariance.is_known() {
            *deviation = f64::INFINITY;
        }
    }
    SharedErrors::new(forces, covariance, measured, prior)
}

/// chi^2 with parameters and magnitudes as in each of `points`, which are computed at once; `None` where the model cannot be computed.
///
/// # Errors
/// When the user asked to stop.
pub fn chi_squares(
    setup: Setup,
    active: &[&Candidate],
    covariance: &Covariance,
    points: &[Vec<f64>],
) -> Result<Vec<Option<f64>>, EvaluationFailure> {
    let mut problem = problem(setup, active, covariance);
    problem.prefetch(points);
    let one = |x: &Vec<f64>| {
        let residual = EvaluationFailure::or_none(problem.residual(x))?;
        Ok(residual.map(|residual| residual.iter().map(|r| r * r).sum()))
    };
    points.iter().map(one).collect()
}

/// Tolerances of a fit to so many points.
pub(super) fn options(setup: Setup, evaluations: usize) -> Options {
    // Relative to chi^2, which is about as large as the number of points, or they are as many times less worth.
    let points = setup.measured_mn().len().max(1) as f64;
    Options {
        max_evaluations: evaluations,
        chi_square_tolerance: SETTLED / points,
        noise_tolerance: SETTLED / points,
        foreseen_tolerance: FORESEEN / points,
        ..Options::for_log_parameters(JACOBIAN_ACCURACY[usize::from(setup.is_differentiable())])
    }
}

/// Those of a rough fit, which ends where an iteration lowers chi^2 by less than a part.
fn rough_options(settled: &Options, part: f64) -> Options {
    Options {
        chi_square_tolerance: part.max(settled.chi_square_tolerance),
        foreseen_tolerance: ROUGH_FORESEEN.max(settled.foreseen_tolerance),
        noise_tolerance: ROUGH_FORESEEN.max(settled.noise_tolerance),
        ..settled.clone()
    }
}

/// Fits the plain model from several starts. A stop asked of the engine ends the fit at its best point; `observe` sees each accepted
/// step with the index of its start.
///
/// # Errors
/// When no start can be evaluated.
pub fn search(
    setup: Setup,
    covariance: &Covariance,
    plan: &SearchPlan,
    observe: &mut dyn FnMut(usize, &IterationRecord),
) -> Result<Found, FitFailure> {
    let options = options(setup, plan.evaluations);
    let Searched { joined, load, failed_points, .. } = searched(setup, covariance, plan, &options, observe)?;
    // Its runs were made: no stop keeps them from being seen.
    let fit = Fit::at(setup, &[], covariance, joined.best)?;
    let (best_start, starts) = (joined.best_start, joined.records);
    Ok(Found { fit, best_start, starts, load, failed_points, twin: None })
}

/// Fits the plain model from a point near the optimum.
///
/// # Errors
/// When the model fails there, or the user asked to stop before it was evaluated.
pub fn refit(
    setup: Setup,
    covariance: &Covariance,
    start: &[f64],
    evaluations: usize,
) -> Result<Fit, FitFailure> {
    let mut problem = problem(setup, &[], covariance);
    let bounds = setup.unknowns.optimiser_bounds();
    let mut watch = |_: &IterationRecord| setup.engine.going_on();
    let solution = minimise(&mut problem, start, bounds, &options(setup, evaluations), &mut watch)?;
    Ok(Fit::at(setup, &[], covariance, solution)?)
}

/// Where a fit of the plain model would end, and about with which chi^2: by a rougher model, where there is one and it can be computed.
///
/// # Errors
/// When the start cannot be evaluated, or the user asked to stop.
pub fn foreseen_end(
    setup: Setup,
    covariance: &Covariance,
    (start, evaluations): (&[f64], usize),
    observe: &mut dyn FnMut(&IterationRecord),
) -> Result<(Vec<f64>, f64), FitFailure> {
    let mut watch = |record: &IterationRecord| {
        observe(record);
        setup.engine.going_on()
    };
    let bounds = setup.unknowns.optimiser_bounds();
    let options = rough_options(&options(setup, evaluations), ROUGH_FORESEEN);
    let goal = Goal { bounds, options: &options, trust: Trust::LITTLE };
    if let Some(led) = rough::lead(setup, &[], covariance, start, goal, &mut watch)? {
        return Ok((led.solution.x, led.solution.chi_square));
    }
    let plan = FitPlan { depth: Depth::Rough, ..FitPlan::to_minimum(start, evaluations) };
    let found = fit(setup, &[], covariance, &plan, observe)?;
    Ok((found.x().to_vec(), found.foreseen()))
}

/// [`foreseen_end`] where its chi^2 is less than this; none where it is not, or the start cannot be evaluated.
///
/// # Errors
/// When the model fails beyond the start, or the user asked to stop.
pub fn foreseen_below(
    setup: Setup,
    covariance: &Covariance,
    (start, evaluations): (&[f64], usize),
    chi_square: f64,
    observe: &mut dyn FnMut(&IterationRecord),
) -> Result<Option<(Vec<f64>, f64)>, FitFailure> {
    match foreseen_end(setup, covariance, (start, evaluations), observe) {
        Err(FitFailure::Fit(FitError::StartFailed(_))) => Ok(None),
        found => Ok(Some(found?).filter(|(_, foreseen)| *foreseen < chi_square)),
    }
}

/// Fits parameters and the magnitudes of `active`, of which no admissible size is held against another before.
///
/// # Errors
/// When no start can be evaluated, or the user asked to stop.
pub fn fit(
    setup: Setup,
    active: &[&Candidate],
    covariance: &Covariance,
    plan: &FitPlan,
    observe: &mut dyn FnMut(&IterationRecord),
) -> Result<Fit, FitFailure> {
    let bounds = ForceProblem::new(setup, active).bounds()?;
    let settled = options(setup, plan.evaluations);
    let rough = rough_options(&settled, ROUGH);
    let settled = Options {
        chi_square_tolerance: AMONG_RIVALS * settled.chi_square_tolerance,
        foreseen_tolerance: AMONG_RIVALS * settled.foreseen_tolerance,
        noise_tolerance: AMONG_RIVALS * settled.noise_tolerance,
        ..settled
    };
    let tolerances = |to_minimum: bool| if to_minimum { &settled } else { &rough };
    let mut problem = problem(setup, active, covariance);
    let mut watch = |record: &IterationRecord| {
        observe(record);
        setup.engine.going_on()
    };
    let mut from = |start: &[f64], to_minimum: bool| {
        let found = minimise(&mut problem, start, &bounds, tolerances(to_minimum), &mut watch);
        if setup.engine.is_stopped() {
            return Err(FitFailure::from(EvaluationFailure::Interrupted));
        }
        Ok((found?, if to_minimum { End::Minimum } else { End::Rough }))
    };
    // A rougher model leads near to the end, where there is one and it leads anywhere.
    let lead = |start: &[f64], to_minimum: bool| {
        let mut going_on = |_: &IterationRecord| setup.engine.going_on();
        let trust = if to_minimum { Trust::LITTLE } else { plan.trust };
        let goal = Goal { bounds: &bounds, options: tolerances(to_minimum), trust };
        rough::lead(setup, active, covariance, start, goal, &mut going_on)
    };
    let depth = plan.depth;
    let led = match depth {
        Depth::Rough => None,
        depth => lead(&plan.start, depth == Depth::Minimum)?,
    };
    let mut found = None;
    if let Some(Led { mut solution, chi_square_before, twin }) = led {
        let to_minimum = depth.goes_on(solution.chi_square);
        let is_on_the_way = solution.chi_square <= (1.0 + plan.trust.astray) * chi_square_before;
        if let Some(twin) = twin.filter(|_| !to_minimum && is_on_the_way) {
            // The model asked for gives what the rougher one does there: a rough fit needs no more.
            let fit = Fit::at(twin.setup(setup), active, covariance, solution)?;
            return Ok(Fit { end: End::RougherModel, ..fit });
        }
        if to_minimum && depth != Depth::Minimum {
            solution = lead(&solution.x, true)?.map_or(solution, |further| further.solution);
        }
        match from(&solution.x, to_minimum) {
            // A start that is the minimum already is one to within what the fit settles at.
            Ok((solution, at)) if solution.chi_square <= chi_square_before + AMONG_RIVALS * SETTLED => {
                found = Some((solution, at));
            }
            Ok(_) | Err(FitFailure::Fit(FitError::StartFailed(_))) => {}
            Err(other) => return Err(other),
        }
    }
    let (mut solution, mut end) = match found {
        Some(found) => found,
        None => from(&plan.start, false)?,
    };
    if end != End::Minimum && depth.goes_on(solution.chi_square) {
        (solution, end) = from(&solution.x, true)?;
    }
    Ok(Fit { end, ..Fit::at(setup, active, covariance, solution)? })
}
