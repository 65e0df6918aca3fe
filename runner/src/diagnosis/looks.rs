//! Effects that look the same: one stands for all, and others stand in for it.

use super::confirming::Refit;
use super::diagnose::DiagnosisError;
use super::promise::{Beginning, Beginnings, PROMISING, most_promising_first};
use super::round::Elsewhere;
use super::search::{Search, keep_better};
use std::collections::VecDeque;

/// Effects of different looks that a quick diagnosis refits, and those that look like the best of them.
const QUICK: usize = 4;
pub(super) const QUICK_ALIKE: usize = 2;

/// An effect that looks like another one, which is refitted before.
pub(super) struct Alike<'a> {
    pub beginnings: Beginnings<'a>,
    pub other: usize,
}

impl Search<'_> {
    /// What is refitted first, what looks like it, each with the effect of these that it looks like, and the rest. All that is not quick is
    /// refitted first; of what looks the same one stands for all, so that it does not take the place of another cause.
    pub(super) fn by_looks<'b>(
        &self,
        all: Vec<Beginnings<'b>>,
    ) -> (Vec<Beginnings<'b>>, Vec<Alike<'b>>, Vec<Beginnings<'b>>) {
        if !self.quick {
            return (all, vec![], vec![]);
        }
        let (mut first, mut others, mut rest): (Vec<Beginnings>, _, _) = (vec![], vec![], vec![]);
        for beginnings in all {
            let own = beginnings[0].promise.candidate;
            match first.iter().map(|b| b[0].promise.candidate).find(|k| self.look_alike(*k, own)) {
                Some(other) => others.push(Alike { beginnings, other }),
                None if first.len() < QUICK => first.push(beginnings),
                None => rest.push(beginnings),
            }
        }
        (first, others, rest)
    }

    /// Whether these data cannot tell two effects apart around the plain fit.
    pub(super) fn look_alike(&self, a: usize, b: usize) -> bool {
        let signature = |k: usize| self.shown.iter().find(|s| s.candidate == k).map(|s| &s.signature);
        matches!((signature(a), signature(b)), (Some(a), Some(b)) if a.looks_like(b))
    }

    /// A refit with one effect, and with those that look like it until one does what the look promises: a promise is linear, and may be
    /// kept by another form of it.
    pub(super) fn begin_look<'b>(
        &self,
        beginnings: Beginnings<'b>,
        alike: &mut Vec<Alike<'b>>,
        found: &mut Vec<(Refit, VecDeque<Beginning<'b>>)>,
        say: &mut dyn FnMut(String),
    ) -> Result<(), DiagnosisError> {
        let promised = beginnings[0].promise.gain;
        let mut next = Some(beginnings);
        for _ in 0..=QUICK_ALIKE {
            let Some(beginnings) = next else { break };
            let own = beginnings[0].promise.candidate;
            let begun = self.begin(beginnings, say)?;
            let keeps_it = begun.as_ref().is_some_and(|(refit, _)| refit.gain >= PROMISING * promised);
            found.extend(begun);
            let other = alike.iter().position(|a| a.other == own).filter(|_| !keeps_it);
            next = other.map(|k| alike.remove(k).beginnings);
            // What stood behind this effect stands behind the next one.
            if let Some(next) = next.as_ref().map(|b| b[0].promise.candidate) {
                alike.iter_mut().filter(|a| a.other == own).for_each(|a| a.other = next);
            }
        }
        Ok(())
    }

    /// What looks like the leader where that ended is refitted from there, unless it does as well already: at the plain fit, which imitates
    /// what it lacks, it may look like something else, and its own refit may have ended in another minimum.
    pub(super) fn begin_where_leader_ended(
        &self,
        refits: &mut Vec<Refit>,
        say: &mut dyn FnMut(String),
    ) -> Result<(), DiagnosisError> {
        let leader = refits.iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence));
        let Some(leader) = leader else { return Ok(()) };
        let (own, enough) = (leader.members[0], leader.evidence - self.thresholds.decisive);
        let x = leader.fit.x().to_vec();
        let there = Elsewhere::at(self.setup, self.covariance, self.plain, &x)?;
        let of_leader = self.screened.iter().find(|s| s.candidate == own);
        let Some((there, of_leader)) = there.zip(of_leader) else { return Ok(()) };
        let look = there.signature(of_leader);
        let does_as_well = |k: usize| refits.iter().any(|r| r.members == [k] && r.evidence >= enough);
        let others = self.screened.iter().filter(|s| s.candidate != own && !does_as_well(s.candidate));
        let like_it = others.filter(|s| there.signature(s).looks_like(&look));
        let beginnings = most_promising_first(like_it.map(|s| self.beginning_at(&there, s)).collect());
        for at in beginnings.into_iter().take(if self.quick { QUICK_ALIKE } else { usize::MAX }) {
            self.begun(&at, say)?.into_iter().for_each(|found| keep_better(refits, found));
        }
        Ok(())
    }
}
