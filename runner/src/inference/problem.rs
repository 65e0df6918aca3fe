//! The one least-squares problem: variables of the material and magnitudes of effects -> differences from all tests (mN, model
//! minus measured).
//!
//! Columns of the Jacobian come from the FMU's own derivatives of the force, where it has them, and from finite differences
//! elsewhere. Eager: when the optimiser names a trial point, its runs start at once, and those of its finite differences behind them
//! at lower priority. If the point is taken, the Jacobian is already on its way; if it is rejected, dropping the handles cancels
//! what has not run. After a point that was not taken, a worker that would be idle computes the force of the next one without its
//! derivatives beside: it is known in less than half the time whether that is taken.

use super::effect::{Candidate, is_continuous};
use super::jacobian_load::{JacobianLoad, Window};
use super::setup::{Curves, Setup, wait};
use crate::fit::{Bounds, EvaluationFailure, FitError, Prior, Problem};
use crate::pool::{Priority, Run};
use nalgebra::{DMatrix, DMatrixViewMut};

/// A force of which a factor says nothing (mN).
const NO_FORCE_MN: f64 = 0.01;
/// Step of a magnitude for its derivative, in plausible scales.
const MAGNITUDE_STEP: f64 = 0.05;

/// Variables of the material, then the magnitudes of the active effects.
pub struct ForceProblem<'a> {
    setup: Setup<'a>,
    /// Effects whose magnitude is a variable.
    active: Vec<&'a Candidate>,
    /// Switches that are on.
    on: Vec<&'a Candidate>,
    /// Where each column comes from.
    slopes: Vec<Slope>,
    trial: Option<Trial>,
    screened: Vec<(Vec<f64>, Vec<Run>)>,
    /// Whether the derivatives of the last point were asked for.
    was_taken: bool,
    load: JacobianLoad,
    failed: u64,
}

/// Where the derivatives by a variable come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Slope {
    /// The runs themselves.
    Exact,
    /// Runs without the effects that allow none, their slopes multiplied by what these effects multiply the force by. Good enough for
    /// Gauss-Newton steps: such an effect (the traction integral) is another read-out of the same solution.
    OfTheOthers,
    /// Runs at a shifted point.
    Difference,
}

/// Runs of a point and of its Jacobian.
struct Trial {
    x: Vec<f64>,
    runs: Vec<Run>,
    /// The same without derivatives, where these were started, too.
    swift: Option<Vec<Run>>,
    /// Shift and runs of each column by differences.
    shifted: Vec<Option<(f64, Vec<Run>)>>,
    load: Window,
}

