//! Which models with effects are refitted.
//!
//! ```text
//! every effect that these data would show, or seem to show (quick: those that promise most), from where it promises more: the plain
//! model's fit or the other starts
//! -> the leaders from the others, too, while the best of them leaves more than noise (quick: as soon as one explains most of the gap)
//! -> where it leaves more than noise, those that promise a small part of what another has gained, at the plain fit where that one leaves
//! noise (all others in full: from the plain fit)
//! -> quick: what looks like the best; what promises half as much at the plain fit, whatever it looks like
//! -> what looks like the best where that ended, from there
//! -> those that compete are carried on to their minima
//! -> while no single one of these leaves noise, as it is or in another form, unless the gap is then told as one that does not matter:
//! quick: all others
//! then: what promises decidedly more than the best gains at the further starts of the plain model, from there, until one needs no other
//! -> the best of them together with what its rest shows, where it shows something, and what that shows with what its own rest shows;
//! the next best, too, until a pair leaves noise; the best with the next best; no pair where a single effect in some form is as likely
//! -> where none explains the gap, what explains nothing from its other starts, and what explains little on its other side
//! ```

use super::confirming::{Refit, excess, most_left, refit};
use super::diagnose::DiagnosisError;
use super::looks::{Alike, QUICK_ALIKE};
use super::promise::{Beginning, Beginnings, OUTDONE, PROMISING};
use super::round::Elsewhere;
use super::screening::Screened;
use super::something_else::SomethingElse;
use super::thresholds::Thresholds;
use crate::fit::{EvaluationFailure, IterationRecord};
use crate::inference::Setup;
use crate::inference::effect::{Candidate, is_continuous};
use crate::inference::fit::{Depth, End, Fit, FitFailure, ROUGH};
use crate::inference::rough::Trust;
use crate::noise::Covariance;
use std::collections::VecDeque;

/// So many times a leader is refitted from another start.
const QUICK_AGAIN: usize = 2;
const AGAIN: usize = 4;
/// So many effects are begun from a further start of the plain model: those that look like a slow branch are three.
const MOST_FURTHER: usize = 3;
/// A rough fit with more than this chi^2 per point misses the data, however it is polished.
const MISSES_DATA: f64 = 1.3;
/// A rough fit that leaves more than so many times what an answer may leave is none, however it is polished.
const NO_ANSWER: f64 = 2.0;
/// The best so far.
fn leader<'a>(found: &'a [(Refit, VecDeque<Beginning>)]) -> Option<&'a Refit> {
    found.iter().map(|(refit, _)| refit).max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// Puts another refit of the same effects in the place of one that gains less.
fn replace_if_better(refit: &mut Refit, other: Option<Refit>) {
    if let Some(other) = other.filter(|other| other.gain > refit.gain) {
        *refit = other;
    }
}

/// Puts a refit in the place of one of the same effects that gains less, or beside those of others.
pub(super) fn keep_better(refits: &mut Vec<Refit>, found: Refit) {
    match refits.iter_mut().find(|r| r.members == found.members) {
        Some(before) if found.gain <= before.gain => {}
        Some(before) => *before = found,
        None => refits.push(found),
    }
}

/// What all refits share.
pub struct Search<'a> {
    /// Engine, measurements, parameters.
    pub setup: Setup<'a>,
    /// The plain model where fits start, besides its fit.
    pub elsewhere: &'a [Elsewhere<'a>],
    /// Further starts of the plain model, which are looked at where nothing explains all of the gap.
    pub further: &'a [Vec<f64>],
    /// What was asked about.
    pub candidates: &'a [Candidate],
    /// Number of effects that they are forms of.
    pub rivals: usize,
    /// What was screened; all of it may stand in for the best.
    pub screened: &'a [Screened],
    /// Those that these data would show, or seem to show.
    pub shown: &'a [&'a Screened],
    /// Fit of the plain model.
    pub plain: &'a Fit,
    /// The smooth part of what it leaves.
    pub gap: &'a SomethingElse,
    /// Noise.
    pub covariance: &'a Covariance,
    /// Largest number of evaluations of a fit.
    pub evaluations: usize,
    /// What a rougher model that leads a rough fit is trusted with.
    pub trust: Trust,
    /// Fewer models.
    pub quick: bool,
    /// Whether a gap that no effect explains is told as one that does not matter.
    pub is_negligible: bool,
    /// What decides.
    pub thresholds: Thresholds,
}

