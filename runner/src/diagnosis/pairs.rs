//! The best effect together with a second one, which its rest shows, and that one with a better first.

use super::confirming::{Refit, adequacy};
use super::diagnose::DiagnosisError;
use super::looks::QUICK_ALIKE;
use super::promise::{PROMISING, Promise};
use super::screening::{Screened, Screening};
use super::search::{Search, keep_better};
use super::thresholds::Thresholds;
use crate::fit::EvaluationFailure;
use crate::inference::Signature;
use crate::inference::fit::Fit;

/// Second effects of different looks that are refitted with the best one.
const QUICK_PARTNERS: usize = 2;
const PARTNERS: usize = 4;

/// Second effects that look the same in the rest of the first, the most promising one first.
type Look = Vec<Promise>;

impl Search<'_> {
    /// A single effect together with what its rest shows, where this is more than noise: with what promises most there, and the best of
    /// these pairs.
    pub(super) fn pair(
        &self,
        single: &Refit,
        shown: &[&Screened],
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        let mut pairs = vec![];
        for look in self.looks_of_rest(single, shown)? {
            pairs.extend(self.pair_with_one_of(single, &look, say)?);
        }
        Ok(pairs.into_iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence)))
    }

    /// A single effect with the first of a look, and with those that look like it until one meets the data: a promise is linear. With it the
    /// others that promise as much and were not refuted.
    fn pair_with_one_of(
        &self,
        single: &Refit,
        look: &[Promise],
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        let before = &single.fit.solution;
        let mut tried: Vec<Refit> = vec![];
        let most = if self.quick { 1 + QUICK_ALIKE } else { look.len() };
        for promise in look.iter().take(most) {
            let start = self.joined((&before.x, &single.members), promise, before.chi_square)?;
            let members = [single.members[0], promise.candidate];
            tried.extend(self.refit(&members, start, self.where_it_may_be_an_answer(), say)?);
            if tried.iter().any(|pair| pair.adequacy > self.thresholds.inadequate) {
                break;
            }
        }
        tried.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        // One that was not carried on may end above the single effect that it contains.
        let Some(best) = tried.first().filter(|best| best.gain > single.gain).cloned() else {
            return Ok(None);
        };
        let promised = look.iter().filter(|p| look[0].gain - p.gain < self.thresholds.decisive);
        let not_refuted = |k: &usize| match tried.iter().find(|pair| pair.members[1] == *k) {
            Some(pair) => best.evidence - pair.evidence < self.thresholds.decisive,
            None => true,
        };
        let others = promised.map(|p| p.candidate).filter(|k| *k != best.members[1]);
        let alternatives = others.filter(not_refuted).collect();
        Ok(Some(Refit { alternatives, ..best }))
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
        let Some(second) =
            self.alone(&pair, 1, say)?.filter(|second| !self.is_a_matter_of_form(second, shown))
        else {
            return Ok(pair);
        };
        let Some(other) = self.pair(&second, shown, say)? else { return Ok(pair) };
        Ok(better_of(pair, other, &self.thresholds))
    }

    /// Each of a pair alone has to be fitted as well as the pair is: from where that ended, too.
    pub(super) fn each_alone(
        &self,
        pair: &Refit,
        refits: &mut Vec<Refit>,
        say: &mut dyn FnMut(String),
    ) -> Result<(), DiagnosisError> {
        for k in 0..pair.members.len() {
            self.alone(pair, k, say)?.into_iter().for_each(|alone| keep_better(refits, alone));
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
        self.refit_single(pair.members[k], start, say)
    }

    /// Whether a single effect explains the data and leaves nothing but noise beside what its form may leave: then there is no second one.
    pub(super) fn is_a_matter_of_form(&self, single: &Refit, shown: &[&Screened]) -> bool {
        let rest = Some(single).filter(|r| r.meets_data(&self.thresholds));
        let rest = rest.and_then(|single| self.beside_form(single, shown));
        rest.is_some_and(|(rest, _)| adequacy(self.setup, &rest) > self.thresholds.significant)
    }

    /// A fit with a single effect beside errors of the effect's form, and its magnitude.
    fn beside_form(&self, single: &Refit, shown: &[&Screened]) -> Option<(Fit, f64)> {
        let (fit, first) = (&single.fit, single.members[0]);
        let alone = shown.iter().find(|s| s.candidate == first)?;
        // A switch has no magnitude that was fitted.
        let (magnitude, change_mn) = match fit.magnitudes() {
            [] => (1.0, alone.change_mn.clone()),
            [magnitude, ..] => (*magnitude, fit.jacobian_mn.column(fit.parameters) * *magnitude),
        };
        let effect = &self.candidates[first].effect;
        let forms = effect.errors_of_form(self.setup.observations, &change_mn, self.thresholds.form);
        Some((fit.beside(forms), magnitude))
    }

    /// What the rest of a single effect shows best, beyond what the effect's form may leave.
    fn looks_of_rest(&self, single: &Refit, shown: &[&Screened]) -> Result<Vec<Look>, EvaluationFailure> {
        let first = single.members[0];
        let Some((rest, magnitude)) = self.beside_form(single, shown) else { return Ok(vec![]) };
        let Fit { linear, covariance, .. } = &rest;
        let family = |k: usize| &self.candidates[k].effect.family;
        let others = shown.iter().filter(|s| family(s.candidate) != family(first));
        let screening = Screening {
            setup: self.setup,
            candidates: self.candidates,
            x: rest.x(),
            present: &[(&self.candidates[first], magnitude)],
            fit: linear,
            whitening: covariance,
        };
        let (screened, _) = screening.screen(others.map(|s| s.candidate))?;
        let mut in_rest: Vec<_> = screened
            .iter()
            .map(|s| (self.promise(s, linear, covariance), &s.signature))
            .filter(|(promise, _)| promise.evidence > self.thresholds.second)
            .collect();
        in_rest.sort_by(|(a, _), (b, _)| b.evidence.total_cmp(&a.evidence));
        let least = PROMISING * in_rest.first().map_or(0.0, |(best, _)| best.gain);
        let most = if self.quick { QUICK_PARTNERS } else { PARTNERS };
        let mut found: Vec<(Look, &Signature)> = vec![];
        for (promise, signature) in in_rest {
            match found.iter().position(|(_, first)| first.looks_like(signature)) {
                Some(k) => found[k].0.push(promise),
                None if found.len() < most && promise.gain >= least => found.push((vec![promise], signature)),
                None => {}
            }
        }
        Ok(found.into_iter().map(|(look, _)| look).collect())
    }
}

