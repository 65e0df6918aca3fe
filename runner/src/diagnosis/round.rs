//! A fit of the plain model, and what can be said around it: signatures, significance, refits.

use super::confirming::{Refit, whole};
use super::diagnose::{DiagnosisError, Effort};
use super::gap::percent_beside_known_errors;
use super::location::{Spot, spots};
use super::plain_start::PlainStarts;
use super::screening::{Failed, Family, Screened, Screening};
use super::search::Search;
use super::something_else::{SomethingElse, something_else};
use super::unsure_noise::UnsureNoise;
use super::verdict::{is_told_of_a_small_gap, weight_of_something_else};
use crate::fit::{EvaluationFailure, IterationRecord};
use crate::inference::effect::{Candidate, is_continuous};
use crate::inference::fit::{Fit, FitPlan, Tangent, chi_squares, fit, foreseen_below};
use crate::inference::rough::{Trust, Twin, coarser_at, leading_at};
use crate::inference::{Setup, Signature};
use crate::noise::{Covariance, NoiseModel};
use nalgebra::DVector;

/// What is asked, whatever the plain model's fit.
pub(super) struct Asked<'a> {
    pub setup: Setup<'a>,
    /// Where fits of the plain model start, and fits with effects besides the plain fit.
    pub starts: &'a PlainStarts,
    pub candidates: &'a [Candidate],
    /// Number of effects that they are forms of.
    pub rivals: usize,
    pub noise: &'a NoiseModel,
    pub effort: Effort,
}

/// A plain fit, and what can be said around it.
pub struct Round {
    /// Fit of the plain model.
    pub plain: Fit,
    /// Candidates with a signature, largest evidence first.
    pub screened: Vec<Screened>,
    /// Those that could not be computed.
    pub failed: Vec<Failed>,
    /// Places where it was looked for misfit.
    pub spots: Vec<Spot>,
    /// Whether there is a gap.
    pub significance: Significance,
    /// What a smooth error of any shape explains.
    pub something_else: SomethingElse,
    /// What known errors leave of the gap: the height of a test's specimens, or an error of the simulation, is none (%).
    pub percent_beside_known_errors: f64,
    /// Models with effects.
    pub refits: Vec<Refit>,
}

/// Whether a fit misses the data by more than noise.
pub struct Significance {
    /// Distribution of the largest score of all under noise.
    pub family: Family,
    /// Family-wise probability of the largest score.
    pub probability: f64,
    /// Whether chi^2 alone shows a gap.
    pub flagrant: bool,
}

impl Round {
    /// Whether there is a gap: more than noise passes so seldom.
    pub fn has_gap(&self, significant: f64) -> bool {
        self.significance.probability <= significant
    }

    /// Whether the gap is smaller than what matters.
    pub fn is_small(&self, matters_percent: f64) -> bool {
        self.percent_beside_known_errors < matters_percent
    }
}