impl Search<'_> {
    /// Refits of the effects that these data would show, or seem to show, best first. A quick one refits the rest only where nothing
    /// explains the gap.
    ///
    /// # Errors
    /// When the user asked to stop.
    pub fn run(&self, say: &mut dyn FnMut(String)) -> Result<Vec<Refit>, DiagnosisError> {
        let mut found: Vec<(Refit, VecDeque<Beginning>)> = Vec::new();
        let (first, mut alike, mut rest) = self.by_looks(self.beginnings());
        let mut outdone = Vec::new();
        for beginnings in first {
            if self.is_outdone(&beginnings, &found) {
                outdone.push(beginnings);
            } else {
                self.begin_look(beginnings, &mut alike, &mut found, say)?;
                // What explains most of the gap may explain all of it from elsewhere: then little else need be tried.
                if self.quick
                    && leader(&found).is_some_and(|best| best.gain >= PROMISING * excess(self.plain))
                {
                    self.begin_elsewhere(&mut found, say)?;
                }
            }
        }
        self.begin_elsewhere(&mut found, say)?;
        let needs_no_other = |refit: &Refit| self.needs_no_other(refit, self.thresholds.inadequate);
        if leader(&found).is_some_and(needs_no_other) {
            // Far from the plain fit nearly everything promises the whole gap, and leads nowhere.
            for mut beginnings in outdone.into_iter().filter(|_| !self.quick) {
                beginnings.retain(|b| b.is_at_fit);
                found.extend(self.begin(beginnings, say)?);
            }
        } else if !outdone.is_empty() {
            for beginnings in outdone {
                self.begin_look(beginnings, &mut alike, &mut found, say)?;
            }
            self.begin_elsewhere(&mut found, say)?;
        }
        // What looks like one that gains nearly what the best does may gain more.
        let least = PROMISING * leader(&found).map_or(0.0, |best| best.gain);
        let best: Vec<usize> =
            found.iter().filter(|(r, _)| r.gain >= least).map(|(r, _)| r.members[0]).collect();
        let mut tried = vec![0; best.len()];
        for Alike { beginnings, other } in alike {
            match best.iter().position(|k| *k == other).filter(|look| tried[*look] < QUICK_ALIKE) {
                Some(look) => {
                    tried[look] += 1;
                    found.extend(self.begin(beginnings, say)?);
                }
                None => rest.push(beginnings),
            }
        }
        // So may what promises half as much at the plain fit, whatever it looks like.
        let least = PROMISING * leader(&found).map_or(0.0, |best| best.evidence);
        let promises = |b: &Beginning| b.is_at_fit && b.promise.evidence > least;
        let (promising, rest): (Vec<_>, Vec<_>) = rest.into_iter().partition(|all| all.iter().any(promises));
        let is_more_tried = !promising.is_empty() || tried.iter().any(|count| *count > 0);
        for beginnings in promising {
            found.extend(self.begin(beginnings, say)?);
        }
        if is_more_tried {
            self.begin_elsewhere(&mut found, say)?;
        }
        let mut singles = vec![];
        self.settle(&found, &mut singles, say)?;
        // Two effects may imitate a third one: no pair ends the search.
        let is_open = |singles: &[Refit]| !self.is_negligible && !singles.iter().any(needs_no_other);
        if !rest.is_empty() && is_open(&singles) {
            for beginnings in rest {
                found.extend(self.begin(beginnings, say)?);
            }
            self.begin_elsewhere(&mut found, say)?;
            self.settle(&found, &mut singles, say)?;
        }
        if !self.is_negligible && self.begin_further(&mut found, say)? {
            self.settle(&found, &mut singles, say)?;
        }
        let mut pairs = vec![];
        self.find_pairs(&mut singles, &mut pairs, say)?;
        // What leaves a rest that may be a matter of its form is an answer unless something else is the better one.
        let is_explained = singles.iter().chain(&pairs).any(|r| r.meets_data(&self.thresholds));
        if !is_explained && !self.is_negligible && self.begin_again(&mut found, say)? {
            self.begin_elsewhere(&mut found, say)?;
            self.settle(&found, &mut singles, say)?;
            self.find_pairs(&mut singles, &mut pairs, say)?;
        }
        singles.extend(pairs);
        Ok(singles)
    }

    /// What was begun with single effects, to the end: what looks like the leader, and the minima of all that compete.
    fn settle(
        &self,
        found: &[(Refit, VecDeque<Beginning>)],
        singles: &mut Vec<Refit>,
        say: &mut dyn FnMut(String),
    ) -> Result<(), DiagnosisError> {
        found.iter().for_each(|(refit, _)| keep_better(singles, refit.clone()));
        self.begin_where_leader_ended(singles, say)?;
        self.carry_on(singles, say)
    }

    fn explains_nothing(&self, refit: &Refit) -> bool {
        refit.gain < self.thresholds.decisive
    }

    /// Whether an effect leaves what may be noise, with more than this probability as it is, or in another form.
    fn needs_no_other(&self, refit: &Refit, probability: f64) -> bool {
        refit.leaves_noise(probability) || self.is_a_matter_of_form(refit)
    }

    /// A refit goes on where it may be an answer.
    pub(super) fn where_it_may_be_an_answer(&self) -> Depth {
        let points = self.plain.gap_mn.len() as f64;
        let rest = most_left((self.plain, self.gap), self.thresholds.rest);
        Depth::Below((points + NO_ANSWER * rest).max(MISSES_DATA * points))
    }

    /// Whether another effect has gained much more than this one promises, wherever it begins; where that one leaves noise, as it is or in
    /// another form, at the plain fit: far from it most of what is promised is what the plain model explains as well.
    fn is_outdone(&self, beginnings: &Beginnings, found: &[(Refit, VecDeque<Beginning>)]) -> bool {
        let most = found.iter().map(|(refit, _)| refit.gain).fold(0.0, f64::max);
        let promises = |b: &Beginning| b.promise.gain >= OUTDONE * most;
        let is_enough = |best: &Refit| self.needs_no_other(best, self.thresholds.significant);
        !beginnings.iter().any(|b| b.is_at_fit && promises(b))
            && (!beginnings.iter().any(promises) || leader(found).is_some_and(is_enough))
    }

    /// A refit with one effect, from the first start from which it ends no higher than the plain model that it contains; where none does,
    /// from the plain fit with hardly any of the effect. With it the starts that are left.
    pub(super) fn begin<'b>(
        &self,
        beginnings: Beginnings<'b>,
        say: &mut dyn FnMut(String),
    ) -> Result<Option<(Refit, VecDeque<Beginning<'b>>)>, DiagnosisError> {
        let mut beginnings = VecDeque::from(beginnings);
        let mut best: Option<Refit> = None;
        let mut first = None;
        let better = |best: &Option<Refit>, found: &Refit| best.as_ref().is_none_or(|b| b.gain < found.gain);
        // A rough fit may end as much above its minimum.
        let is_worse = |best: &Option<Refit>| {
            best.as_ref().is_none_or(|b| b.gain < -ROUGH * self.plain.solution.chi_square)
        };
        while is_worse(&best) {
            let Some(at) = beginnings.pop_front() else { break };
            first.get_or_insert(at.promise.clone());
            best = self.begun(&at, say)?.filter(|found| better(&best, found)).or(best);
        }
        if let Some(promise) = first.filter(|_| is_worse(&best)) {
            let last = self.refit_single(promise.candidate, self.hardly_any(&promise)?, say)?;
            best = last.filter(|found| better(&best, found)).or(best);
        }
        Ok(best.map(|refit| (refit, beginnings)))
    }

    /// A refit with one effect.
    pub(super) fn begun(
        &self,
        at: &Beginning,
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        let start = self.joined((at.x, &[]), &at.promise, at.chi_square)?;
        self.refit_single(at.promise.candidate, start, say)
    }

    /// The leaders are begun from the other starts, too, while the best of them leaves more than noise.
    fn begin_elsewhere(
        &self,
        found: &mut [(Refit, VecDeque<Beginning>)],
        say: &mut dyn FnMut(String),
    ) -> Result<(), DiagnosisError> {
        for _ in 0..if self.quick { QUICK_AGAIN } else { AGAIN } {
            let leader = found.iter_mut().max_by(|a, b| a.0.evidence.total_cmp(&b.0.evidence));
            let Some((refit, elsewhere)) = leader else { break };
            let Some(at) = elsewhere.pop_front().filter(|_| !refit.leaves_noise(self.thresholds.significant))
            else {
                break;
            };
            replace_if_better(refit, self.begun(&at, say)?);
        }
        Ok(())
    }

    /// What explains nothing from where it began is begun from its other starts, all of them; what explains less than half of the gap, on
    /// the other side: a promise is linear, and may have the wrong sign. Whether there was any of these.
    fn begin_again(
        &self,
        found: &mut [(Refit, VecDeque<Beginning>)],
        say: &mut dyn FnMut(String),
    ) -> Result<bool, DiagnosisError> {
        let mut is_begun = false;
        for (refit, elsewhere) in found {
            while self.explains_nothing(refit)
                && let Some(at) = elsewhere.pop_front()
            {
                is_begun = true;
                replace_if_better(refit, self.begun(&at, say)?);
            }
            if refit.gain < PROMISING * excess(self.plain)
                && let Some(start) = self.other_side(refit)?
            {
                is_begun = true;
                replace_if_better(refit, self.refit_single(refit.members[0], start, say)?);
            }
        }
        Ok(is_begun)
    }

    /// What promises most at the further starts of the plain model is begun from there where it has gained less and may lead what leads by
    /// then by more than decides, until one needs no other. Whether there was any.
    fn begin_further<'b>(
        &'b self,
        found: &mut Vec<(Refit, VecDeque<Beginning<'b>>)>,
        say: &mut dyn FnMut(String),
    ) -> Result<bool, DiagnosisError> {
        let mut is_begun = false;
        for x in self.further {
            let least = self.thresholds.decisive + leader(found).map_or(0.0, |best| best.gain);
            // No promise is more than the whole gap.
            if least > excess(self.plain) {
                break;
            }
            let Some(there) = Elsewhere::at(self.setup, self.covariance, self.plain, x)? else { continue };
            for at in self.beginnings_at(&there).into_iter().take(MOST_FURTHER) {
                let own = found.iter_mut().find(|(refit, _)| refit.members == [at.promise.candidate]);
                let gained = own.as_ref().map_or(0.0, |(refit, _)| refit.gain);
                if at.promise.gain <= least.max(gained) {
                    continue;
                }
                is_begun = true;
                let begun = self.begun(&at, say)?;
                match own {
                    Some((refit, _)) => replace_if_better(refit, begun),
                    None => found.extend(begun.map(|refit| (refit, VecDeque::new()))),
                }
            }
            if leader(found).is_some_and(|best| self.needs_no_other(best, self.thresholds.inadequate)) {
                break;
            }
        }
        Ok(is_begun)
    }

    /// Where nothing is imitated, with one plausible scale of an effect on the other side than its refit has; `None` of what has one side only.
    fn other_side(&self, refit: &Refit) -> Result<Option<Vec<f64>>, EvaluationFailure> {
        let candidate = &self.candidates[refit.members[0]];
        if candidate.is_one_sided() || !is_continuous(candidate) {
            return Ok(None);
        }
        let size = -refit.sizes(self.candidates)[0].signum();
        let x = self.elsewhere.first().map_or(self.plain.x(), |there| there.x);
        self.start(x, &[(refit.members[0], size)]).map(Some)
    }

    /// Fits that are compared are converged: all whose evidence may still pass the best one's. Best first.
    fn carry_on(&self, refits: &mut [Refit], say: &mut dyn FnMut(String)) -> Result<(), DiagnosisError> {
        let by_evidence = |a: &Refit, b: &Refit| b.evidence.total_cmp(&a.evidence);
        refits.sort_by(by_evidence);
        let Some(least) = refits.first().map(|r| r.evidence - self.thresholds.decisive) else {
            return Ok(());
        };
        for found in refits.iter_mut() {
            // A rough fit ends where one more iteration gains less than this part of chi^2.
            let may_gain = ROUGH * found.fit.solution.chi_square;
            if found.fit.end != End::Minimum && found.evidence + may_gain >= least {
                let size = found.sizes(self.candidates)[0];
                let start = self.start(found.fit.x(), &[(found.members[0], size)])?;
                if let Some(better) = self.refit(&found.members, start, Depth::Minimum, say)? {
                    *found = better;
                }
            }
        }
        refits.sort_by(by_evidence);
        Ok(())
    }

    /// A refit with one effect, to its minimum at once where it may leave noise.
    pub(super) fn refit_single(
        &self,
        candidate: usize,
        start: Vec<f64>,
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        let depth = Depth::Below(MISSES_DATA * self.plain.gap_mn.len() as f64);
        self.refit(&[candidate], start, depth, say)
    }

    /// `None` where the model cannot be computed with these effects: that is no competitor.
    pub(super) fn refit(
        &self,
        members: &[usize],
        start: Vec<f64>,
        depth: Depth,
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        let names: Vec<&str> = self.active(members).iter().map(|c| c.name.as_str()).collect();
        let what = names.join(" and ");
        let mut watch = |r: &IterationRecord| {
            say(format!("with {what}, iteration {}: chi^2 = {:.1}", r.iteration, r.chi_square));
        };
        match refit(self, members, start, depth, &mut watch) {
            Ok(found) => Ok(Some(found)),
            Err(FitFailure::Evaluation(EvaluationFailure::Interrupted)) => {
                Err(EvaluationFailure::Interrupted.into())
            }
            Err(_) => Ok(None),
        }
    }
}