impl<'a> ForceProblem<'a> {
    /// With these effects present: their magnitudes free, switches on.
    pub fn new(setup: Setup<'a>, active: &[&'a Candidate]) -> Self {
        let recorded = &setup.engine.wiring().sensitivities;
        let u = setup.unknowns;
        let all_differentiable = active.iter().all(|c| c.effect.differentiable);
        let slope = |j: usize| {
            let recorded = u.slopes(u.start(), j).iter().all(|(name, _)| recorded.contains_key(name));
            match (recorded, all_differentiable) {
                (true, true) => Slope::Exact,
                (true, false) => Slope::OfTheOthers,
                (false, _) => Slope::Difference,
            }
        };
        let (active, on): (Vec<_>, Vec<_>) = active.iter().copied().partition(|c| is_continuous(c));
        let magnitudes = std::iter::repeat_n(Slope::Difference, active.len());
        let slopes = (0..u.len()).map(slope).chain(magnitudes).collect();
        let (trial, screened, load) = (None, Vec::new(), JacobianLoad::default());
        Self { setup, active, on, slopes, trial, screened, was_taken: true, load, failed: 0 }
    }

    /// Bounds of variables and magnitudes.
    ///
    /// # Errors
    /// Never, for effects with a range.
    pub fn bounds(&self) -> Result<Bounds, FitError> {
        let (lower, upper) = self.setup.unknowns.bounds();
        let (mut lower, mut upper) = (lower.to_vec(), upper.to_vec());
        for candidate in &self.active {
            let (low, high) = candidate.range();
            lower.push(low);
            upper.push(high);
        }
        Bounds::new(lower, upper)
    }

    /// What is known of variables and magnitudes before the measurement.
    pub fn prior(&self) -> Prior {
        let own = self.setup.unknowns.prior();
        self.active.iter().fold(own, |prior, c| prior.with(0.0, c.effect.largest))
    }

    /// Number of parameters whose derivatives come from the FMU.
    pub fn exact_columns(&self) -> usize {
        self.slopes.iter().filter(|s| **s != Slope::Difference).count()
    }

    /// How busy the pool was while Jacobians were formed.
    pub fn load(&self) -> JacobianLoad {
        self.load
    }

    /// Points at which the model failed.
    pub fn failed(&self) -> u64 {
        self.failed
    }

    fn split<'b>(&self, x: &'b [f64]) -> (&'b [f64], Vec<(&'a Candidate, f64)>) {
        let (parameters, magnitudes) = x.split_at(self.setup.unknowns.len());
        let free = self.active.iter().copied().zip(magnitudes.iter().copied());
        (parameters, free.chain(self.on.iter().map(|c| (*c, 1.0))).collect())
    }

    /// Starts the runs of a point.
    pub fn submit(&self, x: &[f64], derivatives: bool, priority: Priority) -> Vec<Run> {
        let (parameters, active) = self.split(x);
        self.setup.submit(parameters, &active, derivatives, priority)
    }

    /// The effects whose runs may have derivatives.
    fn differentiable<'b>(&self, x: &'b [f64]) -> (&'b [f64], Vec<(&'a Candidate, f64)>) {
        let (parameters, mut active) = self.split(x);
        active.retain(|(c, _)| c.effect.differentiable);
        (parameters, active)
    }

    /// Starts the runs of a point and of its differences; `may_be_rejected` where its force decides whether its derivatives are wanted.
    fn begin(&self, x: &[f64], may_be_rejected: bool) -> Trial {
        let (engine, with_derivatives) = (self.setup.engine, self.slopes.contains(&Slope::Exact));
        let load = Window::open(engine.pool());
        let runs = self.submit(x, with_derivatives, Priority::Urgent);
        let is_known = runs.iter().all(Run::has_ended);
        // poropunch's own force is the same to the last bit with derivatives and without.
        let is_worth_it = may_be_rejected && with_derivatives && engine.is_own() && !is_known;
        let swift = (is_worth_it && engine.pool().idle() >= runs.len())
            .then(|| self.submit(x, false, Priority::Urgent));
        let shifted = (0..x.len())
            .map(|j| (self.slopes[j] == Slope::Difference).then(|| self.shifted(x, j, None)))
            .collect();
        Trial { x: x.to_vec(), runs, swift, shifted, load }
    }

    /// Runs of a shifted variable; inwards at its upper bound, so that no run leaves the bounds.
    fn shifted(&self, x: &[f64], j: usize, shift: Option<f64>) -> (f64, Vec<Run>) {
        let (step, upper) = match j.checked_sub(self.setup.unknowns.len()) {
            None => (self.setup.step, self.setup.unknowns.bounds().1[j]),
            Some(k) => (MAGNITUDE_STEP, self.active[k].range().1),
        };
        let shift = shift.unwrap_or(if x[j] + step <= upper { step } else { -step });
        let mut y = x.to_vec();
        y[j] += shift;
        (shift, self.submit(&y, false, Priority::Speculative))
    }

    fn difference_mn(&self, runs: &[Run]) -> Result<Vec<f64>, EvaluationFailure> {
        let forces = Setup::forces_mn(runs)?;
        let offset = self.setup.offset_mn.iter().copied().chain(std::iter::repeat(0.0));
        let measured = self.setup.measured_mn();
        Ok(forces.iter().zip(measured).zip(offset).map(|((f, m), offset)| f + offset - m).collect())
    }

    /// Column of a variable from the derivatives of `curves` (mN).
    fn exact_column(&self, x: &[f64], curves: &Curves, j: usize) -> Vec<f64> {
        let recorded = &self.setup.engine.wiring().sensitivities;
        let (parameters, active) = self.differentiable(x);
        let slopes = self.setup.unknowns.slopes(parameters, j);
        let mut column = Vec::new();
        for (test, curve) in curves.iter().enumerate() {
            let (values, plain) = self.setup.values(parameters, &active, test);
            // An effect that multiplies a fitted parameter multiplies its slope too.
            let factor = |name: &str| match (values.get(name), plain.get(name)) {
                (Some(value), Some(before)) if *before != 0.0 => value / before,
                _ => 1.0,
            };
            let terms: Vec<(&[f64], f64)> = slopes
                .iter()
                .map(|(name, slope)| (curve.values[recorded[name]].as_slice(), 1e3 * slope * factor(name)))
                .collect();
            column.extend(
                (0..curve.time_s.len()).map(|i| terms.iter().map(|(d, slope)| slope * d[i]).sum::<f64>()),
            );
        }
        column
    }

    /// Column of a variable from runs at a shifted point (mN).
    fn difference_column(
        &self,
        x: &[f64],
        r: &[f64],
        j: usize,
        (shift, runs): &(f64, Vec<Run>),
    ) -> Result<Vec<f64>, EvaluationFailure> {
        let (shift, shifted) = match self.difference_mn(runs) {
            // The model may fail on one side only.
            Err(EvaluationFailure::Failed(_)) => {
                let (shift, runs) = self.shifted(x, j, Some(-shift));
                (shift, self.difference_mn(&runs)?)
            }
            other => (*shift, other?),
        };
        Ok(shifted.iter().zip(r).map(|(a, b)| (a - b) / shift).collect())
    }

    fn count(&mut self, result: Result<Vec<f64>, EvaluationFailure>) -> Result<Vec<f64>, EvaluationFailure> {
        self.failed += u64::from(matches!(result, Err(EvaluationFailure::Failed(_))));
        result
    }
}