impl Asked<'_> {
    /// Fit of the plain model.
    pub fn plain(&self, start: &[f64], say: &mut dyn FnMut(String)) -> Result<Fit, DiagnosisError> {
        let plan = FitPlan::to_minimum(start, self.effort.evaluations);
        let (setup, covariance) = (self.setup, &self.noise.covariance);
        fit(setup, &[], covariance, &plan, &mut telling(say)).map_err(DiagnosisError::Baseline)
    }

    /// Where it would end by what stands for the model asked for, and about with which chi^2, where that is less than `chi_square`; none where
    /// the model fails at its start, or the one asked for at the end.
    pub fn plain_end(
        &self,
        stand_in: Setup,
        (start, chi_square): (&[f64], f64),
        say: &mut dyn FnMut(String),
    ) -> Result<Option<(Vec<f64>, f64)>, DiagnosisError> {
        let covariance = &self.noise.covariance;
        let (from, say) = ((start, self.effort.evaluations), &mut telling(say));
        let foreseen = foreseen_below(stand_in, covariance, from, chi_square, say);
        let Some((end, foreseen)) = foreseen.map_err(DiagnosisError::Baseline)? else { return Ok(None) };
        let there = chi_squares(self.setup, &[], covariance, std::slice::from_ref(&end))?[0];
        Ok(there.is_some().then_some((end, foreseen)))
    }

    /// The plain model fitted from another start than `fit` came from, where it ends with less than this chi^2.
    pub fn lower_plain(
        &self,
        fit: &Fit,
        (start, chi_square): (&[f64], f64),
        say: &mut dyn FnMut(String),
    ) -> Result<Option<Fit>, DiagnosisError> {
        let coarser = coarser_at(self.setup, self.candidates, fit)?;
        let stand_in = Twin::setup_or(coarser.as_ref(), self.setup);
        let Some((end, _)) = self.plain_end(stand_in, (start, chi_square), say)? else { return Ok(None) };
        let lower = self.plain(&end, say)?;
        Ok(Some(lower).filter(|lower| lower.solution.chi_square < chi_square))
    }

    /// With refits, where there is a gap. The search is the coarsest mesh's, corrected at the plain fit; what may be the answer is carried to
    /// its minimum by the model asked for.
    pub fn refitted(&self, mut round: Round, say: &mut dyn FnMut(String)) -> Result<Round, DiagnosisError> {
        if round.has_gap(self.effort.thresholds.significant) {
            let &Self {
                setup,
                starts,
                candidates,
                rivals,
                noise,
                effort: Effort { quick, evaluations, matters_percent, thresholds },
            } = self;
            let y = &round.plain.linear.residual;
            let threshold = round.significance.family.threshold(thresholds.significant);
            let (plain, gap, covariance) = (&round.plain, &round.something_else, &noise.covariance);
            let coarser = coarser_at(setup, candidates, plain)?;
            let stand_in = Twin::setup_or(coarser.as_ref(), setup);
            let elsewhere = starts
                .hidden
                .iter()
                .filter_map(|x| Elsewhere::at(stand_in, covariance, plain, x).transpose());
            let elsewhere = elsewhere.collect::<Result<Vec<_>, _>>()?;
            let may_show = |s: &&Screened| {
                let candidate = &candidates[s.candidate];
                let largest = candidate.effect.largest;
                is_testable(candidate, &s.signature, s.signature.score(y), threshold)
                    || elsewhere.iter().any(|there| there.signature(s).strength() * largest >= threshold)
            };
            let shown: Vec<&Screened> = round.screened.iter().filter(may_show).collect();
            let elsewhere = &elsewhere;
            let elsewhere_weight = weight_of_something_else(gap.evidence, &thresholds);
            let search = Search {
                setup: stand_in,
                elsewhere,
                further: &starts.further,
                candidates,
                rivals,
                screened: &round.screened,
                shown: &shown,
                plain,
                gap,
                covariance,
                evaluations,
                trust: if coarser.is_some() { Trust::MUCH } else { Trust::LITTLE },
                quick,
                is_negligible: round.is_small(matters_percent)
                    && !is_told_of_a_small_gap(elsewhere_weight, rivals, &thresholds),
                thresholds,
            };
            let found = search.run(say)?;
            round.refits = match coarser {
                Some(_) => Search { setup, ..search }.confirmed(found, say)?,
                None => found,
            };
        }
        Ok(round)
    }

    /// Around a lower plain fit: with the refits of the round before, which contain it, unless it is lower by more than decides.
    pub fn round_again(
        &self,
        before: Round,
        plain: Fit,
        say: &mut dyn FnMut(String),
    ) -> Result<Round, DiagnosisError> {
        let thresholds = self.effort.thresholds;
        let mut round = self.look(plain, say)?;
        if before.plain.solution.chi_square - round.plain.solution.chi_square > thresholds.decisive {
            return self.refitted(round, say);
        }
        if round.has_gap(thresholds.significant) {
            let beside = (&round.plain, &round.something_else);
            let refits = before.refits.into_iter().map(|r| r.beside(&before.plain, beside));
            round.refits = refits.collect();
        }
        Ok(round)
    }

    /// Signatures and significance around a plain fit, without refits.
    pub fn look(&self, plain: Fit, say: &mut dyn FnMut(String)) -> Result<Round, DiagnosisError> {
        let &Self { setup, candidates, effort, .. } = self;
        let observations = setup.observations;
        say(format!("screening {} effects", candidates.len()));
        let (x, fit, covariance) = (plain.x(), &plain.linear, &plain.covariance);
        let screening = Screening { setup, candidates, x, present: &[], fit, whitening: covariance };
        let (mut screened, failed) = screening.screen(0..candidates.len())?;
        let y = &plain.linear.residual;
        let evidence = |s: &Screened| linear_evidence(&candidates[s.candidate], &s.signature, y);
        screened.sort_by(|a, b| evidence(b).total_cmp(&evidence(a)));
        let spots = spots(observations, &plain.linear, covariance);
        let (family, largest) = family(&screened, &spots, candidates, &plain);
        // Noise that is not quite white raises chi^2 a little: that alone is no gap.
        let misfit = whole(&plain);
        let local = family.probability(largest);
        let flagrant = misfit < effort.thresholds.flagrant;
        let probability = if flagrant { local.min(misfit) } else { local };
        say(format!("largest score {largest:.2}, probability under noise {probability:.4}"));
        let something_else = something_else(observations, &plain.linear, covariance);
        let significance = Significance { family, probability, flagrant };
        let percent_beside_known_errors = percent_beside_known_errors(observations, &plain);
        let refits = vec![];
        Ok(Round {
            plain,
            screened,
            failed,
            spots,
            significance,
            something_else,
            percent_beside_known_errors,
            refits,
        })
    }
}

