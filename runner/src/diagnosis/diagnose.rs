//! The nine steps, one after the other.

use super::catalogue::{LeftOut, effects};
use super::confirming::Refit;
use super::experiments::{Proposal, proposals, rivals};
use super::gap::gap_percent;
use super::held_out::{Split, splits};
use super::leftover::{Leftover, leftover};
use super::nested::chosen_without;
use super::plain_start::PlainStarts;
use super::result::Kind;
use super::round::{Asked, Round, linear_evidence};
use super::screening::Screened;
use super::shrinkage::Comparison;
use super::size::Size;
use super::thresholds::Thresholds;
use super::true_force::draws_of_noise_mn;
use super::verdict::{Decision, Evidence, decide};
use crate::engine::Engine;
use crate::fit::EvaluationFailure;
use crate::inference::Setup;
use crate::inference::Unknowns;
use crate::inference::effect::{Candidate, Effect};
use crate::inference::fit::{Fit, FitFailure, ROUGH};
use crate::inference::rough::Twin;
use crate::inference::{NoiseFailure, noise_at};
use crate::noise::ObservationError;
use crate::noise::{NoiseModel, Observation, Weights};
use crate::pool::Priority;
use nalgebra::DVector;
use thiserror::Error;

/// How thorough the diagnosis is, and what is worth an answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Screening, and refits of the leaders only.
    pub quick: bool,
    /// Largest number of evaluations of a fit.
    pub evaluations: usize,
    /// A gap of a smaller part of the peak does not matter (%).
    pub matters_percent: f64,
    /// What decides.
    pub thresholds: Thresholds,
}

