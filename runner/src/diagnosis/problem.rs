//! The model with some effects switched on, as a least-squares problem: parameters and magnitudes -> differences
//! from all tests (mN, model minus measured).

use super::effect::{Candidate, Sign};
use crate::engine::Engine;
use crate::fit::{Bounds, EvaluationFailure, Problem};
use crate::noise::Observation;
use crate::objective::{ParameterMap, wait};
use crate::pool::{ForceCurve, Priority, Run};
use nalgebra::{DMatrix, DMatrixViewMut};
use poropunch::variables::sensitivities;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What every evaluation needs.
#[derive(Clone, Copy)]
pub struct Setup<'a> {
    /// Runs the model.
    pub engine: &'a Engine,
    /// What was measured.
    pub observations: &'a [Observation],
    /// What is fitted besides the effects.
    pub parameters: &'a ParameterMap,
}

/// Curves of all tests.
pub type Curves = Vec<Arc<ForceCurve>>;

impl Setup<'_> {
    /// Values of a test's run, and those before the effects were applied.
    fn values(
        &self,
        x: &[f64],
        active: &[(&Candidate, f64)],
        test: usize,
    ) -> (BTreeMap<String, f64>, BTreeMap<String, f64>) {
        let plain = self.parameters.settings(x);
        let mut values = plain.clone();
        for (candidate, magnitude) in active {
            // An effect on a parameter that nobody set starts from the FMU's own value.
            for name in &candidate.effect.parameters {
                if let Some(value) = self.value(&values, name) {
                    values.insert(name.clone(), value);
                }
            }
            candidate.apply(&mut values, test, *magnitude);
        }
        (values, plain)
    }

    /// Starts the runs of all tests at parameters `x` with effects of given magnitudes.
    pub fn submit(
        &self,
        x: &[f64],
        active: &[(&Candidate, f64)],
        derivatives: bool,
        priority: Priority,
    ) -> Vec<Run> {
        let run = |(test, observation): (usize, &Observation)| {
            let (mut values, _) = self.values(x, active, test);
            if derivatives {
                values.insert(sensitivities::SWITCH.to_owned(), 1.0);
            }
            self.engine.submit(&observation.dataset.job(&values), priority)
        };
        self.observations.iter().enumerate().map(run).collect()
    }

    /// Force of all tests, test by test (mN).
    ///
    /// # Errors
    /// When a run fails.
    pub fn forces_mn(runs: &[Run]) -> Result<Vec<f64>, EvaluationFailure> {
        let curves = runs.iter().map(wait).collect::<Result<Curves, _>>()?;
        Ok(curves.iter().flat_map(|c| c.force_n().iter().map(|f| f * 1e3).collect::<Vec<_>>()).collect())
    }

    /// The same, `None` where the model fails at these parameters.
    ///
    /// # Errors
    /// When the user asked to stop.
    pub fn computable_forces_mn(runs: &[Run]) -> Result<Option<Vec<f64>>, EvaluationFailure> {
        match Self::forces_mn(runs) {
            Ok(forces) => Ok(Some(forces)),
            Err(EvaluationFailure::Failed(_)) => Ok(None),
            Err(EvaluationFailure::Interrupted) => Err(EvaluationFailure::Interrupted),
        }
    }

    /// Value that a parameter has among those that are set: theirs, or the FMU's own.
    pub fn value(&self, values: &BTreeMap<String, f64>, name: &str) -> Option<f64> {
        let start = || self.engine.wiring().parameters.get(name).and_then(|v| v.start_number());
        values.get(name).copied().or_else(start)
    }

    /// Measured force of all tests (mN).
    pub fn measured_mn(&self) -> Vec<f64> {
        self.observations.iter().flat_map(Observation::force_mn).collect()
    }

    /// First point of each test, and the number of points.
    pub fn offsets(&self) -> Vec<usize> {
        let lengths = self.observations.iter().map(Observation::len);
        std::iter::once(0)
            .chain(lengths.scan(0, |sum, n| {
                *sum += n;
                Some(*sum)
            }))
            .collect()
    }
}

/// Parameters, then the magnitudes of the active effects.
pub struct EffectProblem<'a> {
    setup: Setup<'a>,
    /// Effects whose magnitude is a variable.
    active: Vec<&'a Candidate>,
    /// Switches that are on.
    on: Vec<&'a Candidate>,
    slopes: Slopes,
}

/// Where the derivatives by the material parameters come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Slopes {
    /// The runs themselves.
    Exact,
    /// Runs without the effects that allow none, their slopes multiplied by what these effects multiply the force by. Good enough for
    /// Gauss-Newton steps: such an effect (the traction integral) is another read-out of the same solution.
    OfTheOthers,
    /// Shifted runs, for an FMU without derivatives.
    Differences,
}

/// A force of which a factor says nothing (mN).
const NO_FORCE_MN: f64 = 0.01;
/// Step of a magnitude for its derivative, in plausible scales.
const STEP: f64 = 0.05;
/// Step of a log parameter where the FMU offers no derivative.
const PARAMETER_STEP: f64 = 0.01;

