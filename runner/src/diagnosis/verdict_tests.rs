//! From numbers to answers.

use super::confirming::Refit;
use super::result::Kind;
use super::something_else::SomethingElse;
use super::thresholds::Thresholds;
use super::verdict::{Decision, Evidence, decide};
use crate::fit::{Prior, Solution};
use crate::inference::Linearised;
use crate::inference::fit::{End, Fit};
use crate::noise::Covariance;
use nalgebra::{DMatrix, DVector};

/// A single effect of magnitude 1 that leaves noise, with this much evidence.
pub(super) fn refit(candidate: usize, evidence: f64) -> Refit {
    let (none, one) = (DVector::zeros(1), DMatrix::from_element(1, 1, 1.0));
    let mut solution = Solution::at_once(vec![1.0], vec![1.0], one.clone());
    solution.chi_square = 100.0 - evidence;
    let fit = Fit {
        solution,
        linear: Linearised::new(DMatrix::from_element(2, 1, 1.0), &DVector::zeros(2)),
        gap_mn: none.clone(),
        jacobian_mn: one,
        parameters: 0,
        prior: Prior { mean: vec![0.0], deviation: vec![2.0] },
        covariance: Covariance::new(DVector::from_element(1, 1.0), vec![]),
        end: End::Minimum,
    };
    let remainder = SomethingElse { evidence: 0.0, explained: 0.0, smooth: none };
    Refit {
        members: vec![candidate],
        alternatives: vec![],
        fit,
        evidence,
        gain: evidence,
        remainder,
        adequacy: 0.5,
        may_leave: 0.5,
        leaves_little: true,
    }
}

/// What is weighed between `refits`; candidates 10 and 11 are forms of one effect.
fn evidence(refits: &[Refit], probability: f64, something_else: f64) -> Evidence<'_> {
    Evidence {
        thresholds: Thresholds::default(),
        probability,
        is_flagrant: false,
        is_small: false,
        explained: &|_| 5.0,
        removed: &|_| None,
        rivals: 2,
        refits,
        something_else,
        alike: &|_, _| true,
        same: &|a, b| a.min(10) == b.min(10),
        mates: &|_| vec![],
        accepted: &|_| None,
    }
}

/// Decides between them; `mates` were not refitted.
fn decided(refits: &[Refit], mates: &[usize], probability: f64, something_else: f64) -> Decision {
    decide(&Evidence { mates: &|_| mates.to_vec(), ..evidence(refits, probability, something_else) })
}

#[test]
fn what_noise_gives_is_no_gap_whatever_the_evidence() {
    let d = decided(&[refit(1, 100.0)], &[], 0.2, 0.0);
    assert_eq!((d.kind, d.members), (Kind::NoGap, vec![]));
}

#[test]
fn something_else_wins_only_over_what_does_not_explain() {
    let d = decided(&[refit(1, 20.0)], &[], 0.0, 100.0);
    assert_eq!((d.kind, d.members), (Kind::Effect, vec![1]));
    let poor = Refit { adequacy: 1e-6, leaves_little: false, ..refit(1, 20.0) };
    assert_eq!(decided(&[poor], &[], 0.0, 100.0).kind, Kind::NoneOfThese);
}

/// A refit that does not meet the data, however much better than the plain model, takes nothing from "no gap".
#[test]
fn what_does_not_explain_is_no_rival_of_no_gap() {
    let poor = Refit { adequacy: 1e-6, leaves_little: false, ..refit(1, 20.0) };
    let d = decided(&[poor], &[], 0.01, -60.0);
    assert!(d.kind == Kind::NoGap && d.confidence > 0.95, "{d:?}");
}

#[test]
fn near_rivals_are_a_group_and_far_ones_are_not() {
    let d = decided(&[refit(1, 20.0), refit(2, 18.0), refit(3, 2.0)], &[], 0.0, 0.0);
    assert_eq!((d.kind, d.members), (Kind::Group, vec![1, 2]));
}

/// What leaves more than noise, but is more likely with what its rest offers to something else, is named beside what leaves noise.
#[test]
fn what_is_more_likely_with_its_rest_is_in_the_group() {
    let with_rest = |offered: f64| {
        let mut poor = Refit { adequacy: 1e-3, leaves_little: false, ..refit(2, 18.0) };
        poor.remainder.evidence = offered;
        let found = [refit(1, 20.0), poor];
        let d = decide(&Evidence { alike: &|_, _| false, ..evidence(&found, 0.0, 0.0) });
        (d.kind, d.members, d.confidence > 0.5)
    };
    assert_eq!(with_rest(16.0), (Kind::Group, vec![1, 2], true));
    assert_eq!(with_rest(0.0), (Kind::Effect, vec![1], true));
}

/// What an effect leaves may be a matter of its form, or of another cause: that is less sure.
#[test]
fn an_answer_that_leaves_more_than_noise_is_less_sure() {
    let sure = |adequacy: f64| decided(&[Refit { adequacy, ..refit(1, 60.0) }], &[], 0.0, 0.0).confidence;
    assert!(sure(0.02) > 0.9 && (0.6..0.8).contains(&sure(1e-6)), "{} {}", sure(0.02), sure(1e-6));
}

