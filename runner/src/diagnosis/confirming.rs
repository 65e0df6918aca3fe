//! Refits of the model with effects, and their evidence against each other, no gap, and something else.

use super::diagnose::DiagnosisError;
use super::location::spots;
use super::screening::Family;
use super::search::Search;
use super::something_else::{SomethingElse, something_else};
use super::thresholds::Thresholds;
use super::unsure_noise::UnsureNoise;
use crate::fit::IterationRecord;
use crate::inference::Setup;
use crate::inference::effect::{Candidate, is_continuous};
use crate::inference::fit::{Depth, Fit, FitFailure, FitPlan, fit};
use nalgebra::DVector;
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
    /// Part of the gap that may be a matter of its effects' form.
    pub may_leave: f64,
    /// Whether it leaves less.
    pub leaves_little: bool,
}

impl Refit {
    /// Its effects.
    pub fn active<'a>(&self, candidates: &'a [Candidate]) -> Vec<&'a Candidate> {
        self.members.iter().map(|k| &candidates[*k]).collect()
    }

    /// Its effects' magnitudes; that of a switch is 1.
    pub fn sizes(&self, candidates: &[Candidate]) -> Vec<f64> {
        let mut magnitudes = self.fit.magnitudes().iter();
        let size = |c: &Candidate| if is_continuous(c) { magnitudes.next().copied() } else { None };
        self.active(candidates).into_iter().map(size).map(|size| size.unwrap_or(1.0)).collect()
    }

    /// What each of its effects does to the force around its end (mN, all points); none of a switch.
    pub fn changes_mn(&self, candidates: &[Candidate]) -> Vec<Option<DVector<f64>>> {
        let fit = &self.fit;
        let columns = fit.jacobian_mn.columns_range(fit.parameters..);
        let mut sized = columns.column_iter().zip(fit.magnitudes()).map(|(column, size)| column * *size);
        let change = |c: &Candidate| if is_continuous(c) { sized.next() } else { None };
        self.active(candidates).into_iter().map(change).collect()
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
    pub fn beside(self, before: &Fit, (plain, gap): (&Fit, &SomethingElse)) -> Self {
        Self {
            evidence: self.evidence + evidence(before, &[]) - evidence(plain, &[]),
            gain: plain.solution.chi_square - self.fit.misfit(),
            leaves_little: leaves_little(&self.fit, &self.remainder, (plain, gap), self.may_leave),
            ..self
        }
    }
}

/// Whether a refit leaves less than a part of the gap, which may be a matter of the effects' form.
fn leaves_little(
    fit: &Fit,
    remainder: &SomethingElse,
    whole: (&Fit, &SomethingElse),
    may_leave: f64,
) -> bool {
    let most = most_left(whole, may_leave);
    [remainder.explained, excess(fit)].iter().all(|left| *left < most)
}

/// chi^2 of this part of the gap, in units of the noise. Of a gap with kinks, as a lag leaves it, a smooth error explains little: the larger
/// measure is the gap.
pub fn most_left((plain, gap): (&Fit, &SomethingElse), part: f64) -> f64 {
    part * part * gap.explained.max(excess(plain))
}

/// Part of the gap that these effects may leave, as nature has other forms of them, where one law may leave `rest`. What is a number has no
/// other form; what it leaves may be a second effect too small to be told. Two effects come near to much that neither of them is: together
/// they may leave half of chi^2 that one may.
fn may_leave(effects: &[&Candidate], rest: f64) -> f64 {
    let form = if effects.iter().all(|c| c.effect.is_a_number) { 0.5 * rest } else { rest };
    form / (effects.len() as f64).sqrt()
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
    let &Search { setup, plain, gap, covariance, evaluations, trust, thresholds, .. } = search;
    let active = search.active(members);
    let may_leave = may_leave(&active, thresholds.rest);
    let plan = FitPlan { start, evaluations, depth, trust };
    let found = fit(setup, &active, covariance, &plan, observe)?;
    let remainder = something_else(setup.observations, &found.linear, &found.covariance);
    Ok(Refit {
        members: members.to_vec(),
        alternatives: vec![],
        evidence: evidence(&found, &active) - evidence(plain, &[]),
        gain: plain.solution.chi_square - found.misfit(),
        leaves_little: leaves_little(&found, &remainder, (plain, gap), may_leave),
        may_leave,
        remainder,
        adequacy: adequacy(setup, &found),
        fit: found,
    })
}

impl Search<'_> {
    /// What may be the answer, carried to its minimum by this model after another one has found it: what is as good as the best that meets
    /// the data, by evidence or by chi^2. What this model cannot compute is left out. Best first.
    pub(super) fn confirmed(
        &self,
        mut found: Vec<Refit>,
        say: &mut dyn FnMut(String),
    ) -> Result<Vec<Refit>, DiagnosisError> {
        let mut confirmed: Vec<Refit> = vec![];
        let by_evidence = |a: &&Refit, b: &&Refit| a.evidence.total_cmp(&b.evidence);
        loop {
            let all = || confirmed.iter().chain(&found);
            let meeting = all().filter(|refit| refit.meets_data(&self.thresholds)).max_by(by_evidence);
            let Some(best) = meeting.or_else(|| all().max_by(by_evidence)) else { break };
            let is_as_good = |refit: &Refit| {
                (refit.evidence - best.evidence).max(refit.gain - best.gain) > -self.thresholds.decisive
            };
            let Some(next) = found.iter().position(is_as_good) else { break };
            let Refit { members, alternatives, fit, .. } = found.remove(next);
            let refit = self.refit(&members, fit.solution.x, Depth::Minimum, say)?;
            confirmed.extend(refit.map(|refit| Refit { alternatives, ..refit }));
        }
        confirmed.extend(found);
        confirmed.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        Ok(confirmed)
    }
}

/// Twice the log evidence of a model, up to what all models of these data share, where the noise has parts of unsure size.
pub fn evidence(fit: &Fit, active: &[&Candidate]) -> f64 {
    fit.evidence(active) + UnsureNoise::of(fit).excuse(&fit.linear.residual)
}

/// Probability under noise of the worst misfit of any phase or time scale, or of the whole chi^2: the smaller of both, family-wise.
pub fn adequacy(setup: Setup, fit: &Fit) -> f64 {
    let spots = spots(setup.observations, &fit.linear, &fit.covariance);
    let signatures: Vec<_> = spots.iter().map(|s| &s.signature).collect();
    let worst = signatures.iter().map(|s| s.score(&fit.linear.residual).abs()).fold(0.0, f64::max);
    let local =
        Family::new(&signatures, &vec![false; signatures.len()], &UnsureNoise::of(fit), 3).probability(worst);
    (2.0 * local.min(whole(fit))).min(1.0)
}

/// Probability under noise of so large a chi^2: of as many degrees of freedom as points, since variables have as many rows of
/// prior knowledge.
pub fn whole(fit: &Fit) -> f64 {
    probability_of_more(fit.gap_mn.len(), fit.solution.chi_square)
}

/// The same of this chi^2 of so many points.
pub fn probability_of_more(points: usize, chi_square: f64) -> f64 {
    // A distribution of at least one degree of freedom exists.
    ChiSquared::new(points as f64).map_or(1.0, |d| d.sf(chi_square))
}

/// chi^2 beyond what noise gives.
pub fn excess(fit: &Fit) -> f64 {
    (fit.solution.chi_square - fit.gap_mn.len() as f64).max(0.0)
}