impl<'a> EffectProblem<'a> {
    /// With these effects present: their magnitudes free, switches on.
    pub fn new(setup: Setup<'a>, active: &[&'a Candidate]) -> Self {
        let recorded = &setup.engine.wiring().sensitivities;
        let p = setup.parameters;
        let has = |j| p.slopes(p.start(), j).iter().all(|(name, _)| recorded.contains_key(*name));
        let slopes = match (0..p.free().len()).all(has) {
            true if active.iter().all(|c| c.effect.differentiable) => Slopes::Exact,
            true => Slopes::OfTheOthers,
            false => Slopes::Differences,
        };
        let (active, on) = active.iter().copied().partition(|c| is_continuous(c));
        Self { setup, active, on, slopes }
    }

    /// Bounds of parameters and magnitudes.
    ///
    /// # Errors
    /// Never, for effects with a range.
    pub fn bounds(&self) -> Result<Bounds, crate::fit::FitError> {
        let (lower, upper) = self.setup.parameters.bounds();
        let (mut lower, mut upper) = (lower.to_vec(), upper.to_vec());
        for candidate in &self.active {
            let (low, high) = candidate.range();
            lower.push(low);
            upper.push(high);
        }
        Bounds::new(lower, upper)
    }

    fn split<'b>(&self, x: &'b [f64]) -> (&'b [f64], Vec<(&'a Candidate, f64)>) {
        let (parameters, magnitudes) = x.split_at(self.setup.parameters.free().len());
        let free = self.active.iter().copied().zip(magnitudes.iter().copied());
        (parameters, free.chain(self.on.iter().map(|c| (*c, 1.0))).collect())
    }

    fn submit(&self, x: &[f64], derivatives: bool) -> Vec<Run> {
        let (parameters, active) = self.split(x);
        self.setup.submit(parameters, &active, derivatives, Priority::Urgent)
    }

    /// The effects whose runs may have derivatives.
    fn differentiable<'b>(&self, x: &'b [f64]) -> (&'b [f64], Vec<(&'a Candidate, f64)>) {
        let (parameters, mut active) = self.split(x);
        active.retain(|(c, _)| c.effect.differentiable);
        (parameters, active)
    }

    /// Column of a parameter from the derivatives of `curves` (mN).
    fn exact_column(&self, x: &[f64], curves: &Curves, j: usize) -> Vec<f64> {
        let recorded = &self.setup.engine.wiring().sensitivities;
        let (parameters, active) = self.differentiable(x);
        let slopes = self.setup.parameters.slopes(parameters, j);
        let mut column = Vec::new();
        for (test, curve) in curves.iter().enumerate() {
            let (values, plain) = self.setup.values(parameters, &active, test);
            // An effect that multiplies a fitted parameter multiplies its slope too.
            let factor = |name: &str| match (values.get(name), plain.get(name)) {
                (Some(value), Some(before)) if *before != 0.0 => value / before,
                _ => 1.0,
            };
            column.extend((0..curve.time_s.len()).map(|i| {
                let one =
                    |(name, slope): &(&str, f64)| curve.values[recorded[*name]][i] * slope * factor(name);
                1e3 * slopes.iter().map(one).sum::<f64>()
            }));
        }
        column
    }

    /// Runs of a shifted variable, inwards at its upper bound.
    fn shifted(&self, x: &[f64], j: usize) -> (f64, Vec<Run>) {
        let parameters = self.setup.parameters.free().len();
        let (step, upper) = match j.checked_sub(parameters) {
            None => (PARAMETER_STEP, self.setup.parameters.bounds().1[j]),
            Some(k) => (STEP, self.active[k].range().1),
        };
        let shift = if x[j] + step <= upper { step } else { -step };
        let mut y = x.to_vec();
        y[j] += shift;
        (shift, self.submit(&y, false))
    }
}

impl Problem for EffectProblem<'_> {
    fn dimension(&self) -> usize {
        self.setup.parameters.free().len() + self.active.len()
    }

    fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
        let forces = Setup::forces_mn(&self.submit(x, self.slopes == Slopes::Exact))?;
        Ok(forces.iter().zip(self.setup.measured_mn()).map(|(f, m)| f - m).collect())
    }

    fn jacobian(&mut self, x: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
        let n = self.setup.parameters.free().len();
        let differenced = if self.slopes == Slopes::Differences { 0..x.len() } else { n..x.len() };
        let (parameters, active) = self.differentiable(x);
        let exact = differenced.start > 0;
        let runs = exact.then(|| self.setup.submit(parameters, &active, true, Priority::Urgent));
        let shifted: Vec<_> = differenced.clone().map(|j| (j, self.shifted(x, j))).collect();
        let curves = runs.iter().flatten().map(wait).collect::<Result<Curves, _>>()?;
        let mut jacobian = DMatrix::zeros(r.len(), x.len());
        for j in 0..differenced.start {
            jacobian.column_mut(j).copy_from_slice(&self.exact_column(x, &curves, j));
        }
        let measured = self.setup.measured_mn();
        if self.slopes == Slopes::OfTheOthers {
            let with: Vec<f64> = r.iter().zip(&measured).map(|(r, measured)| r + measured).collect();
            scale_rows(&mut jacobian.columns_mut(0, n), &with, &curves);
        }
        for (j, (shift, runs)) in shifted {
            let forces = Setup::forces_mn(&runs)?;
            for (i, force) in forces.iter().enumerate() {
                jacobian[(i, j)] = (force - measured[i] - r[i]) / shift;
            }
        }
        Ok(jacobian)
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

/// Whether an effect has a magnitude between off and on.
pub fn is_continuous(candidate: &Candidate) -> bool {
    candidate.effect.sign != Sign::Switch
}
