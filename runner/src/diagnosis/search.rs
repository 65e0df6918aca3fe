//! Which models with effects are refitted.
//!
//! ```text
//! leaders of the screening, one by one
//! -> the best of them together with what its rest shows, where it shows something
//! -> further single effects, while nothing explains the gap, in the order that their signatures have at the user's start
//! ```

use super::confirming::{Refit, excess, refit, start_magnitudes};
use super::diagnose::{DiagnosisError, linear_evidence};
use super::screening::{Screened, Screening};
use super::something_else::SomethingElse;
use super::verdict::DECISIVE;
use crate::fit::{EvaluationFailure, IterationRecord};
use crate::inference::Setup;
use crate::inference::effect::Candidate;
use crate::inference::fit::{Fit, FitFailure, Tangent, chi_square, linearised};
use crate::inference::{Linearised, Signature};
use crate::noise::{Covariance, form_errors};

/// Screened effects that are refitted where one of them explains the gap.
const LEADERS: usize = 5;
const QUICK_LEADERS: usize = 2;
/// So many of them while none does: the others count as rivals of one that does.
const FIRST: usize = 3;
/// Models that are tried before the cause is called none of these.
const TRIED: usize = 7;
const QUICK_TRIED: usize = 4;
/// An effect of which screening expects a smaller part of the gain of another that explains all is not refitted.
const HOPELESS: f64 = 0.2;
/// Evidence (twice the logarithm) that a second effect must have in the rest of the best single one.
const PAIR_GAIN: f64 = 8.0;
/// Nature's form of the first effect may deviate from the catalogue's by this part of it; what a second one does must be more than
/// that explains.
const FORM: f64 = 0.3;
/// An effect (or two) of which screening expects a smaller part of the gap is no cause of all of it.
const WORTH_TRYING: f64 = 0.1;
/// A second effect of which a smaller part of the first one's rest is expected is not refitted.
const FAINT_PARTNER: f64 = 0.03;
/// Of the leaders themselves less is asked: a signature is that of a plain fit which hides as much of the effect as it can.
const FAINT: f64 = 1e-3;

/// Part of the promised gain with which a refit from one start is content.
const KEPT: f64 = 0.8;
/// A second effect whose expected magnitude does harm begins at this part of it, and at this part of that, ...
const GENTLER: f64 = 0.25;
/// so many times.
const GENTLER_TIMES: usize = 3;

/// What an effect would do for a fit, by its signature.
struct Promise {
    candidate: usize,
    magnitude: f64,
    /// Fall of chi^2.
    gain: f64,
    /// Twice the logarithm of the evidence.
    evidence: f64,
}

impl Promise {
    fn expected(&self) -> (usize, f64) {
        (self.candidate, self.magnitude)
    }
}

/// A second effect, and what would do as well in its place.
struct Partner {
    promise: Promise,
    alternatives: Vec<usize>,
}

/// What all refits share.
pub struct Search<'a> {
    /// Engine, measurements, parameters.
    pub setup: Setup<'a>,
    /// What was asked about.
    pub candidates: &'a [Candidate],
    /// Fit of the plain model.
    pub plain: &'a Fit,
    /// The smooth part of what it leaves.
    pub gap: &'a SomethingElse,
    /// Noise.
    pub covariance: &'a Covariance,
    /// Largest number of evaluations of a fit.
    pub evaluations: usize,
    /// Fewer models, and no second start for a refit that is better than the model without its effect.
    pub quick: bool,
}