/// What a second effect explains of the first one's rest is no evidence for something else beside the first.
#[test]
fn a_rest_that_a_pair_explains_is_no_something_elses() {
    let mut single = Refit { adequacy: 1e-6, ..refit(1, 60.0) };
    single.remainder.evidence = 50.0;
    let told = |members: &[usize], adequacy: f64, leaves_little: bool| {
        let pair = Refit { members: members.to_vec(), adequacy, leaves_little, ..refit(1, 90.0) };
        let d = decided(&[pair, single.clone()], &[], 0.0, 0.0);
        (d.kind, d.members)
    };
    assert_eq!(told(&[1, 2], 0.02, false), (Kind::Pair, vec![1, 2]));
    assert_eq!(told(&[2, 1], 1e-6, true), (Kind::Pair, vec![2, 1]));
    // One that explains it no better, and one of other effects.
    assert_eq!(told(&[1, 2], 1e-6, false), (Kind::Effect, vec![1]));
    assert_eq!(told(&[2, 3], 0.02, false), (Kind::Effect, vec![1]));
}

/// A rival of an unlikely size that meets the data as well stays in the group, as the last; one that meets them worse does not.
#[test]
fn a_size_that_nobody_expects_leaves_an_effect_in_its_group() {
    let sized = |size: f64, chi_square: f64| {
        let mut found = refit(2, 5.0);
        // A size of 6 at a prior deviation of 2 adds 9 to chi^2.
        (found.fit.solution.x, found.fit.solution.chi_square) = (vec![size], chi_square);
        let d = decided(&[refit(1, 20.0), found], &[], 0.0, 0.0);
        (d.kind, d.members)
    };
    assert_eq!(sized(6.0, 89.0), (Kind::Group, vec![1, 2]));
    assert_eq!(sized(1.0, 89.0), (Kind::Effect, vec![1]));
}

/// The forms of an effect, refitted or not, are named once.
#[test]
fn an_effect_is_named_once() {
    let forms = [refit(10, 20.0), refit(11, 19.0)];
    let d = decided(&forms, &[], 0.0, 0.0);
    assert_eq!((d.kind, d.members), (Kind::Effect, vec![10]));
    assert!(d.confidence > 0.8, "the other form's probability is the effect's: {}", d.confidence);
    let d = decided(&forms[..1], &[11], 0.0, 0.0);
    assert_eq!((d.kind, d.members), (Kind::Effect, vec![10]));
    let d = decided(&forms[..1], &[11, 4], 0.0, 0.0);
    assert_eq!((d.kind, d.members), (Kind::Group, vec![10, 4]));
}

/// What would do as well in the place of a pair's second is named after it, and told where that is more than three.
#[test]
fn a_pairs_second_may_be_one_of_several() {
    let pair = |alternatives: &[usize]| {
        let found = Refit { members: vec![1, 2], alternatives: alternatives.to_vec(), ..refit(1, 40.0) };
        let d = decided(&[found], &[7], 0.0, 0.0);
        (d.kind, d.members, d.unnamed)
    };
    assert_eq!(pair(&[]), (Kind::Pair, vec![1, 2], vec![]));
    // 10 and 11 are forms of one effect.
    assert_eq!(pair(&[10, 11, 4, 5]), (Kind::Pair, vec![1, 2, 10, 4], vec![5]));
}

/// The three most likely are named, the others told, and the confidence is that of what is named.
#[test]
fn a_group_is_no_longer_than_three() {
    let five: Vec<Refit> = (1..=5).map(|k| refit(k, 20.0)).collect();
    let d = decided(&five, &[6], 0.0, 0.0);
    assert_eq!((d.kind, d.members, d.unnamed), (Kind::Group, vec![1, 2, 3], vec![4, 5, 6]));
    let two = decided(&five[..2], &[], 0.0, 0.0);
    approx::assert_relative_eq!(d.confidence, 0.6 * two.confidence, max_relative = 0.02);
}

/// An effect that explains less than two correct programs differ by is not accused unless it predicts what was not fitted.
#[test]
fn what_explains_too_little_to_matter_is_accused_only_where_it_predicts() {
    let small = |explained: f64, removed: Option<bool>| {
        let found = [refit(4, 200.0)];
        let (explained, removed) = (|_: &Refit| explained, |_: &Refit| removed);
        let evidence = Evidence { explained: &explained, removed: &removed, ..evidence(&found, 0.0, 0.0) };
        let d = decide(&evidence);
        (d.kind, d.members, d.unnamed, d.is_immaterial)
    };
    let (nothing, accused) = ((Kind::NoGap, vec![], vec![4], true), (Kind::Effect, vec![4], vec![], false));
    assert_eq!(small(0.5, Some(false)), nothing);
    assert_eq!(small(0.5, Some(true)), accused);
    assert_eq!(small(0.8, Some(false)), accused);
    // One test of one cycle leaves nothing to predict.
    assert_eq!(small(0.5, None), nothing);
    assert_eq!(small(0.8, None), accused);
    let unexplained = |is_small, shape| decide(&Evidence { is_small, ..evidence(&[], 0.0, shape) });
    assert_eq!(unexplained(true, 100.0).kind, Kind::NoneOfThese);
    // Something else at odds of ten, before its price: enough for a gap that matters only.
    let Thresholds { decisive, complexity, .. } = Thresholds::default();
    let weak = 2.0 * (evidence(&[], 0.0, 0.0).rivals as f64).ln() + complexity + 0.8 * decisive;
    assert_eq!(unexplained(false, weak).kind, Kind::NoneOfThese);
    assert_eq!((unexplained(true, weak).kind, unexplained(true, weak).is_immaterial), (Kind::NoGap, true));
    let flagrant = |is_small| decide(&Evidence { is_small, is_flagrant: true, ..evidence(&[], 0.0, -5.0) });
    assert_eq!(flagrant(false).kind, Kind::NoneOfThese);
    assert_eq!((flagrant(true).kind, flagrant(true).is_immaterial), (Kind::NoGap, true));
}
