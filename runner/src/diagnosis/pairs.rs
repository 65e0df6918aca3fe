//! The best effect together with a second one, which its rest shows, and that one with a better first.

use super::confirming::Refit;
use super::diagnose::DiagnosisError;
use super::screening::{Screened, Screening};
use super::search::{PROMISING, Promise, Search};
use crate::fit::EvaluationFailure;
use crate::inference::Signature;
use crate::inference::fit::{Depth, linearised};
use crate::noise::form_errors;

/// Second effects of different looks that are refitted with the best one.
const QUICK_PARTNERS: usize = 2;
const PARTNERS: usize = 4;
/// A second effect, and what would do as well in its place.
struct Partner {
    promise: Promise,
    alternatives: Vec<usize>,
}

impl Search<'_> {
    /// A single effect together with what its rest shows, where it shows something: with what promises most there, and the best of these
    /// pairs.
    pub(super) fn pair(
        &self,
        single: &Refit,
        shown: &[&Screened],
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        let mut best: Option<Refit> = None;
        for Partner { promise, alternatives } in self.partners(single, shown)? {
            let before = &single.fit.solution;
            let start = self.joined((&before.x, &single.members), &promise, before.chi_square)?;
            let members = [single.members[0], promise.candidate];
            let pair = self.refit(&members, start, Depth::Minimum, say)?;
            let pair = pair.map(|pair| Refit { alternatives, ..pair });
            best = match (best, pair) {
                (Some(a), Some(b)) => Some(if b.evidence > a.evidence { b } else { a }),
                (a, b) => a.or(b),
            };
        }
        Ok(best)
    }

    /// Where a pair beats the best single effect, its second may have a better partner than that effect, which has imitated both: a pair
    /// that starts from it. Where it is the same pair, others may do as well in the place of the first.
    pub(super) fn with_another_first(
        &self,
        pair: Refit,
        single: f64,
        shown: &[&Screened],
        say: &mut dyn FnMut(String),
    ) -> Result<Refit, DiagnosisError> {
        if pair.evidence - self.thresholds.complexity <= single {
            return Ok(pair);
        }
        let Some(second) = self.alone(&pair, 1, say)? else { return Ok(pair) };
        let is_better = |other: &Refit| {
            let is_same = other.members.iter().all(|k| pair.members.contains(k));
            if is_same {
                other.alternatives.len() > pair.alternatives.len()
            } else {
                other.evidence > pair.evidence
            }
        };
        Ok(self.pair(&second, shown, say)?.filter(is_better).unwrap_or(pair))
    }

    /// Each of a pair alone has to be fitted as well as the pair is: from where that ended, too.
    pub(super) fn each_alone(
        &self,
        pair: &Refit,
        refits: &mut Vec<Refit>,
        say: &mut dyn FnMut(String),
    ) -> Result<(), DiagnosisError> {
        for k in 0..pair.members.len() {
            let Some(alone) = self.alone(pair, k, say)? else { continue };
            match refits.iter_mut().find(|r| r.members == alone.members) {
                Some(before) if before.gain < alone.gain => *before = alone,
                Some(_) => {}
                None => refits.push(alone),
            }
        }
        refits.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        Ok(())
    }

    /// A refit with one of a pair, from where the pair ended.
    fn alone(
        &self,
        pair: &Refit,
        k: usize,
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        let size = pair.fit.magnitudes().get(k).copied().unwrap_or(1.0);
        let start = self.start(pair.fit.x(), &[(pair.members[k], size)])?;
        self.refit(&[pair.members[k]], start, Depth::Competing, say)
    }

    /// What the rest of a single effect shows best, beyond what the effect's form may leave: one of each look.
    fn partners(&self, single: &Refit, shown: &[&Screened]) -> Result<Vec<Partner>, EvaluationFailure> {
        let (fit, first) = (&single.fit, single.members[0]);
        let Some(alone) = shown.iter().find(|s| s.candidate == first) else { return Ok(vec![]) };
        // A switch has no magnitude that was fitted.
        let (magnitude, change_mn) = match fit.magnitudes() {
            [] => (1.0, alone.change_mn.clone()),
            [magnitude, ..] => (*magnitude, fit.jacobian_mn.column(fit.parameters) * *magnitude),
        };
        // What is a number and no law has no other form.
        let form = if self.candidates[first].effect.is_a_number { 0.0 } else { self.thresholds.form };
        let covariance = fit.covariance.with(form_errors(self.setup.observations, &change_mn, form));
        let linear = linearised(&fit.jacobian_mn, &fit.gap_mn, &covariance, &fit.prior, &fit.solution.x);
        let family = |k: usize| &self.candidates[k].effect.family;
        let others = shown.iter().filter(|s| family(s.candidate) != family(first));
        let screening = Screening {
            setup: self.setup,
            candidates: self.candidates,
            x: fit.x(),
            present: &[(&self.candidates[first], magnitude)],
            fit: &linear,
            whitening: &covariance,
        };
        let (screened, _) = screening.screen(others.map(|s| s.candidate))?;
        let mut in_rest: Vec<_> = screened
            .iter()
            .map(|s| (self.promise(s, &linear, &covariance), &s.signature))
            .filter(|(promise, _)| promise.evidence > self.thresholds.second)
            .collect();
        in_rest.sort_by(|(a, _), (b, _)| b.evidence.total_cmp(&a.evidence));
        let least = PROMISING * in_rest.first().map_or(0.0, |(best, _)| best.gain);
        let most = if self.quick { QUICK_PARTNERS } else { PARTNERS };
        let mut found: Vec<(Partner, &Signature)> = vec![];
        for (promise, signature) in in_rest {
            match found.iter().position(|(_, look)| look.looks_like(signature)) {
                Some(k) if found[k].0.promise.gain - promise.gain < self.thresholds.decisive => {
                    found[k].0.alternatives.push(promise.candidate);
                }
                None if found.len() < most && promise.gain >= least => {
                    found.push((Partner { promise, alternatives: vec![] }, signature));
                }
                _ => {}
            }
        }
        Ok(found.into_iter().map(|(partner, _)| partner).collect())
    }
}
