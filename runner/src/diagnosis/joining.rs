//! Where a refit with a further effect begins.

use super::promise::Promise;
use super::search::Search;
use crate::fit::{Bounds, EvaluationFailure, FitError};
use crate::inference::ForceProblem;
use crate::inference::effect::{Candidate, is_continuous};
use crate::inference::fit::chi_squares;
use crate::inference::rough::{Twin, leading_at};

/// An effect whose expected magnitude does harm begins at this part of it, and at this part of that, ...
const GENTLER: f64 = 0.25;
/// so many times.
const GENTLER_TIMES: i32 = 3;
/// Distance of a start from a bound, on which the optimiser could not leave it.
const INSIDE: f64 = 0.02;
/// A logarithm that would leave its bounds by more than this is not where the linear model says.
const BEYOND: f64 = 1.0;

impl Search<'_> {
    /// Effects by their numbers.
    pub(super) fn active(&self, members: &[usize]) -> Vec<&Candidate> {
        members.iter().map(|k| &self.candidates[*k]).collect()
    }

    /// Parameters `x` and magnitudes, inside their bounds.
    pub(super) fn start(&self, x: &[f64], members: &[(usize, f64)]) -> Result<Vec<f64>, EvaluationFailure> {
        let numbers: Vec<usize> = members.iter().map(|(k, _)| *k).collect();
        let magnitudes = members.iter().filter(|(k, _)| is_continuous(&self.candidates[*k])).map(|(_, m)| *m);
        Ok(inside(&self.bounds(&numbers)?, x.iter().copied().chain(magnitudes)))
    }

    /// Parameters and magnitudes with which an effect joins those that are `present` at `x`: as far towards what its signature promises as
    /// meets the data no worse than without it (`before`), since a signature is linear and what it asks for may be far beyond. The others
    /// stay as they are or give way to it, whichever is better: what a refit hides of an effect is often most of it. Where the others would
    /// leave their bounds, which are decades wide, the linear model says nothing, and a model of such values may cost a hundred runs.
    pub(super) fn joined(
        &self,
        (x, present): (&[f64], &[usize]),
        promise: &Promise,
        before: f64,
    ) -> Result<Vec<f64>, EvaluationFailure> {
        let members = [present, &[promise.candidate]].concat();
        let active = self.active(&members);
        let bounds = self.bounds(&members)?;
        let candidate = &self.candidates[promise.candidate];
        // A switch is on, whatever part of it the others give way to.
        let magnitude = is_continuous(candidate).then_some(promise.magnitude);
        let size = |part: f64| {
            magnitude.map_or(part, |m| (part * m).clamp(candidate.range().0, candidate.range().1))
        };
        let given = |give: f64| x.iter().zip(&promise.giving_way).map(move |(x, slope)| x + give * slope);
        let beside = |part: f64, give: f64| inside(&bounds, given(give).chain(magnitude.map(|_| size(part))));
        let twin = match Twin::leading(self.setup, &active) {
            Some(_) => leading_at(self.setup, &self.active(present), x)?,
            None => None,
        };
        let setup = Twin::setup_or(twin.as_ref(), self.setup);
        for times in 0..GENTLER_TIMES {
            let part = GENTLER.powi(times);
            let give_way = Some(size(part)).filter(|give| is_inside(&bounds, given(*give)));
            let points: Vec<Vec<f64>> =
                give_way.into_iter().chain([0.0]).map(|give| beside(part, give)).collect();
            let found = chi_squares(setup, &active, self.covariance, &points)?;
            let computed = found.into_iter().zip(points).filter_map(|(found, point)| Some((found?, point)));
            if let Some((found, point)) = computed.min_by(|a, b| a.0.total_cmp(&b.0))
                && found <= before
            {
                return Ok(point);
            }
        }
        Ok(beside(GENTLER.powi(GENTLER_TIMES), 0.0))
    }

    /// Hardly any of an effect beside the plain fit.
    pub(super) fn hardly_any(&self, promise: &Promise) -> Result<Vec<f64>, EvaluationFailure> {
        let magnitude = GENTLER.powi(GENTLER_TIMES) * promise.magnitude;
        self.start(self.plain.x(), &[(promise.candidate, magnitude)])
    }

    fn bounds(&self, members: &[usize]) -> Result<Bounds, EvaluationFailure> {
        let failed = |e: FitError| EvaluationFailure::Failed(e.to_string());
        ForceProblem::new(self.setup, &self.active(members)).bounds().map_err(failed)
    }
}

/// Whether the first variables are inside their bounds, or nearly so.
fn is_inside(bounds: &Bounds, x: impl Iterator<Item = f64>) -> bool {
    let mut sides = x.zip(bounds.lower().iter().zip(bounds.upper()));
    sides.all(|(x, (low, high))| (low - BEYOND..=high + BEYOND).contains(&x))
}

/// The point inside the bounds that is nearest to `x`.
fn inside(bounds: &Bounds, x: impl Iterator<Item = f64>) -> Vec<f64> {
    let sides = bounds.lower().iter().zip(bounds.upper());
    let one = |(x, (low, high)): (f64, (&f64, &f64))| {
        let distance = INSIDE.min(0.25 * (high - low));
        x.clamp(low + distance, high - distance)
    };
    x.zip(sides).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leaves_its_bounds_by_far_is_not_tried() {
        let bounds = Bounds::new(vec![-1.0, 0.0, 0.0], vec![1.0, 2.0, 1.0]).unwrap();
        let tried = |x: [f64; 2]| is_inside(&bounds, x.into_iter());
        assert!(tried([0.0, 1.0]) && tried([1.0 + 0.9 * BEYOND, 2.0]) && tried([-1.0 - 0.9 * BEYOND, 0.0]));
        assert!(!tried([1.0 + 1.1 * BEYOND, 1.0]) && !tried([0.0, -1.1 * BEYOND]) && !tried([f64::NAN, 1.0]));
    }
}