/// Tells of a plain model's fit.
fn telling(say: &mut dyn FnMut(String)) -> impl FnMut(&IterationRecord) {
    |r| say(format!("plain model, iteration {}: chi^2 = {:.1}", r.iteration, r.chi_square))
}

/// Largest score of all effects and places, and its distribution under noise.
fn family(screened: &[Screened], spots: &[Spot], candidates: &[Candidate], plain: &Fit) -> (Family, f64) {
    let y = &plain.linear.residual;
    let mut signatures: Vec<&Signature> = screened.iter().map(|s| &s.signature).collect();
    let mut one_sided: Vec<bool> = screened.iter().map(|s| candidates[s.candidate].is_one_sided()).collect();
    for s in screened {
        signatures.extend(&s.other);
        one_sided.resize(signatures.len(), candidates[s.candidate].is_one_sided());
    }
    signatures.extend(spots.iter().map(|s| &s.signature));
    one_sided.resize(signatures.len(), false);
    let counted = signatures.iter().zip(&one_sided).map(|(s, one)| {
        let z = s.score(y);
        if *one { z } else { z.abs() }
    });
    let largest = counted.fold(0.0, f64::max);
    (Family::new(&signatures, &one_sided, &UnsureNoise::of(plain), 2), largest)
}

/// Twice the log evidence of an effect from its signature alone.
pub fn linear_evidence(candidate: &Candidate, signature: &Signature, residual: &DVector<f64>) -> f64 {
    // A switch, too, is given a magnitude: what is linear at the plain fit is not where the switch is on.
    signature.evidence(residual, candidate.is_one_sided())
}

/// Largest size that a signature may ask for, over the largest that is admissible: at a finite magnitude it is not linear, and
/// the refit keeps to what is admissible.
const NONLINEAR: f64 = 4.0;

/// The plain model linearised elsewhere than at its fit, where fits with effects start, too.
pub struct Elsewhere<'a> {
    /// Parameters.
    pub x: &'a [f64],
    /// chi^2.
    pub chi_square: f64,
    /// Around it.
    pub tangent: Tangent,
}

impl<'a> Elsewhere<'a> {
    /// At `x`; none where the model cannot be computed.
    ///
    /// # Errors
    /// When the user asked to stop.
    pub fn at(
        setup: Setup,
        covariance: &Covariance,
        plain: &Fit,
        x: &'a [f64],
    ) -> Result<Option<Self>, EvaluationFailure> {
        let twin = leading_at(setup, &[], x)?;
        let setup = Twin::setup_or(twin.as_ref(), setup);
        let there = Tangent::at(setup, &[], covariance, &plain.prior, x);
        let Some(tangent) = EvaluationFailure::or_none(there)? else { return Ok(None) };
        let chi_square = chi_squares(setup, &[], covariance, &[x.to_vec()])?[0];
        Ok(chi_square.map(|chi_square| Self { x, chi_square, tangent }))
    }

    /// What of an effect no refit absorbs there.
    pub fn signature(&self, s: &Screened) -> Signature {
        self.tangent.linear.signature(&self.tangent.covariance, &s.change_mn)
    }
}

/// Whether an effect of its plausible scale would pass the threshold in half of all cases, or one of an admissible size does.
pub fn is_testable(candidate: &Candidate, signature: &Signature, score: f64, threshold: f64) -> bool {
    let size = score.abs() / signature.strength();
    let passes = candidate.one_sided(score) >= threshold && size <= NONLINEAR * candidate.effect.largest;
    signature.strength() >= threshold || (passes && is_continuous(candidate))
}