impl Problem for ForceProblem<'_> {
    fn dimension(&self) -> usize {
        self.setup.unknowns.len() + self.active.len()
    }

    fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
        // While starts are screened, their Jacobians are not wanted.
        if let Some(i) = self.screened.iter().position(|(p, _)| p == x) {
            let (_, runs) = self.screened.swap_remove(i);
            let result = self.difference_mn(&runs);
            return self.count(result);
        }
        let trial = match self.trial.take() {
            Some(trial) if trial.x == x => trial,
            _ => self.begin(x, !self.was_taken),
        };
        self.was_taken = false;
        let result = self.difference_mn(trial.swift.as_ref().unwrap_or(&trial.runs));
        // A point that failed needs no Jacobian: dropping its columns cancels them.
        self.trial = result.is_ok().then_some(trial);
        self.count(result)
    }

    fn jacobian(&mut self, x: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
        let trial = match self.trial.take() {
            Some(trial) if trial.x == x => trial,
            _ => self.begin(x, false),
        };
        let of_others = self.slopes.contains(&Slope::OfTheOthers);
        let others = of_others.then(|| {
            let (parameters, active) = self.differentiable(x);
            self.setup.submit(parameters, &active, true, Priority::Urgent)
        });
        let curves: Curves = match (&others, self.slopes.contains(&Slope::Exact)) {
            (Some(runs), _) => runs.iter().map(wait).collect::<Result<_, _>>()?,
            (None, true) => trial.runs.iter().map(wait).collect::<Result<_, _>>()?,
            (None, false) => vec![],
        };
        let mut jacobian = DMatrix::zeros(r.len(), x.len());
        for j in 0..x.len() {
            let column = match &trial.shifted[j] {
                Some(shifted) => self.difference_column(x, r, j, shifted)?,
                None => self.exact_column(x, &curves, j),
            };
            jacobian.column_mut(j).copy_from_slice(&column);
        }
        if of_others {
            let with: Vec<f64> = r.iter().zip(self.setup.measured_mn()).map(|(r, m)| r + m).collect();
            let exact = self.slopes.iter().position(|s| *s == Slope::Difference).unwrap_or(x.len());
            scale_rows(&mut jacobian.columns_mut(0, exact), &with, &curves);
        }
        self.load.add(trial.load.close(self.setup.engine.pool()));
        self.was_taken = true;
        Ok(jacobian)
    }

    fn prefetch(&mut self, points: &[Vec<f64>]) {
        // One point is a trial: `residual` starts it together with its Jacobian.
        if points.len() > 1 {
            let submit = |p: &Vec<f64>| (p.clone(), self.submit(p, false, Priority::Speculative));
            self.screened = points.iter().map(submit).collect();
        }
    }

    fn rejected(&mut self, _x: &[f64]) {
        self.trial = None;
    }
}

/// Multiplies the slopes of the force (mN) of runs without an effect by what it multiplies their force by; `with_mn` is the force with it.
fn scale_rows(slopes: &mut DMatrixViewMut<f64>, with_mn: &[f64], without: &Curves) {
    let without_mn = without.iter().flat_map(|c| c.force_n()).map(|f| 1e3 * f);
    for (i, (with, without)) in with_mn.iter().zip(without_mn).enumerate() {
        slopes.row_mut(i).scale_mut(factor(*with, without));
    }
}

/// What an effect multiplies a force by: nothing beyond reason, off contact least of all.
fn factor(with_mn: f64, without_mn: f64) -> f64 {
    if without_mn.abs() > NO_FORCE_MN { (with_mn / without_mn).clamp(0.1, 10.0) } else { 1.0 }
}
