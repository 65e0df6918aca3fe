//! Which models with effects are refitted.
//!
//! ```text
//! leaders of the screening, one by one
//! -> the best of them together with what its rest shows, where it shows something
//! -> further single effects, while nothing explains the gap
//! ```

use super::baseline::{Fit, FitFailure};
use super::confirming::{Refit, excess, refit};
use super::diagnose::{DiagnosisError, linear_evidence};
use super::effect::Candidate;
use super::problem::Setup;
use super::screening::{CONFUSABLE, Screened};
use super::something_else::SomethingElse;
use crate::fit::{EvaluationFailure, IterationRecord};
use crate::noise::Covariance;

/// Screened effects that are refitted, whether or not one of them explains the gap.
const LEADERS: usize = 5;
const QUICK_LEADERS: usize = 2;
/// Effects that are tried before the cause is called none of these.
const TRIED: usize = 7;
/// An effect of which screening expects a smaller part of the gain of another that explains all is not refitted.
const HOPELESS: f64 = 0.2;
/// Evidence (twice the logarithm) that a second effect must have in the rest of the best single one.
const PAIR_GAIN: f64 = 8.0;
/// A second effect that gains a smaller part of what the first does makes up for the first one's form.
const FORM: f64 = 0.1;
/// An effect (or two) of which screening expects a smaller part of the gap is no cause of all of it.
const WORTH_TRYING: f64 = 0.1;
/// Of the leaders themselves less is asked: a signature is that of a plain fit which hides as much of the effect as it can.
const FAINT: f64 = 1e-3;

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
}

impl Search<'_> {
    /// Refits of `leaders`, best first.
    ///
    /// # Errors
    /// When the user asked to stop.
    pub fn run(
        &self,
        leaders: &[&Screened],
        quick: bool,
        say: &mut dyn FnMut(String),
    ) -> Result<Vec<Refit>, DiagnosisError> {
        let y = &self.plain.linear.residual;
        let expected = |s: &Screened| (s.candidate, s.signature.magnitude(y).0);
        let gain = |s: &Screened| s.signature.score(y).powi(2);
        let evidence =
            |s: &Screened| linear_evidence(&self.candidates[s.candidate], &s.signature, self.plain);
        // The first is refitted in any case: its signature is that of a finite magnitude, not of the best one.
        let promising = leaders.iter().enumerate().filter(|(k, s)| *k == 0 || evidence(s) > 0.0);
        let chosen: Vec<&Screened> = promising.map(|(_, s)| *s).take(TRIED).collect();
        let count = if quick { QUICK_LEADERS } else { LEADERS }.min(chosen.len());
        let mut first = chosen[..count].to_vec();
        if let (Some(leader), false) = (leaders.first(), quick) {
            let mates = leaders.iter().skip(chosen.len());
            first.extend(mates.filter(|s| leader.signature.cosine(&s.signature).abs() > CONFUSABLE));
        }
        // What the plain model made of its parameters to imitate an effect may be far from what they are with it.
        let from = [self.setup.parameters.start(), self.plain.x()];
        let mut refits: Vec<Refit> = Vec::new();
        let gap = excess(self.plain);
        for (rank, leader) in first.into_iter().enumerate() {
            let gain = gain(leader);
            let hopeless = |r: &Refit| r.is_enough() && gain < HOPELESS * r.gain;
            let faint = rank >= QUICK_LEADERS && gain < FAINT * gap;
            if !faint && !refits.iter().any(hopeless) {
                refits.extend(self.refit(&[expected(leader)], gain, from, say)?);
            }
        }
        let best = refits.iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence));
        let with_partner = best.and_then(|best| Some((best, self.partner(best, leaders)?)));
        if let Some((best, (partner, more))) =
            with_partner.filter(|(b, (_, m))| b.gain + m > WORTH_TRYING * gap)
        {
            let own = best.fit.magnitudes().first().copied().unwrap_or(1.0);
            let from = [best.fit.x(), self.setup.parameters.start()];
            let pair = self.refit(&[(best.members[0], own), partner], best.gain + more, from, say)?;
            refits.extend(pair);
        }
        // Signatures are those of a plain fit that misses the gap, and the larger the gap, the less they say.
        for leader in &chosen[count..] {
            if refits.iter().any(Refit::is_enough) {
                break;
            }
            if gain(leader) < WORTH_TRYING * gap {
                continue;
            }
            refits.extend(self.refit(&[expected(leader)], gain(leader), from, say)?);
        }
        Ok(refits)
    }

    /// What the rest of a single effect shows best with its magnitude, and the gain that it promises.
    fn partner(&self, single: &Refit, leaders: &[&Screened]) -> Option<((usize, f64), f64)> {
        let fit = &single.fit;
        let family = |k: usize| &self.candidates[k].effect.family;
        let others = leaders.iter().filter(|s| family(s.candidate) != family(single.members[0]));
        let in_rest = others.map(|s| {
            let signature = fit.linear.signature(&fit.covariance, &s.change_mn);
            let evidence = linear_evidence(&self.candidates[s.candidate], &signature, fit);
            let rest = &fit.linear.residual;
            (evidence, (s.candidate, signature.magnitude(rest).0), signature.score(rest).powi(2))
        });
        let (evidence, partner, gain) = in_rest.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (evidence > PAIR_GAIN && gain > FORM * single.gain).then_some((partner, gain))
    }

    /// `None` where the model cannot be computed with these effects: that is no competitor.
    fn refit(
        &self,
        members: &[(usize, f64)],
        promised: f64,
        from: [&[f64]; 2],
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Refit>, DiagnosisError> {
        let names: Vec<&str> = members.iter().map(|(k, _)| self.candidates[*k].name.as_str()).collect();
        let what = names.join(" and ");
        let mut watch = |r: &IterationRecord| {
            say(format!("with {what}, iteration {}: chi^2 = {:.1}", r.iteration, r.chi_square));
        };
        match refit(self, members, promised, from, &mut watch) {
            Ok(found) => Ok(Some(found)),
            Err(FitFailure::Evaluation(EvaluationFailure::Interrupted)) => {
                Err(EvaluationFailure::Interrupted.into())
            }
            Err(_) => Ok(None),
        }
    }
}
