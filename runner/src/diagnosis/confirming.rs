//! Refits of the model with effects, and their evidence against each other, no gap, and something else.

use super::location::spots;
use super::screening::Family;
use super::search::Search;
use super::something_else::{SomethingElse, something_else};
use super::thresholds::Thresholds;
use crate::fit::IterationRecord;
use crate::inference::Setup;
use crate::inference::effect::Candidate;
use crate::inference::fit::{Depth, Fit, FitFailure, FitPlan, fit};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// A model with one or more effects, refitted.
#[derive(Debug, Clone)]
pub struct Refit {
    /// Indices of its candidates.
    pub members: Vec<usize>,
    /// Candidates that would do as well in the place of a pair's second, by their signatures, best first.
    pub alternatives: Vec<usize>,
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
    /// Whether the rest is so small a part of the gap that it may be a matter of the effect's form.
    pub leaves_little: bool,
}

impl Refit {
    /// Its effects.
    pub fn active<'a>(&self, candidates: &'a [Candidate]) -> Vec<&'a Candidate> {
        self.members.iter().map(|k| &candidates[*k]).collect()
    }

    /// Whether noise alone leaves such a rest with more than this probability.
    pub fn leaves_noise(&self, significant: f64) -> bool {
        self.adequacy > significant
    }

    /// Whether it leaves noise or what may be a matter of the effect's form.
    pub fn meets_data(&self, thresholds: &Thresholds) -> bool {
        self.adequacy > thresholds.inadequate || self.leaves_little
    }

    /// The same beside another fit of the plain model than `before`.
    #[must_use]
    pub fn beside(self, before: &Fit, (plain, gap): (&Fit, &SomethingElse), rest: f64) -> Self {
        Self {
            evidence: self.evidence + before.evidence(&[]) - plain.evidence(&[]),
            gain: plain.solution.chi_square - self.fit.misfit(),
            leaves_little: leaves_little(&self.fit, &self.remainder, (plain, gap), rest),
            ..self
        }
    }
}

/// Whether a refit leaves so small a part of the gap that it may be a matter of the effect's form.
fn leaves_little(fit: &Fit, remainder: &SomethingElse, whole: (&Fit, &SomethingElse), rest: f64) -> bool {
    let most = most_left(whole, rest);
    [remainder.explained, excess(fit)].iter().all(|left| *left < most)
}

/// Most of chi^2 that may be a matter of the effect's form. Of a gap with kinks, as a lag leaves it, a smooth error explains little: the
/// larger measure is the gap.
pub fn most_left((plain, gap): (&Fit, &SomethingElse), rest: f64) -> f64 {
    rest * rest * gap.explained.max(excess(plain))
}

/// Refits with the candidates `members` from `start`, parameters and magnitudes.
///
/// # Errors
/// When the model fails with these effects, or the user asked to stop.
pub fn refit(
    search: &Search,
    members: &[usize],
    start: Vec<f64>,
    depth: Depth,
    observe: &mut dyn FnMut(&IterationRecord),
) -> Result<Refit, FitFailure> {
    let &Search { setup, plain, gap, covariance, evaluations, thresholds, .. } = search;
    let active = search.active(members);
    let plan = FitPlan { start, evaluations, depth };
    let found = fit(setup, &active, covariance, &plan, observe)?;
    let remainder = something_else(setup.observations, &found.linear, &found.covariance);
    Ok(Refit {
        members: members.to_vec(),
        alternatives: vec![],
        evidence: found.evidence(&active) - plain.evidence(&[]),
        gain: plain.solution.chi_square - found.misfit(),
        leaves_little: leaves_little(&found, &remainder, (plain, gap), thresholds.rest),
        remainder,
        adequacy: adequacy(setup, &found),
        fit: found,
    })
}

/// Probability under noise of the worst misfit of any phase or time scale, or of the whole chi^2: the smaller of both, family-wise.
pub fn adequacy(setup: Setup, fit: &Fit) -> f64 {
    let spots = spots(setup.observations, &fit.linear, &fit.covariance);
    let signatures: Vec<_> = spots.iter().map(|s| &s.signature).collect();
    let worst = signatures.iter().map(|s| s.score(&fit.linear.residual).abs()).fold(0.0, f64::max);
    let local = Family::new(&signatures, &vec![false; signatures.len()], 3).probability(worst);
    (2.0 * local.min(whole(fit))).min(1.0)
}

/// Probability under noise of so large a chi^2: of as many degrees of freedom as points, since variables have as many rows of
/// prior knowledge.
pub fn whole(fit: &Fit) -> f64 {
    // A distribution of at least one degree of freedom exists.
    ChiSquared::new(fit.gap_mn.len() as f64).map_or(1.0, |d| d.sf(fit.solution.chi_square))
}

/// chi^2 beyond what noise gives.
pub fn excess(fit: &Fit) -> f64 {
    (fit.solution.chi_square - fit.gap_mn.len() as f64).max(0.0)
}
