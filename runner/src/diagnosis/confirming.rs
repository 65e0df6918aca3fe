//! Refits of the model with effects, and their evidence against each other, no gap, and something else.

use super::baseline::{FINAL, Fit, FitFailure, FitPlan, fit};
use super::covariance::Covariance;
use super::effect::{Candidate, PRIOR_DEVIATION};
use super::location::spots;
use super::problem::{Setup, is_continuous};
use super::screening::{Family, Screened};
use super::something_else::{SomethingElse, something_else};
use crate::fit::IterationRecord;

/// A model with one or more effects, refitted.
#[derive(Debug, Clone)]
pub struct Refit {
    /// Indices of its candidates.
    pub members: Vec<usize>,
    /// The refit.
    pub fit: Fit,
    /// Twice the log evidence against the plain model.
    pub evidence: f64,
    /// chi^2 of the plain model minus this one's.
    pub gain: f64,
    /// What a smooth error still explains.
    pub remainder: SomethingElse,
    /// Family-wise probability that noise alone leaves such a residual.
    pub adequacy: f64,
}

/// Refits with the candidates `members`, starting from the plain fit and expected magnitudes.
///
/// # Errors
/// When the model fails with these effects, or the user asked to stop.
pub fn refit(
    setup: Setup,
    candidates: &[Candidate],
    members: &[(usize, f64)],
    plain: &Fit,
    covariance: &Covariance,
    evaluations: usize,
    observe: &mut dyn FnMut(&IterationRecord),
) -> Result<Refit, FitFailure> {
    let active: Vec<&Candidate> = members.iter().map(|(k, _)| &candidates[*k]).collect();
    // What the plain model made of its parameters to imitate the effect may be far from what they are with it.
    let mut starts = vec![plain.x().to_vec(), setup.parameters.start().to_vec()];
    for ((_, magnitude), candidate) in members.iter().zip(&active) {
        if is_continuous(candidate) {
            let (low, high) = candidate.range();
            // Inside the range: the optimiser cannot leave a bound on which it starts.
            let inside = magnitude.clamp(low + 0.02, high - 0.02);
            starts.iter_mut().for_each(|start| start.push(inside));
        }
    }
    let plan = FitPlan { starts, drawn: 0, evaluations, tolerance: FINAL };
    let found = fit(setup, &active, covariance, &plan, observe)?;
    let evidence = found.evidence(&active) - plain.evidence(&[]);
    let gain = plain.solution.chi_square - found.solution.chi_square;
    let remainder = something_else(setup.observations, &found.linear, &found.covariance);
    let adequacy = adequacy(setup, &found);
    let members = members.iter().map(|(k, _)| *k).collect();
    Ok(Refit { members, fit: found, evidence, gain, remainder, adequacy })
}

/// Family-wise probability of the worst misfit of any phase or time scale under noise.
pub fn adequacy(setup: Setup, fit: &Fit) -> f64 {
    let spots = spots(setup.observations, &fit.linear, &fit.covariance);
    let signatures: Vec<_> = spots.iter().map(|s| &s.signature).collect();
    let worst = signatures.iter().map(|s| s.score(&fit.linear.residual).abs()).fold(0.0, f64::max);
    Family::new(&signatures, &vec![false; signatures.len()], 3).probability(worst)
}

/// Twice the log evidence of two effects against none, both magnitudes normal before, all linear.
pub fn pair_evidence(a: &Screened, b: &Screened, fit: &Fit) -> f64 {
    let (s, t, y) = (&a.signature.s, &b.signature.s, &fit.linear.residual);
    let v = nalgebra::Vector2::new(s.dot(y), t.dot(y));
    let g = nalgebra::Matrix2::new(s.dot(s), s.dot(t), s.dot(t), t.dot(t));
    // In units of the magnitudes' prior deviation.
    let (v, g) = (v * PRIOR_DEVIATION, g * PRIOR_DEVIATION.powi(2));
    let h = g + nalgebra::Matrix2::identity();
    match h.try_inverse() {
        Some(inverse) => v.dot(&(inverse * v)) - h.determinant().ln(),
        None => f64::NEG_INFINITY,
    }
}
