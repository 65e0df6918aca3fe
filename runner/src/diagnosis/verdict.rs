//! From significance and evidence to an answer.
//!
//! The gate comes first: unless the largest score of all passes what noise alone gives, there is no gap, whatever the
//! evidence says. Then models compete: every single effect, the refitted pairs, and something else. An effect that
//! leaves a significant rest is no answer unless the rest is a small part of the gap.

use super::confirming::Refit;
use super::result::Kind;
use super::thresholds::Thresholds;

/// Longest list of effects that is an answer: a longer one helps nobody to choose what to measure next.
const MOST_NAMED: usize = 3;
/// Parts of the answers that are right, by `challenge` (README); no answer depends on them. Of those that find a gap, whether it matters or
/// not, as nature keeps to no catalogue's forms, which the evidence does not know (89 of 94, by the rule of succession); of effects that leave
/// more than noise, which is taken for a matter of their form (8 of 11, alike); of those that find no gap.
const RELIABILITY: f64 = 0.94;
const RELIABILITY_BESIDE_A_REST: f64 = 0.7;
const RELIABILITY_OF_NO_GAP: f64 = 0.99;

/// What is weighed.
pub struct Evidence<'a> {
    /// What decides.
    pub thresholds: Thresholds,
    /// Family-wise probability of the largest score under noise.
    pub probability: f64,
    /// Whether the plain model's chi^2 alone shows a gap, wherever it is.
    pub is_flagrant: bool,
    /// Whether what known errors leave of the plain model's gap is smaller than what matters.
    pub is_small: bool,
    /// What a model explains, free of noise, over what matters.
    pub explained: &'a dyn Fn(&Refit) -> f64,
    /// Whether a model, or one that looks like it, would be chosen without some data and surely takes more of their gap than is a matter of
    /// form; `None` where no split determines it, has a gap of its own, and would choose it.
    pub removed: &'a dyn Fn(&Refit) -> Option<bool>,
    /// Effects that were asked about: as many chances to find one that fits noise.
    pub rivals: usize,
    /// Refitted models.
    pub refits: &'a [Refit],
    /// Twice the log evidence of a smooth error against the plain model.
    pub something_else: f64,
    /// Whether two candidates look alike.
    pub alike: &'a dyn Fn(usize, usize) -> bool,
    /// Whether two candidates are forms of one effect.
    pub same: &'a dyn Fn(usize, usize) -> bool,
    /// Candidates that were not refitted, look like this one and would meet the data as well by their signatures.
    pub mates: &'a dyn Fn(usize) -> Vec<usize>,
    /// Whether the held-out data accept a model; `None` where they cannot tell.
    pub accepted: &'a dyn Fn(&Refit) -> Option<bool>,
}

/// Kind of answer, candidates, confidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// Kind.
    pub kind: Kind,
    /// Candidates: best first; after a pair, what would do as well in the place of its second.
    pub members: Vec<usize>,
    /// Less likely ones that look the same and are not named; without a gap that matters, what explains the difference.
    pub unnamed: Vec<usize>,
    /// Whether there is a significant gap, too small to matter.
    pub is_immaterial: bool,
    /// Index of the refit that the answer rests on.
    pub refit: Option<usize>,
    /// Probability that it is right.
    pub confidence: f64,
    /// Posterior probability of each refit, then of something else, then of the plain model.
    pub probabilities: Vec<f64>,
}

/// Twice the log of a refit's evidence times its prior odds; what its rest still offers to something else is added, as
/// a model with both, at the price of something else. A rest that a pair explains by a named effect is no something else's.
fn weight(refit: &Refit, refits: &[Refit], thresholds: &Thresholds) -> f64 {
    let complexity = thresholds.complexity;
    let is_pair = |r: &Refit| r.members.len() > 1;
    let explains_rest =
        |r: &Refit| is_pair(r) && r.members.contains(&refit.members[0]) && r.meets_data(thresholds);
    let is_explained = !is_pair(refit) && refits.iter().any(explains_rest);
    let both = if is_pair(refit) { complexity } else { 0.0 };
    let with_rest = if is_explained { 0.0 } else { (refit.remainder.evidence - complexity).max(0.0) };
    refit.evidence - both + with_rest
}

/// Appends candidates: of the forms of one effect the best is named.
fn add_distinct(
    members: &mut Vec<usize>,
    candidates: impl Iterator<Item = usize>,
    same: &dyn Fn(usize, usize) -> bool,
) {
    for candidate in candidates {
        if !members.iter().any(|&m| same(m, candidate)) {
            members.push(candidate);
        }
    }
}

/// Twice the log of the prior odds against one of so many effects. Half of all cases have no gap before anything is measured, and the effects
/// share the other half: these are the plain model's odds, too.
pub fn weight_of_one_among(rivals: usize) -> f64 {
    2.0 * (rivals.max(1) as f64).ln()
}

/// Twice the log of what something outside the catalogue weighs by its evidence.
pub fn weight_of_something_else(evidence: f64, thresholds: &Thresholds) -> f64 {
    evidence - thresholds.complexity
}

/// Whether something outside the catalogue that weighs so much is told of a gap that is smaller than what matters.
pub fn is_told_of_a_small_gap(something_else: f64, rivals: usize, thresholds: &Thresholds) -> bool {
    something_else >= weight_of_one_among(rivals) + thresholds.decisive
}