/// A diagnosis that cannot be made.
#[derive(Debug, Error)]
pub enum DiagnosisError {
    /// A measurement.
    #[error(transparent)]
    Dataset(#[from] ObservationError),
    /// The plain model cannot be fitted.
    #[error("the plain model cannot be fitted: {0}")]
    Baseline(FitFailure),
    /// The model fails beside the fit.
    #[error("the model fails at the fitted parameters: {0}")]
    Model(#[from] EvaluationFailure),
}

impl From<NoiseFailure> for DiagnosisError {
    fn from(failure: NoiseFailure) -> Self {
        match failure {
            NoiseFailure::Observation(error) => Self::Dataset(error),
            NoiseFailure::Evaluation(error) => Self::Model(error),
        }
    }
}

/// Everything that was found, before it is put into words.
pub struct Findings {
    /// Tests, as far as they were used.
    pub observations: Vec<Observation>,
    /// Their noise.
    pub noise: NoiseModel,
    /// What was asked about.
    pub candidates: Vec<Candidate>,
    /// Effects that were not screened.
    pub left_out: Vec<LeftOut>,
    /// The plain model's fit, and what can be said around it.
    pub round: Round,
    /// Parts that can be predicted from the rest, with the place of the refit that the rest alone would choose.
    pub splits: Vec<(Split, Option<usize>)>,
    /// What decided.
    pub thresholds: Thresholds,
    /// What is told.
    pub conclusion: Conclusion,
}

/// The answer, and what is told with it.
pub struct Conclusion {
    /// The answer.
    pub decision: Decision,
    /// Largest mean difference between data and plain model over half a decade of the time since any kink of the motion, as part of
    /// its test's largest force (%); where it does not matter, of what explains it instead of the data.
    pub gap_percent: f64,
    /// What a gap looks like that nothing explains.
    pub leftover: Option<Leftover>,
    /// Tests that would tell the members of a group apart, the best first.
    pub proposals: Vec<Proposal>,
}

/// What is known beside the tests.
#[derive(Debug, Clone, Copy, Default)]
pub struct Given<'a> {
    /// Height of the sample (m).
    pub sample_height_m: Option<f64>,
    /// The user's effects beside the catalogue's.
    pub declared: &'a [Effect],
}

/// Makes the diagnosis; `say` hears what is being done.
///
/// # Errors
/// When the plain model cannot be fitted, or the user asked to stop.
pub fn diagnose(
    engine: &Engine,
    observations: Vec<Observation>,
    starts: &PlainStarts,
    given: Given<'_>,
    effort: Effort,
    say: &mut dyn FnMut(String),
) -> Result<Findings, DiagnosisError> {
    let Given { sample_height_m, declared } = given;
    let unknowns = &starts.unknowns;
    let observations = computable(engine, observations, unknowns, sample_height_m)?;
    let setup = Setup::new(engine, &observations, unknowns);
    let weights = Weights::default();
    let names: Vec<String> = observations.iter().map(|o| o.name().to_owned()).collect();
    let (mut effects, left_out) = effects(engine.wiring(), Size::of(setup));
    effects.extend_from_slice(declared);
    let candidates = Candidate::of(&effects, &names);
    let effect_count = effects.len();
    let asked = |noise| Asked { setup, starts, candidates: &candidates, rivals: effect_count, noise, effort };
    // The error of the simulation is that of the fitted material, which the start may be far from.
    let coarser = Twin::coarser(setup, &candidates);
    let stand_in = Twin::setup_or(coarser.as_ref(), setup);
    let rough = noise_at(stand_in, unknowns.start(), &weights, false)?;
    let points: usize = observations.iter().map(|o| o.time_s.len()).sum();
    let mut least = f64::INFINITY;
    let mut start = unknowns.start().to_vec();
    let mut untried = starts.all();
    while least > MEETS * points as f64
        && let Some(from) = untried.next()
    {
        if let Some((end, chi_square)) = asked(&rough).plain_end(stand_in, (from, least), say)? {
            (start, least) = (end, chi_square);
        }
    }
    let noise = noise_at(setup, &start, &weights, true)?;
    let asked = asked(&noise);
    let mut round = asked.look(asked.plain(&start, say)?, say)?;
    // What no start closes is a gap.
    while round.has_gap(effort.thresholds.significant)
        && let Some(from) = untried.next()
    {
        let below = round.plain.solution.chi_square - LOWER;
        if let Some(lower) = asked.lower_plain(&round.plain, (from, below), say)? {
            round = asked.look(lower, say)?;
        }
    }
    let mut round = asked.refitted(round, say)?;
    // The plain model has to be fitted as well as its rivals are: from where the best of them ended, too. What is lower by a small part
    // of what that effect gained changes no answer.
    if let Some(leader) = round.refits.first() {
        let lower = round.plain.solution.chi_square - LOWER.max(ROUGH * leader.gain);
        if let Some(again) = asked.lower_plain(&round.plain, (leader.fit.x(), lower), say)? {
            round = asked.round_again(round, again, say)?;
        }
    }
    let Round { plain, screened, refits, .. } = &round;
    let thresholds = effort.thresholds;
    let y = &plain.linear.residual;
    let chosen = |split| {
        let refit = chosen_without(refits, &candidates, &split, &thresholds);
        (split, refit)
    };
    let splits: Vec<(Split, Option<usize>)> = splits(&observations).into_iter().map(chosen).collect();
    let alike = |a: usize, b: usize| alike(screened, a, b);
    let same = |a: usize, b: usize| candidates[a].effect.family == candidates[b].effect.family;
    let mates = |leader: usize| mates(&candidates, screened, refits, y, leader, thresholds.decisive);
    let compared: Vec<Vec<Comparison>> =
        refits.iter().map(|r| comparisons(plain, r, &splits, &candidates, &thresholds)).collect();
    let held_out = |r: &Refit| {
        let own = refits.iter().zip(&compared).find(|(other, _)| other.members == r.members);
        own.map_or(&[][..], |(_, comparisons)| comparisons)
    };
    let accepted = |r: &Refit| accepted(held_out(r));
    let percent = |difference_mn: &DVector<f64>| gap_percent(&observations, difference_mn);
    let gap_percent = percent(&plain.gap_mn);
    // What is beyond the gap, as errors that points share are of the other sign there, is not explained.
    let explained = |r: &Refit| percent(&(&plain.gap_mn - &r.fit.gap_mn)).min(gap_percent);
    let explained_of_what_matters = |r: &Refit| explained(r) / effort.matters_percent;
    // Data that helped to choose a model do not confirm it.
    let is_chosen_without = |r: &Refit, c: &&Comparison| {
        let is_alike = |chosen: usize| match (&refits[chosen].members[..], &r.members[..]) {
            ([a], [b]) => a == b || alike(*a, *b),
            (one, other) => one == other,
        };
        let chosen = splits.iter().find(|(split, _)| split == c.split()).and_then(|(_, chosen)| *chosen);
        chosen.is_some_and(is_alike)
    };
    let removed = |r: &Refit| {
        let mut nested = held_out(r).iter().filter(|c| is_chosen_without(r, c)).peekable();
        nested.peek()?;
        let noises_mn = draws_of_noise_mn(r, &observations, &candidates, thresholds.form);
        let surely = |c: &Comparison| c.surely_removes(1.0 - thresholds.rest, &noises_mn);
        nested.filter_map(surely).reduce(|any, one| any || one)
    };
    let decision = decide(&Evidence {
        thresholds,
        is_small: round.is_small(effort.matters_percent),
        explained: &explained_of_what_matters,
        removed: &removed,
        probability: round.significance.probability,
        is_flagrant: round.significance.flagrant,
        rivals: effect_count,
        refits,
        something_else: round.something_else.evidence,
        alike: &alike,
        same: &same,
        mates: &mates,
        accepted: &accepted,
    });
    // What is told of a difference that does not matter is what explains it, without the samples' noise, or what known errors leave.
    let gap_percent = if decision.is_immaterial {
        refits
            .iter()
            .find(|r| r.members == decision.unnamed)
            .map_or(round.percent_beside_known_errors, explained)
    } else {
        gap_percent
    };
    let left = (decision.kind == Kind::NoneOfThese).then(|| leftover(&observations, plain)).flatten();
    let surviving = match decision.kind {
        Kind::Group => rivals(refits, &decision.members, &candidates),
        _ => vec![],
    };
    let proposals = proposals(setup, &candidates, &noise, &surviving, sample_height_m)?;
    Ok(Findings {
        noise,
        candidates,
        left_out,
        round,
        thresholds,
        splits,
        conclusion: Conclusion { decision, gap_percent, leftover: left, proposals },
        observations,
    })
}

/// A rough fit with less than this chi^2 per point may meet the data: no other start is tried.
const MEETS: f64 = 1.1;
/// A plain fit with a chi^2 that is lower by this is another one: an effect would be worth as much.
const LOWER: f64 = 1.0;

/// The tests as far as the model can follow them: the whole motion, or the first loading and its hold.
fn computable(
    engine: &Engine,
    observations: Vec<Observation>,
    unknowns: &Unknowns,
    sample_height_m: Option<f64>,
) -> Result<Vec<Observation>, DiagnosisError> {
    let setup = Setup::new(engine, &observations, unknowns);
    let runs = setup.submit(unknowns.start(), &[], false, Priority::Urgent);
    if Setup::computable_forces_mn(&runs)?.is_some() {
        return Ok(observations);
    }
    let shorter = |o: &Observation| o.first_hold(sample_height_m);
    Ok(observations.iter().map(shorter).collect::<Result<_, _>>()?)
}

/// Whether the signatures of two candidates point the same way.
fn alike(screened: &[Screened], a: usize, b: usize) -> bool {
    let of = |k: usize| screened.iter().find(|s| s.candidate == k);
    match (of(a), of(b)) {
        (Some(a), Some(b)) => a.signature.looks_like(&b.signature),
        _ => false,
    }
}

/// Candidates that were not refitted but look like the leader, and would meet the data as well by their signatures.
fn mates(
    candidates: &[Candidate],
    screened: &[Screened],
    refits: &[Refit],
    residual: &DVector<f64>,
    leader: usize,
    decisive: f64,
) -> Vec<usize> {
    let gain = |s: &Screened| s.signature.score(residual).powi(2);
    let Some(own) = screened.iter().find(|s| s.candidate == leader).map(gain) else { return vec![] };
    let is_mate = |s: &&Screened| {
        let refitted = refits.iter().any(|r| r.members == [s.candidate]);
        let promises = linear_evidence(&candidates[s.candidate], &s.signature, residual) > 0.0;
        !refitted && promises && alike(screened, leader, s.candidate) && own - gain(s) < decisive
    };
    screened.iter().filter(is_mate).map(|s| s.candidate).collect()
}

/// Both models' predictions of the data that tell the effects.
fn comparisons(
    plain: &Fit,
    refit: &Refit,
    splits: &[(Split, Option<usize>)],
    candidates: &[Candidate],
    thresholds: &Thresholds,
) -> Vec<Comparison> {
    let all = splits.iter().filter_map(|(s, _)| Comparison::of(plain, refit, s, candidates, thresholds));
    all.filter(|c| c.informative).collect()
}

/// Whether held-out data accept a model: the sum over the splits that determine it.
fn accepted(held_out: &[Comparison]) -> Option<bool> {
    (!held_out.is_empty()).then(|| held_out.iter().map(|c| c.score).sum::<f64>() > 0.0)
}
