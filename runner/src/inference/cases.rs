//! Fits that nothing had to be done for: what tests of their statistics are made of.

use super::fit::{End, Fit, linearised};
use super::parameter::{FitParameter, Unit};
use super::unknowns::Unknowns;
use crate::fit::Solution;
use crate::noise::Covariance;
use nalgebra::{DMatrix, DVector};

/// Variables that may be of either sign: names and starts.
pub fn linear(names: &[(&str, f64)]) -> Unknowns {
    let one = |(name, start): &(&str, f64)| {
        FitParameter::new(name, name, Unit::new("", 1.0), *start, [-1e6, 1e6]).unwrap()
    };
    Unknowns::of(names.iter().map(one).collect())
}

/// Variables of one sign: names, starts and bounds.
pub fn positive(names: &[(&str, f64, [f64; 2])]) -> Unknowns {
    let one = |(name, start, bounds): &(&str, f64, [f64; 2])| {
        FitParameter::new(name, name, Unit::new("Pa", 1.0), *start, *bounds).unwrap()
    };
    Unknowns::of(names.iter().map(one).collect())
}

/// A fit that ended where it began, with these derivatives and this rest (mN), and white noise of `sigma` mN.
pub fn fit_of(unknowns: &Unknowns, jacobian_mn: DMatrix<f64>, gap_mn: DVector<f64>, sigma: f64) -> Fit {
    let covariance = Covariance::new(DVector::from_element(gap_mn.len(), sigma), vec![]);
    fit_with(unknowns, jacobian_mn, gap_mn, covariance)
}

/// The same with any covariance.
pub fn fit_with(
    unknowns: &Unknowns,
    jacobian_mn: DMatrix<f64>,
    gap_mn: DVector<f64>,
    covariance: Covariance,
) -> Fit {
    let (prior, x) = (unknowns.prior(), unknowns.start().to_vec());
    let linear = linearised(&jacobian_mn, &gap_mn, &covariance, &prior, &x);
    let solution = Solution::at_once(x, gap_mn.as_slice().to_vec(), jacobian_mn.clone());
    let parameters = unknowns.len();
    Fit { solution, linear, gap_mn, jacobian_mn, parameters, prior, covariance, end: End::Minimum }
}
