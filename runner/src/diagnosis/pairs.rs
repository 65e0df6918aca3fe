//! The best effect together with a second one, which its rest shows, and that one with a better first.

use super::confirming::{Refit, excess, probability_of_more};
use super::diagnose::DiagnosisError;
use super::looks::QUICK_ALIKE;
use super::promise::{OUTDONE, PROMISING, Promise};
use super::screening::Screening;
use super::search::{Search, keep_better};
use super::thresholds::Thresholds;
use crate::fit::EvaluationFailure;
use crate::inference::Signature;
use crate::inference::fit::{Depth, End, Fit};

/// Second effects of different looks that are refitted with the best one.
const QUICK_PARTNERS: usize = 2;
const PARTNERS: usize = 4;

/// So many single effects are tried as the first of a pair until one of the pairs meets the data.
const QUICK_FIRSTS: usize = 3;
const FIRSTS: usize = 5;

/// Second effects that look the same in the rest of the first, the most promising one first.
type Look = Vec<Promise>;

impl Search<'_> {
    /// Pairs that are better explanations than every single effect, until one leaves noise.
    pub(super) fn find_pairs(
        &self,
        singles: &mut Vec<Refit>,
        pairs: &mut Vec<Refit>,
        say: &mut dyn FnMut(String),
    ) -> Result<(), DiagnosisError> {
        // Nothing is missing beside what leaves noise.
        if singles.first().is_none_or(|best| best.leaves_noise(self.thresholds.significant)) {
            return Ok(());
        }
        for first in self.firsts(singles) {
            if self.any_leaves_noise(pairs) {
                return Ok(());
            }
            let is_paired = pairs.iter().any(|pair| pair.members.contains(&first));
            let Some(k) = singles.iter().position(|r| r.members == [first] && !is_paired) else { continue };
            if let Some(carried_on) = self.by_model_asked_for(&singles[k], say)? {
                singles[k] = carried_on;
            }
            let single = &singles[k];
            // What needs no second effect is a better explanation than others that do.
            let mut is_the_last = self.is_a_matter_of_form(single);
            if let Some(pair) = self.pair(single, is_the_last, say)? {
                let pair = self.with_another_first(pair, single.evidence, say)?;
                is_the_last |= self.add_needed(pair, singles, pairs, say)?;
            }
            if is_the_last {
                return Ok(());
            }
        }
        if !self.any_leaves_noise(pairs)
            && let Some(pair) = self.pair_of_best(singles, say)?
        {
            self.add_needed(pair, singles, pairs, say)?;
        }
        Ok(())
    }

    fn any_leaves_noise(&self, pairs: &[Refit]) -> bool {
        pairs.iter().any(|pair| pair.leaves_noise(self.thresholds.inadequate))
    }

    /// Adds a pair where both of its effects are needed; says whether one of them alone may leave all of the rest.
    fn add_needed(
        &self,
        pair: Refit,
        singles: &mut Vec<Refit>,
        pairs: &mut Vec<Refit>,
        say: &mut dyn FnMut(String),
    ) -> Result<bool, DiagnosisError> {
        self.each_alone(&pair, singles, say)?;
        let is_member = |single: &&Refit| pair.members.contains(&single.members[0]);
        let is_a_matter_of_form =
            singles.iter().filter(is_member).any(|single| self.is_a_matter_of_form(single));
        if self.is_needed(&pair, singles, is_a_matter_of_form) {
            keep_pair(pairs, pair, self.thresholds.decisive);
        }
        Ok(is_a_matter_of_form)
    }

    /// Single effects that may be the first of a pair: the best, and those that gain nearly as much, as one of them may imitate two others.
    fn firsts(&self, singles: &[Refit]) -> Vec<usize> {
        let most = if self.quick { QUICK_FIRSTS } else { FIRSTS };
        let least = PROMISING * singles.first().map_or(0.0, |best| best.gain);
        singles.iter().filter(|r| r.gain >= least).map(|r| r.members[0]).take(most).collect()
    }

    /// A single effect whose rest is screened, carried on by the model asked for; none where that made its end already, or cannot.
    fn by_model_asked_for(
        &self,
        single: &Refit,
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        if single.fit.end != End::RougherModel {
            return Ok(None);
        }
        self.refit(&single.members, single.fit.solution.x.clone(), Depth::Rough, say)
    }

    /// A single effect together with what its rest shows, where this is more than noise: with what promises most there, with what promises
    /// less while none of these leaves noise, and the best of these pairs.
    fn pair(
        &self,
        single: &Refit,
        is_a_matter_of_form: bool,
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        let mut pairs = vec![];
        let looks = self.looks_of_rest(single, is_a_matter_of_form)?;
        let least = PROMISING * looks.first().map_or(0.0, |look| look[0].gain);
        for look in looks {
            if look[0].gain < least && self.any_leaves_noise(&pairs) {
                continue;
            }
            pairs.extend(self.pair_with_one_of(single, &look, say)?);
        }
        Ok(pairs.into_iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence)))
    }

    /// The single effect that explains most together with the next one of another look, whatever the first one's rest promises of it: a
    /// promise is linear.
    fn pair_of_best(
        &self,
        singles: &[Refit],
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        let by_gain = |a: &&Refit, b: &&Refit| a.gain.total_cmp(&b.gain);
        let family = |refit: &Refit| &self.candidates[refit.members[0]].effect.family;
        let Some(first) = singles.iter().max_by(by_gain) else { return Ok(None) };
        let is_another = |other: &&Refit| {
            family(other) != family(first) && !self.look_alike(other.members[0], first.members[0])
        };
        let others = singles.iter().filter(is_another);
        let Some(second) = others.max_by(by_gain) else { return Ok(None) };
        let sized = [first, second].map(|single| (single.members[0], single.sizes(self.candidates)[0]));
        let start = self.start(first.fit.x(), &sized)?;
        let pair = self.refit(&sized.map(|(k, _)| k), start, self.where_it_may_be_an_answer(), say)?;
        Ok(pair.filter(|pair| pair.gain > first.gain))
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
            if self.any_leaves_noise(&tried) {
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
    fn with_another_first(
        &self,
        pair: Refit,
        single: f64,
        say: &mut dyn FnMut(String),
    ) -> Result<Refit, DiagnosisError> {
        if pair.evidence - self.thresholds.complexity <= single {
            return Ok(pair);
        }
        let Some(second) = self.alone(&pair, 1, say)? else { return Ok(pair) };
        let second = self.by_model_asked_for(&second, say)?.unwrap_or(second);
        if self.is_a_matter_of_form(&second) {
            return Ok(pair);
        }
        let Some(other) = self.pair(&second, false, say)? else { return Ok(pair) };
        Ok(better_of(pair, other, &self.thresholds))
    }

    /// Each of a pair alone has to be fitted as well as the pair is: from where that ended, too.
    fn each_alone(
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
        let start = self.start(pair.fit.x(), &[(pair.members[k], pair.sizes(self.candidates)[k])])?;
        self.refit_single(pair.members[k], start, say)
    }

    /// What the rest of a single effect shows best, beyond what the effect's form may leave; where that may leave all of the rest, what
    /// promises most of it, or to leave noise, without errors of form.
    fn looks_of_rest(
        &self,
        single: &Refit,
        is_a_matter_of_form: bool,
    ) -> Result<Vec<Look>, EvaluationFailure> {
        let first = single.members[0];
        let beside_forms = if is_a_matter_of_form { None } else { self.beside_forms(single) };
        let Fit { linear, covariance, .. } = beside_forms.as_ref().unwrap_or(&single.fit);
        let family = |k: usize| &self.candidates[k].effect.family;
        let others = self.shown.iter().filter(|s| family(s.candidate) != family(first));
        let screening = Screening {
            setup: self.setup,
            candidates: self.candidates,
            x: single.fit.x(),
            present: &[(&self.candidates[first], single.sizes(self.candidates)[0])],
            fit: linear,
            whitening: covariance,
        };
        let (screened, _) = screening.screen(others.map(|s| s.candidate))?;
        let (points, chi_square) = (single.fit.gap_mn.len(), single.fit.solution.chi_square);
        let most_of_rest = PROMISING * excess(&single.fit);
        let promises_enough = |p: &Promise| {
            let left = probability_of_more(points, chi_square - p.gain);
            p.gain >= most_of_rest || left > self.thresholds.inadequate
        };
        let mut in_rest: Vec<_> = screened
            .iter()
            .map(|s| (self.promise(s, linear, covariance), &s.signature))
            .filter(|(promise, _)| promise.evidence > self.thresholds.second)
            .filter(|(promise, _)| !is_a_matter_of_form || promises_enough(promise))
            .collect();
        in_rest.sort_by(|(a, _), (b, _)| b.evidence.total_cmp(&a.evidence));
        let least = OUTDONE * in_rest.first().map_or(0.0, |(best, _)| best.gain);
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

/// Adds a pair. Two firsts may lead to the same one: a fit that knows nothing of what may stand in the place of its second has to be decidedly
/// more likely than one that does.
fn keep_pair(pairs: &mut Vec<Refit>, pair: Refit, decisive: f64) {
    let is_same = |other: &&mut Refit| pair.members.iter().all(|k| other.members.contains(k));
    let lead = if pair.alternatives.is_empty() { decisive } else { 0.0 };
    match pairs.iter_mut().find(is_same) {
        Some(before) if before.evidence + lead < pair.evidence => *before = pair,
        Some(_) => {}
        None => pairs.push(pair),
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

    #[test]
    fn a_pair_that_is_found_again_keeps_what_may_stand_in_its_place() {
        let mut pairs = vec![Refit { alternatives: vec![3], ..pair([1, 2], 50.0) }];
        let mut found = |other: Refit| {
            keep_pair(&mut pairs, other, 6.0);
            (pairs.len(), pairs[0].evidence, pairs[0].alternatives.clone())
        };
        assert_eq!(found(pair([2, 1], 52.0)), (1, 50.0, vec![3]));
        assert_eq!(found(Refit { alternatives: vec![4], ..pair([1, 2], 52.0) }), (1, 52.0, vec![4]));
        assert_eq!(found(pair([2, 1], 60.0)), (1, 60.0, vec![]));
        assert_eq!(found(pair([2, 3], 10.0)).0, 2);
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
