//! The nine steps, one after the other.

use super::baseline::{FINAL, Fit, FitFailure, FitPlan, ROUGH, fit};
use super::catalogue::effects;
use super::confirming::{Refit, pair_evidence, refit};
use super::covariance::{NoiseModel, noise_model, rough_covariance};
use super::effect::{Candidate, PRIOR_DEVIATION, Sign};
use super::held_out::{Split, splits};
use super::location::{Spot, spots};
use super::observation::Observation;
use super::problem::{Setup, is_continuous};
use super::refinement::refined;
use super::screening::{Failed, Family, Screened, Signature, screen};
use super::shrinkage::Comparison;
use super::something_else::{SomethingElse, something_else};
use super::verdict::{Decision, Evidence, SIGNIFICANT, decide};
use crate::engine::Engine;
use crate::fit::EvaluationFailure;
use crate::objective::{DatasetError, ParameterMap};
use crate::pool::Priority;
use thiserror::Error;

/// How thorough the diagnosis is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Screening, and a refit of the two leaders only.
    pub quick: bool,
    /// Largest number of evaluations of a fit.
    pub evaluations: usize,
}

/// A diagnosis that cannot be made.
#[derive(Debug, Error)]
pub enum DiagnosisError {
    /// A measurement.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The plain model cannot be fitted.
    #[error("the plain model cannot be fitted: {0}")]
    Baseline(FitFailure),
    /// The model fails beside the fit.
    #[error("the model fails at the fitted parameters: {0}")]
    Model(#[from] EvaluationFailure),
}

/// Everything that was found, before it is put into words.
pub struct Findings {
    /// Tests, as far as they were used.
    pub observations: Vec<Observation>,
    /// Their noise.
    pub noise: NoiseModel,
    /// Fit of the plain model.
    pub plain: Fit,
    /// Places where it was looked for misfit.
    pub spots: Vec<Spot>,
    /// What was asked about.
    pub candidates: Vec<Candidate>,
    /// Those with a signature, largest evidence first.
    pub screened: Vec<Screened>,
    /// Those that could not be computed.
    pub failed: Vec<Failed>,
    /// Effects that the FMU does not have.
    pub unknown: Vec<String>,
    /// Distribution of the largest score of all under noise.
    pub family: Family,
    /// Family-wise probability of the largest score.
    pub probability: f64,
    /// What a smooth error of any shape explains.
    pub something_else: SomethingElse,
    /// Models with effects.
    pub refits: Vec<Refit>,
    /// Parts that can be predicted from the rest.
    pub splits: Vec<Split>,
    /// The answer.
    pub decision: Decision,
}

/// Screened effects that are refitted, whether or not one of them explains the gap.
const LEADERS: usize = 5;
const QUICK_LEADERS: usize = 2;
/// Effects that are tried before the cause is called none of these.
const TRIED: usize = 7;
/// An effect of which screening expects a smaller part of the gain of another that explains all is not refitted.
const HOPELESS: f64 = 0.2;
/// Evidence (twice the logarithm) by which two effects together must surpass the best one to be refitted.
const PAIR_GAIN: f64 = 8.0;
/// Starts of the plain fit beside the user's.
const STARTS: usize = 3;

/// Makes the diagnosis; `say` hears what is being done.
///
/// # Errors
/// When the plain model cannot be fitted, or the user asked to stop.
pub fn diagnose(
    engine: &Engine,
    observations: Vec<Observation>,
    parameters: &ParameterMap,
    sample_height_m: Option<f64>,
    effort: Effort,
    say: &mut dyn FnMut(String),
) -> Result<Findings, DiagnosisError> {
    let observations = computable(engine, observations, parameters, sample_height_m)?;
    let setup = Setup { engine, observations: &observations, parameters };
    let (plain, noise) = baseline(setup, effort, say)?;
    let covariance = &plain.covariance;
    let names: Vec<String> = observations.iter().map(|o| o.name().to_owned()).collect();
    let (effects, unknown) = effects(engine.wiring());
    let candidates = Candidate::of(&effects, &names);
    say(format!("screening {} effects", candidates.len()));
    let (mut screened, failed) = screen(setup, &candidates, plain.x(), &plain.linear, covariance)?;
    let y = &plain.linear.residual;
    let evidence = |s: &Screened| linear_evidence(&candidates[s.candidate], &s.signature, &plain);
    screened.sort_by(|a, b| evidence(b).total_cmp(&evidence(a)));
    let spots = spots(&observations, &plain.linear, covariance);
    let (family, largest) = family(&screened, &spots, &candidates, &plain);
    let probability = family.probability(largest);
    let something_else = something_else(&observations, &plain.linear, covariance);
    let threshold = family.threshold(SIGNIFICANT);
    let testable =
        |s: &&Screened| is_testable(&candidates[s.candidate], &s.signature, s.signature.score(y), threshold);
    let mut refits = Vec::new();
    if probability <= SIGNIFICANT {
        let leaders: Vec<&Screened> = screened.iter().filter(testable).collect();
        refits = confirm(setup, &candidates, &leaders, &plain, &noise, effort, say)?;
    }
    let splits = splits(&observations);
    let alike = |a: usize, b: usize| alike(&screened, a, b);
    let accepted = |r: &Refit| accepted(&plain, r, &splits);
    let decision = decide(&Evidence {
        probability,
        refits: &refits,
        something_else: something_else.evidence,
        gap: something_else.explained,
        alike: &alike,
        accepted: &accepted,
    });
    Ok(Findings {
        noise,
        spots,
        candidates,
        screened,
        failed,
        unknown,
        family,
        probability,
        something_else,
        refits,
        splits,
        decision,
        plain,
        observations,
    })
}

/// The tests as far as the model can follow them: the whole motion, or the first loading and its hold.
fn computable(
    engine: &Engine,
    observations: Vec<Observation>,
    parameters: &ParameterMap,
    sample_height_m: Option<f64>,
) -> Result<Vec<Observation>, DiagnosisError> {
    let setup = Setup { engine, observations: &observations, parameters };
    let runs = setup.submit(parameters.start(), &[], false, Priority::Urgent);
    if Setup::computable_forces_mn(&runs)?.is_some() {
        return Ok(observations);
    }
    let shorter = |o: &Observation| o.first_hold(sample_height_m);
    Ok(observations.iter().map(shorter).collect::<Result<_, _>>()?)
}

/// Fit of the plain model, its covariance with the error of the simulation at that fit.
fn baseline(
    setup: Setup,
    effort: Effort,
    say: &mut dyn FnMut(String),
) -> Result<(Fit, NoiseModel), DiagnosisError> {
    let first = rough_covariance(setup.observations);
    let drawn = if effort.quick { 0 } else { STARTS };
    let starts = vec![setup.parameters.start().to_vec()];
    let plan = FitPlan { starts, drawn, evaluations: effort.evaluations, tolerance: ROUGH };
    let mut watch = |r: &crate::fit::IterationRecord| {
        say(format!("plain model, iteration {}: chi^2 = {:.1}", r.iteration, r.chi_square));
    };
    let rough = fit(setup, &[], &first, &plan, &mut watch).map_err(DiagnosisError::Baseline)?;
    let reference: Vec<f64> =
        setup.measured_mn().iter().zip(rough.gap_mn.iter()).map(|(m, gap)| m - gap).collect();
    let noise = noise_model(setup.observations, &reference, refined(setup, rough.x())?);
    let starts = vec![rough.x().to_vec()];
    let plan = FitPlan { starts, drawn: 0, evaluations: effort.evaluations, tolerance: FINAL };
    let plain = fit(setup, &[], &noise.covariance, &plan, &mut watch).map_err(DiagnosisError::Baseline)?;
    Ok((plain, noise))
}

/// Largest score of all effects and places, and its distribution under noise.
fn family(screened: &[Screened], spots: &[Spot], candidates: &[Candidate], plain: &Fit) -> (Family, f64) {
    let y = &plain.linear.residual;
    let mut signatures: Vec<&Signature> = screened.iter().map(|s| &s.signature).collect();
    let mut one_sided: Vec<bool> =
        screened.iter().map(|s| candidates[s.candidate].effect.sign != Sign::Either).collect();
    for s in screened {
        signatures.extend(&s.other);
        one_sided.resize(signatures.len(), candidates[s.candidate].effect.sign != Sign::Either);
    }
    signatures.extend(spots.iter().map(|s| &s.signature));
    one_sided.resize(signatures.len(), false);
    let counted = signatures.iter().zip(&one_sided).map(|(s, one)| {
        let z = s.score(y);
        if *one { z } else { z.abs() }
    });
    let largest = counted.fold(0.0, f64::max);
    (Family::new(&signatures, &one_sided, 2), largest)
}

/// Twice the log evidence of an effect from its signature alone.
pub fn linear_evidence(candidate: &Candidate, signature: &Signature, plain: &Fit) -> f64 {
    let y = &plain.linear.residual;
    match candidate.effect.sign {
        // On or off: the likelihood ratio at magnitude 1.
        Sign::Switch => signature.gain_of_one(y),
        sign => signature.evidence(y, PRIOR_DEVIATION, sign == Sign::Positive),
    }
}

/// Whether an effect of its plausible scale would pass the threshold in half of all cases, or one of an admissible size does.
pub fn is_testable(candidate: &Candidate, signature: &Signature, score: f64, threshold: f64) -> bool {
    let size = score.abs() / signature.strength();
    let passes = candidate.one_sided(score) >= threshold && size <= candidate.effect.largest;
    signature.strength() >= threshold || (passes && is_continuous(candidate))
}

/// Whether the signatures of two candidates point the same way.
fn alike(screened: &[Screened], a: usize, b: usize) -> bool {
    let of = |k: usize| screened.iter().find(|s| s.candidate == k);
    match (of(a), of(b)) {
        (Some(a), Some(b)) => a.signature.cosine(&b.signature).abs() > super::screening::CONFUSABLE,
        _ => false,
    }
}

/// Refits the leaders, those that look like the first of them, and the best pair.
fn confirm(
    setup: Setup,
    candidates: &[Candidate],
    leaders: &[&Screened],
    plain: &Fit,
    noise: &NoiseModel,
    effort: Effort,
    say: &mut dyn FnMut(String),
) -> Result<Vec<Refit>, DiagnosisError> {
    let y = &plain.linear.residual;
    let expected = |s: &Screened| (s.candidate, s.signature.magnitude(y).0);
    let count = if effort.quick { QUICK_LEADERS } else { LEADERS };
    let evidence = |s: &Screened| linear_evidence(&candidates[s.candidate], &s.signature, plain);
    // The first is refitted in any case: its signature is that of a finite magnitude, not of the best one.
    let promising = leaders.iter().enumerate().filter(|(k, s)| *k == 0 || evidence(s) > 0.0);
    let mut chosen: Vec<&Screened> = promising.map(|(_, s)| *s).take(TRIED).collect();
    if let (Some(first), false) = (leaders.first(), effort.quick) {
        let mates = leaders.iter().copied().skip(chosen.len());
        chosen.extend(
            mates.filter(|s| first.signature.cosine(&s.signature).abs() > super::screening::CONFUSABLE),
        );
    }
    let mut refits: Vec<Refit> = Vec::new();
    let mut try_one = |members: &[(usize, f64)], refits: &mut Vec<Refit>| -> Result<(), DiagnosisError> {
        let names: Vec<&str> = members.iter().map(|(k, _)| candidates[*k].name.as_str()).collect();
        say(format!("refit with {}", names.join(" and ")));
        match refit(setup, candidates, members, plain, &noise.covariance, effort.evaluations, &mut |_| {}) {
            Ok(found) => refits.push(found),
            Err(FitFailure::Evaluation(EvaluationFailure::Interrupted)) => {
                return Err(EvaluationFailure::Interrupted.into());
            }
            // A model that cannot be computed with this effect is no competitor.
            Err(_) => {}
        }
        Ok(())
    };
    for (k, leader) in chosen.iter().enumerate() {
        // Beyond the leaders the search goes on only while nothing explains the gap: signatures are those of a
        // plain fit that misses it, and the larger the gap, the less they say.
        if k >= count && refits.iter().any(|r| r.adequacy > SIGNIFICANT) {
            break;
        }
        let gain = leader.signature.score(y).powi(2);
        let explained = |r: &Refit| r.adequacy > SIGNIFICANT && gain < HOPELESS * r.gain;
        if !refits.iter().any(explained) {
            try_one(&[expected(leader)], &mut refits)?;
        }
    }
    if !effort.quick {
        let pairs = (0..leaders.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let different = |&(i, j): &(usize, usize)| {
            let family = |k: usize| &candidates[leaders[k].candidate].effect.family;
            family(i) != family(j)
                && leaders[i].signature.cosine(&leaders[j].signature).abs() < super::screening::CONFUSABLE
        };
        let scored =
            pairs.filter(different).map(|(i, j)| (pair_evidence(leaders[i], leaders[j], plain), i, j));
        let best_single = refits.iter().map(|r| r.evidence).fold(f64::NEG_INFINITY, f64::max);
        let best = scored.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|p| p.0 > best_single + PAIR_GAIN);
        if let Some((_, i, j)) = best {
            try_one(&[expected(leaders[i]), expected(leaders[j])], &mut refits)?;
        }
    }
    Ok(refits)
}

/// Whether held-out data accept a model: the sum over the splits that determine it.
fn accepted(plain: &Fit, refit: &Refit, splits: &[Split]) -> Option<bool> {
    let comparisons = splits.iter().filter_map(|s| Comparison::new(plain, &refit.fit, s));
    let scores: Vec<f64> = comparisons.filter(|c| c.informative).map(|c| c.score).collect();
    (!scores.is_empty()).then(|| scores.iter().sum::<f64>() > 0.0)
}
