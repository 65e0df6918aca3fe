//! The choice of the effect, repeated without what is to be predicted: what has been chosen with the help of some data is not tested by
//! predicting them.

use super::confirming::Refit;
use super::held_out::Split;
use super::thresholds::Thresholds;
use crate::inference::effect::Candidate;

/// Of some refits, the place of the one that the fitted part of a split alone makes most likely; `None` where it determines none of them.
/// That there is a gap at all is taken from all of the data: with less of them, less is seen.
pub fn chosen_without(
    refits: &[Refit],
    candidates: &[Candidate],
    split: &Split,
    thresholds: &Thresholds,
) -> Option<usize> {
    let weight = |refit: &Refit| {
        let active = refit.active(candidates);
        let odds = if active.len() > 1 { thresholds.complexity } else { 0.0 };
        Some(refit.fit.refitted_to(&split.fitted)?.evidence(&active) - odds)
    };
    let weighed = refits.iter().enumerate().filter_map(|(k, refit)| Some((weight(refit)?, k)));
    weighed.max_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, k)| k)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::something_else::SomethingElse;
    use crate::fit::{Prior, Solution};
    use crate::inference::effect::tests::effect;
    use crate::inference::effect::{Scope, Sign};
    use crate::inference::fit::{End, Fit, linearised};
    use crate::noise::Covariance;
    use nalgebra::{DMatrix, DVector};

    const HALF: usize = 20;

    /// Least squares of `measured = a + m shape` with white noise of 1.
    fn refit(member: usize, measured: &DVector<f64>, shape: impl Fn(usize) -> f64) -> Refit {
        let jacobian_mn = DMatrix::from_fn(2 * HALF, 2, |i, j| if j == 0 { 1.0 } else { shape(i) });
        let x =
            (jacobian_mn.transpose() * &jacobian_mn).try_inverse().unwrap() * jacobian_mn.tr_mul(measured);
        let gap_mn = measured - &jacobian_mn * &x;
        let covariance = Covariance::new(DVector::from_element(2 * HALF, 1.0), vec![]);
        let prior = Prior { mean: vec![0.0; 2], deviation: vec![1e3; 2] };
        let linear = linearised(&jacobian_mn, &gap_mn, &covariance, &prior, x.as_slice());
        let mut solution =
            Solution::at_once(x.as_slice().to_vec(), gap_mn.as_slice().to_vec(), jacobian_mn.clone());
        solution.chi_square = gap_mn.norm_squared();
        let fit = Fit {
            solution,
            linear,
            gap_mn,
            jacobian_mn,
            parameters: 1,
            prior,
            covariance,
            end: End::Minimum,
        };
        let remainder = SomethingElse { evidence: 0.0, explained: 0.0, smooth: DVector::zeros(0) };
        let (evidence, gain, adequacy) = (0.0, 0.0, 1.0);
        Refit {
            members: vec![member],
            alternatives: vec![],
            fit,
            evidence,
            gain,
            remainder,
            adequacy,
            may_leave: 0.5,
            leaves_little: true,
        }
    }

    /// A step early in the first half and a larger one early in the second: each half alone chooses the effect that makes its own.
    #[test]
    fn each_part_chooses_by_itself() {
        let is_early = |i: usize, half: usize| f64::from(u8::from(i / HALF == half && i % HALF < HALF / 2));
        let measured = DVector::from_fn(2 * HALF, |i, _| 4.0 * is_early(i, 0) + 9.0 * is_early(i, 1));
        let refits = [0, 1].map(|half| refit(half, &measured, |i| is_early(i, half)));
        let candidates = Candidate::of(
            &[effect(Scope::Shared, Sign::Either), effect(Scope::Shared, Sign::Either)],
            &["P1".to_owned()],
        );
        let chosen = |fitted: std::ops::Range<usize>| {
            let predicted = (0..2 * HALF).filter(|i| !fitted.contains(i)).collect();
            let split = Split { name: String::new(), fitted: fitted.collect(), predicted, is_of_tests: true };
            chosen_without(&refits, &candidates, &split, &Thresholds::default()).unwrap()
        };
        assert_eq!([chosen(0..HALF), chosen(HALF..2 * HALF), chosen(0..2 * HALF)], [0, 1, 1]);
    }

    /// The linearised refit is the fit where the model is linear.
    #[test]
    fn a_refit_to_a_part_is_its_least_squares() {
        let measured = DVector::from_fn(2 * HALF, |i, _| if i < HALF { 1.0 + 2.0 * i as f64 } else { 7.0 });
        let fit = refit(0, &measured, |i| i as f64).fit.refitted_to(&(0..HALF).collect::<Vec<_>>()).unwrap();
        assert!((fit.solution.x[0] - 1.0).abs() < 1e-3 && (fit.solution.x[1] - 2.0).abs() < 1e-3);
        assert!(fit.gap_mn.amax() < 1e-2 && fit.solution.chi_square < 1e-2);
    }
}