impl Search<'_> {
    /// Refits of `leaders`, best first.
    ///
    /// # Errors
    /// When the user asked to stop.
    pub fn run(
        &self,
        leaders: &[&Screened],
        say: &mut dyn FnMut(String),
    ) -> Result<Vec<Refit>, DiagnosisError> {
        let (plain, quick) = (self.plain, self.quick);
        let promises: Vec<Promise> =
            leaders.iter().map(|s| self.promise(s.candidate, &s.signature, &plain.linear)).collect();
        // The first is refitted in any case: its signature is that of a finite magnitude, not of the best one.
        let promising = promises.iter().enumerate().filter(|(k, p)| *k == 0 || p.evidence > 0.0);
        let chosen: Vec<&Promise> = promising.map(|(_, p)| p).take(TRIED).collect();
        let count = if quick { QUICK_LEADERS } else { LEADERS }.min(chosen.len());
        let mut first = chosen[..count].to_vec();
        if let (Some(leader), false) = (leaders.first(), quick) {
            let mates = leaders.iter().zip(&promises).skip(chosen.len());
            let alike = mates.filter(|(s, _)| leader.signature.looks_like(&s.signature));
            first.extend(alike.map(|(_, p)| p));
        }
        // What the plain model made of its parameters to imitate an effect may be far from what they are with it.
        let from = [self.setup.unknowns.start(), plain.x()];
        let mut refits: Vec<Refit> = Vec::new();
        for (rank, promise) in first.into_iter().enumerate() {
            if self.may_matter(rank, promise, &refits) {
                // A rival of what explains the gap is given one start.
                let starts = if refits.iter().any(Refit::is_enough) { &from[..1] } else { &from };
                refits.extend(self.refit(&[promise.expected()], self.content(promise), starts, say)?);
            }
        }
        let best = refits.iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence));
        if let Some(best) = best.filter(|best| !best.leaves_noise()) {
            let pair = self.pair(best, leaders, say)?;
            refits.extend(pair);
        }
        if !refits.iter().any(Refit::is_enough) {
            let tried = if quick { QUICK_TRIED } else { TRIED };
            for promise in self.at_start(leaders)? {
                if refits.len() >= tried || refits.iter().any(Refit::is_enough) {
                    break;
                }
                if !refits.iter().any(|r| r.members == [promise.candidate]) {
                    refits.extend(self.refit(&[promise.expected()], self.content(&promise), &from, say)?);
                }
            }
        }
        Ok(refits)
    }

    /// A single effect together with what its rest shows, where that is worth trying.
    fn pair(
        &self,
        single: &Refit,
        leaders: &[&Screened],
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        let Some(Partner { promise, alternatives }) = self.partner(single, leaders)? else { return Ok(None) };
        let is_small = single.gain + promise.gain <= WORTH_TRYING * excess(self.plain);
        if is_small || promise.gain <= FAINT_PARTNER * excess(&single.fit) {
            return Ok(None);
        }
        let own = single.fit.magnitudes().first().copied().unwrap_or(1.0);
        let members = self.gentle(single, [(single.members[0], own), promise.expected()])?;
        let from = [single.fit.x(), self.setup.unknowns.start()];
        let content = single.fit.solution.chi_square - KEPT * promise.gain;
        let pair = self.refit(&members, content, &from, say)?;
        Ok(pair.map(|pair| Refit { alternatives, ..pair }))
    }

    /// Whether a leader of screening, by its rank, may still change the answer.
    fn may_matter(&self, rank: usize, promise: &Promise, found: &[Refit]) -> bool {
        let faint = rank >= QUICK_LEADERS && promise.gain < FAINT * excess(self.plain);
        let mut explained = found.iter().filter(|r| r.is_enough()).peekable();
        match explained.peek() {
            Some(_) => !faint && explained.all(|r| promise.gain >= HOPELESS * r.gain),
            None => !faint && rank < FIRST,
        }
    }

    /// chi^2 of a refit with one effect that is given no further start: most of the fall that its signature promises, or any.
    fn content(&self, promise: &Promise) -> f64 {
        self.plain.solution.chi_square - if self.quick { 0.0 } else { KEPT * promise.gain }
    }

    /// What a signature promises around the linearised model that it belongs to.
    fn promise(&self, candidate: usize, signature: &Signature, linear: &Linearised) -> Promise {
        let rest = &linear.residual;
        Promise {
            candidate,
            magnitude: signature.magnitude(rest).0,
            gain: signature.score(rest).powi(2),
            evidence: linear_evidence(&self.candidates[candidate], signature, rest),
        }
    }

    /// What the effects promise where the search of the parameters starts, largest evidence first. A plain fit that misses
    /// much has moved its parameters to imitate what it lacks, and leaves of it what some other effect may explain better; at
    /// the start nothing is imitated.
    fn at_start(&self, leaders: &[&Screened]) -> Result<Vec<Promise>, DiagnosisError> {
        let start = self.setup.unknowns.start();
        let Tangent { covariance, linear, .. } =
            Tangent::at(self.setup, &[], self.covariance, &self.plain.prior, start)?;
        let missed = excess(self.plain);
        let promise = |s: &&Screened| {
            let signature = linear.signature(&covariance, &s.change_mn);
            let promise = self.promise(s.candidate, &signature, &linear);
            // More than the whole gap cannot be gained.
            Promise { gain: promise.gain.min(missed), ..promise }
        };
        let mut promises: Vec<Promise> = leaders.iter().map(promise).collect();
        promises.retain(|p| p.evidence > 0.0 && p.gain > WORTH_TRYING * missed);
        promises.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        Ok(promises)
    }

    /// What the rest of a single effect shows best, beyond what the effect's form may leave.
    fn partner(&self, single: &Refit, leaders: &[&Screened]) -> Result<Option<Partner>, EvaluationFailure> {
        let (fit, first) = (&single.fit, single.members[0]);
        let Some(alone) = leaders.iter().find(|s| s.candidate == first) else { return Ok(None) };
        // A switch has no magnitude that was fitted.
        let (magnitude, change_mn) = match fit.magnitudes() {
            [] => (1.0, alone.change_mn.clone()),
            [magnitude, ..] => (*magnitude, fit.jacobian_mn.column(fit.parameters) * *magnitude),
        };
        let covariance = fit.covariance.with(form_errors(self.setup.observations, &change_mn, FORM));
        let linear = linearised(&fit.jacobian_mn, &fit.gap_mn, &covariance, &fit.prior, &fit.solution.x);
        let family = |k: usize| &self.candidates[k].effect.family;
        let others = leaders.iter().filter(|s| family(s.candidate) != family(first));
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
            .map(|s| (self.promise(s.candidate, &s.signature, &linear), &s.signature))
            .filter(|(promise, _)| promise.evidence > PAIR_GAIN)
            .collect();
        in_rest.sort_by(|(a, _), (b, _)| b.evidence.total_cmp(&a.evidence));
        let mut in_rest = in_rest.into_iter();
        let Some((promise, signature)) = in_rest.next() else { return Ok(None) };
        let as_good =
            |(p, s): &(Promise, &Signature)| signature.looks_like(s) && promise.gain - p.gain < DECISIVE;
        let alternatives = in_rest.filter(as_good).map(|(p, _)| p.candidate).collect();
        Ok(Some(Partner { promise, alternatives }))
    }

    /// `single`'s effect and a second one of such a magnitude that the data are met no worse than without it: a signature is linear,
    /// and what it asks for may be far beyond.
    fn gentle(
        &self,
        single: &Refit,
        [first, (second, expected)]: [(usize, f64); 2],
    ) -> Result<[(usize, f64); 2], EvaluationFailure> {
        let active = [&self.candidates[first.0], &self.candidates[second]];
        let mut magnitude = expected;
        for _ in 0..GENTLER_TIMES {
            let mut x = single.fit.x().to_vec();
            x.extend(start_magnitudes(self.candidates, &[first, (second, magnitude)]));
            let there = chi_square(self.setup, &active, self.covariance, &x)?;
            if there.is_some_and(|there| there <= single.fit.solution.chi_square) {
                break;
            }
            magnitude *= GENTLER;
        }
        Ok([first, (second, magnitude)])
    }

    /// `None` where the model cannot be computed with these effects: that is no competitor.
    fn refit(
        &self,
        members: &[(usize, f64)],
        content: f64,
        from: &[&[f64]],
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        let names: Vec<&str> = members.iter().map(|(k, _)| self.candidates[*k].name.as_str()).collect();
        let what = names.join(" and ");
        let mut watch = |r: &IterationRecord| {
            say(format!("with {what}, iteration {}: chi^2 = {:.1}", r.iteration, r.chi_square));
        };
        match refit(self, members, content, from, &mut watch) {
            Ok(found) => Ok(Some(found)),
            Err(FitFailure::Evaluation(EvaluationFailure::Interrupted)) => {
                Err(EvaluationFailure::Interrupted.into())
            }
            Err(_) => Ok(None),
        }
    }
}