/// The better of two pairs, of which `other` begins with the second effect of `pair`. Where data cannot tell them apart, what differs is in
/// doubt and what they share is first.
fn better_of(pair: Refit, other: Refit, thresholds: &Thresholds) -> Refit {
    if other.members.iter().all(|k| pair.members.contains(k)) {
        return if other.alternatives.len() > pair.alternatives.len() { other } else { pair };
    }
    let lead = pair.evidence - other.evidence;
    let is_near = lead.abs() < thresholds.decisive && other.meets_data(thresholds);
    if lead >= 0.0 && !(is_near && pair.alternatives.is_empty()) {
        return pair;
    }
    if !is_near {
        return other;
    }
    let alternatives = [pair.members[0]].into_iter().chain(other.alternatives).collect();
    Refit { alternatives, ..other }
}

#[cfg(test)]
mod tests {
    use super::super::verdict_tests::refit;
    use super::*;

    fn pair(members: [usize; 2], evidence: f64) -> Refit {
        Refit { members: members.to_vec(), ..refit(members[0], evidence) }
    }

    /// Members and what may stand in the place of the second.
    fn better(one: Refit, other: Refit) -> (Vec<usize>, Vec<usize>) {
        let found = better_of(one, other, &Thresholds::default());
        (found.members, found.alternatives)
    }

    #[test]
    fn of_pairs_that_data_cannot_tell_apart_the_common_effect_is_first() {
        assert_eq!(better(pair([1, 2], 50.0), pair([2, 3], 48.0)), (vec![2, 3], vec![1]));
        assert_eq!(better(pair([1, 2], 48.0), pair([2, 3], 50.0)), (vec![2, 3], vec![1]));
        assert_eq!(better(pair([1, 2], 50.0), pair([2, 3], 20.0)), (vec![1, 2], vec![]));
        assert_eq!(better(pair([1, 2], 20.0), pair([2, 3], 50.0)), (vec![2, 3], vec![]));
        let poor = Refit { adequacy: 1e-6, leaves_little: false, ..pair([2, 3], 48.0) };
        assert_eq!(better(pair([1, 2], 50.0), poor), (vec![1, 2], vec![]));
    }
}