/// Decides.
pub fn decide(e: &Evidence) -> Decision {
    let Thresholds { significant, inadequate, decisive, immaterial, .. } = e.thresholds;
    let mut weights: Vec<f64> = e.refits.iter().map(|r| weight(r, e.refits, &e.thresholds)).collect();
    // Where a single effect leaves nothing but noise, something else cannot be more likely: a smooth error of any shape
    // fits whatever an effect of an unexpected size does.
    let adequate =
        weights.iter().zip(e.refits).filter(|(_, r)| r.leaves_noise(significant) && r.members.len() == 1);
    let bound = adequate.map(|(w, _)| *w).reduce(f64::max).unwrap_or(f64::INFINITY);
    let elsewhere = bound.min(weight_of_something_else(e.something_else, &e.thresholds));
    weights.push(elsewhere);
    let plain = weight_of_one_among(e.rivals);
    weights.push(plain);
    let top = weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let shares: Vec<f64> = weights.iter().map(|w| (0.5 * (w - top)).exp()).collect();
    let sum: f64 = shares.iter().sum();
    let probabilities: Vec<f64> = shares.iter().map(|s| s / sum).collect();
    let told = |kind, members, refit, confidence: f64, reliability: f64| Decision {
        kind,
        members,
        unnamed: vec![],
        is_immaterial: false,
        refit,
        confidence: confidence.clamp(0.01, 1.0) * reliability,
        probabilities: probabilities.clone(),
    };
    let no_gap = |confidence| told(Kind::NoGap, vec![], None, confidence, RELIABILITY_OF_NO_GAP);
    let decision = |kind, members, refit: Option<usize>, confidence| {
        let leaves_a_rest = refit.is_some_and(|k| !e.refits[k].leaves_noise(inadequate));
        let reliability = if leaves_a_rest { RELIABILITY_BESIDE_A_REST } else { RELIABILITY };
        told(kind, members, refit, confidence, reliability)
    };
    let without_matter = |unnamed, confidence| Decision {
        unnamed,
        is_immaterial: true,
        ..decision(Kind::NoGap, vec![], None, confidence)
    };
    if e.probability > significant {
        // What somebody could see is three deviations above what noise passes once in twenty cases.
        return no_gap(1.0);
    }
    let explains = |r: &Refit| r.meets_data(&e.thresholds) && (e.accepted)(r) != Some(false);
    let mut order: Vec<usize> = (0..e.refits.len()).collect();
    order.sort_by(|a, b| weights[*b].total_cmp(&weights[*a]));
    let elsewhere_share = probabilities[e.refits.len()];
    let best = order.iter().copied().find(|&k| explains(&e.refits[k]) && weights[k] >= elsewhere);
    let strongest = best.map_or(elsewhere, |k| weights[k]);
    if plain > strongest && !e.is_flagrant {
        // What does not explain the data is no rival.
        let rivals: f64 = order.iter().filter(|&&k| explains(&e.refits[k])).map(|&k| probabilities[k]).sum();
        let own = probabilities[e.refits.len() + 1];
        return no_gap(own / (own + rivals + elsewhere_share));
    }
    // What two correct programs leave of one another is no finding about the specimen, nor is what does not matter.
    let is_doubtful = |k: &usize| {
        let refit = &e.refits[*k];
        (e.explained)(refit) < immaterial && (e.removed)(refit) != Some(true)
    };
    if let Some(k) = best.filter(is_doubtful) {
        return without_matter(e.refits[k].members.clone(), 1.0);
    }
    let Some(best) = best else {
        let explained: f64 =
            order.iter().filter(|&&k| explains(&e.refits[k])).map(|&k| probabilities[k]).sum();
        let confidence = (1.0 - explained) * (1.0 - e.probability);
        if e.is_small && !is_told_of_a_small_gap(elsewhere, e.rivals, &e.thresholds) {
            // Hardly a smooth error of any shape: the samples scatter more than their noise says, or what is elsewhere does not matter.
            return without_matter(vec![], confidence);
        }
        return decision(Kind::NoneOfThese, vec![], None, confidence);
    };
    let refit = &e.refits[best];
    if refit.members.len() > 1 {
        let mut members = refit.members.clone();
        add_distinct(&mut members, refit.alternatives.iter().copied(), e.same);
        // The second and what would do as well in its place are the group.
        let unnamed = members.split_off(members.len().min(1 + MOST_NAMED));
        return Decision { unnamed, ..decision(Kind::Pair, members, Some(best), probabilities[best]) };
    }
    let leader = refit.members[0];
    let rival = |k: &usize| {
        let r = &e.refits[*k];
        let is_alike = (e.alike)(leader, r.members[0]);
        let near = weights[best] - weights[*k] < decisive;
        // What size an effect may have is a matter of opinion: one that looks the same and meets the data as well stays in the group.
        let as_good = is_alike && r.fit.misfit() - refit.fit.misfit() < decisive;
        // What leaves a rest, but is more likely with it, is not ruled out by its form.
        let more_likely = weights[*k] > weights[best] && (e.accepted)(r) != Some(false);
        r.members.len() == 1 && *k != best && (as_good || more_likely || near && (explains(r) || is_alike))
    };
    let rivals: Vec<usize> = order.iter().copied().filter(rival).collect();
    let mut members = vec![leader];
    let others = rivals.iter().map(|&k| e.refits[k].members[0]).chain((e.mates)(leader));
    add_distinct(&mut members, others, e.same);
    let unnamed = members.split_off(members.len().min(MOST_NAMED));
    let named = |k: &&usize| members.iter().any(|&m| (e.same)(m, e.refits[**k].members[0]));
    let confidence: f64 =
        probabilities[best] + rivals.iter().filter(named).map(|&k| probabilities[k]).sum::<f64>();
    let kind = if members.len() > 1 { Kind::Group } else { Kind::Effect };
    Decision { unnamed, ..decision(kind, members, Some(best), confidence * (1.0 - e.probability)) }
}
