//! Analytic cases with known answers.

use super::*;
use crate::inference::cases::{fit_of, fit_with, linear, positive};
use crate::inference::parameter::Unit;
use crate::noise::{Common, Covariance};
use approx::assert_relative_eq;

fn statistics(unknowns: &Unknowns, fit: &Fit) -> Statistics {
    Statistics::new(unknowns, fit, &[]).unwrap()
}

/// Straight line through (1, 2.1), (2, 3.9), (3, 6.2), (4, 7.8), (5, 10.1): intercept 0.05, slope 1.99,
/// standard errors sqrt(s^2 11/10) and sqrt(s^2 / 10) with s^2 = 0.107 / 3 (textbook formulas), t_3 = 3.18245.
#[test]
fn straight_line_regression() {
    let t = [1.0, 2.0, 3.0, 4.0, 5.0];
    let y = [2.1, 3.9, 6.2, 7.8, 10.1];
    let unknowns = linear(&[("intercept", 0.05), ("slope", 1.99)]);
    let scale = 2e6;
    let jacobian = DMatrix::from_fn(5, 2, |i, j| scale * if j == 0 { 1.0 } else { t[i] });
    let gap = DVector::from_iterator(5, t.iter().zip(y).map(|(t, y)| y - 0.05 - 1.99 * t));
    let covariance = Covariance::of_unknown_size(DVector::from_element(5, 1.0));
    let statistics = statistics(&unknowns, &fit_with(&unknowns, jacobian, gap, covariance));
    assert_relative_eq!(statistics.chi_square, 0.107, max_relative = 1e-12);
    let variance: f64 = 0.107 / 3.0;
    for (estimate, factor) in statistics.estimates.iter().zip([1.1, 0.1]) {
        let half = 3.182446305 * (variance * factor).sqrt();
        assert_relative_eq!(estimate.interval.upper - estimate.value, half, max_relative = 1e-6);
        assert_relative_eq!(estimate.value - estimate.interval.lower, half, max_relative = 1e-6);
    }
    // Correlation of intercept and slope: -mean(t) / sqrt(mean(t^2)) = -3 / sqrt(11).
    assert_relative_eq!(statistics.correlation[(0, 1)], -3.0 / 11f64.sqrt(), max_relative = 1e-6);
}

#[test]
fn known_noise_is_kept_unless_the_model_misses_the_data() {
    let unknowns = positive(&[("g", 10.0, [0.1, 1e3])]);
    let with = |gap: f64| {
        let gap = DVector::from_element(100, gap);
        statistics(&unknowns, &fit_of(&unknowns, DMatrix::from_element(100, 1, 2.0), gap, 1.0))
    };
    // Var = 1 / (100 * 4): half-width t_99 / 20; in the value, a factor.
    let small = with(0.3);
    let e = &small.estimates[0];
    assert_relative_eq!(e.half_width, 1.98422 / 20.0, max_relative = 1e-4);
    assert_relative_eq!(e.interval.upper / e.value, e.value / e.interval.lower, max_relative = 1e-12);
    // Residuals three times the noise widen it by 3 sqrt(100 / 99).
    let ratio = with(3.0).estimates[0].half_width / e.half_width;
    assert_relative_eq!(ratio, 3.0 * (100.0 / 99.0f64).sqrt(), max_relative = 1e-6);
}

/// A force proportional to one modulus, and the height of ten specimens that scatter by 12 %: ln G is uncertain by
/// 0.12 / sqrt(10), estimated with nine degrees of freedom, whatever the white noise.
#[test]
fn what_few_specimens_tell_has_their_degrees_of_freedom() {
    let unknowns = positive(&[("g", 10.0, [0.1, 1e3])]);
    let force = DVector::from_fn(200, |i, _| 100.0 / (1.0 + 0.1 * i as f64));
    let amplitude = 0.12 / 10f64.sqrt();
    let half_width = |degrees: f64| {
        let height = Common { degrees, ..Common::proportional("height".into(), &force * amplitude) };
        let covariance = Covariance::new(DVector::from_element(200, 1.0), vec![]).absorbing(vec![height]);
        let jacobian = DMatrix::from_columns(std::slice::from_ref(&force));
        let fit = fit_with(&unknowns, jacobian, DVector::from_element(200, 0.5), covariance);
        let found = statistics(&unknowns, &fit);
        assert!(found.estimates[0].common_share > 0.95);
        found.estimates[0].half_width
    };
    // Tables: t_9 = 2.26216, normal 1.95996.
    assert_relative_eq!(half_width(9.0), 2.26216 * amplitude, max_relative = 5e-3);
    assert_relative_eq!(half_width(f64::INFINITY), 1.95996 * amplitude, max_relative = 5e-3);
}

/// Two parts of a variance, one of them of two degrees of freedom: Satterthwaite's number by hand.
#[test]
fn degrees_of_freedom_of_a_sum_of_variances() {
    let unknowns = positive(&[("g", 10.0, [0.1, 1e3])]);
    let (jacobian, gap) = (DMatrix::from_element(400, 1, 1.0), DVector::zeros(400));
    let shift = Common { degrees: 2.0, ..Common::additive("shift".into(), DVector::from_element(400, 0.05)) };
    let covariance = Covariance::new(DVector::from_element(400, 1.0), vec![shift]);
    let found = statistics(&unknowns, &fit_with(&unknowns, jacobian, gap, covariance));
    // Both parts are 1 / 400: (2 v)^2 / (v^2 / 2 + v^2 / 399) = 7.960.
    let expected = StudentsT::new(0.0, 1.0, 4.0 / (0.5 + 1.0 / 399.0)).unwrap().inverse_cdf(0.975);
    assert_relative_eq!(found.quantile(&DVector::from_element(1, 1.0)), expected, max_relative = 1e-6);
    // What the noise leaves counts with s^2 >= 1 and no more: 1.0, both parts together.
    assert_relative_eq!(
        found.estimates[0].half_width,
        expected * (2.0f64 / 400.0).sqrt(),
        max_relative = 1e-3
    );
}

/// A gap that is three times a common error is no misfit, and its neighbours are not correlated.
#[test]
fn a_common_error_is_no_misfit() {
    let unknowns = positive(&[("a", 1.0, [0.1, 10.0])]);
    let shape = DVector::from_fn(400, |i, _| 2.0 + (i as f64 / 40.0).sin());
    let white = DVector::from_fn(400, |i, _| if i.is_multiple_of(2) { 0.7 } else { -0.7 });
    let of = |gap: DVector<f64>| {
        let covariance = Covariance::new(
            DVector::from_element(400, 1.0),
            vec![Common::additive("height".into(), shape.clone())],
        );
        let fit = fit_with(&unknowns, DMatrix::from_element(400, 1, 0.01), gap, covariance);
        Statistics::new(&unknowns, &fit, &[400]).unwrap()
    };
    // Sherman and Morrison: 9 |v|^2 / (1 + |v|^2).
    let square = shape.norm_squared();
    assert_relative_eq!(of(&shape * 3.0).chi_square, 9.0 * square / (1.0 + square), max_relative = 1e-9);
    let noisy = of(&shape * 3.0 + white);
    assert!((noisy.reduced_chi_square - 0.5).abs() < 0.05, "{}", noisy.reduced_chi_square);
    assert_eq!(noisy.correlation_time, 1.0);
}

/// The root's blocks make up the whole covariance: generalised least squares by explicit inversion.
#[test]
fn the_covariance_is_that_of_generalised_least_squares() {
    let unknowns = positive(&[("a", 1.0, [0.1, 10.0]), ("b", 2.0, [0.2, 20.0])]);
    let jacobian = DMatrix::from_fn(30, 2, |i, j| 1.0 + (i as f64 * 0.3 + j as f64).sin());
    let shape = DVector::from_fn(30, |i, _| 0.5 + 0.1 * i as f64);
    let white = DVector::from_fn(30, |i, _| 0.4 + 0.01 * i as f64);
    let sigma = DMatrix::from_diagonal(&white.component_mul(&white)) + &shape * shape.transpose();
    let covariance = Covariance::new(white, vec![Common::additive("c".into(), shape)]);
    let fit = fit_with(&unknowns, jacobian.clone(), DVector::zeros(30), covariance);
    let prior =
        DMatrix::from_diagonal(&DVector::from_iterator(2, fit.prior.deviation.iter().map(|s| s.powi(-2))));
    let found = statistics(&unknowns, &fit).of_variables();
    let expected =
        (jacobian.transpose() * sigma.try_inverse().unwrap() * &jacobian + prior).try_inverse().unwrap();
    assert!((found - &expected).amax() < 1e-9 * expected.amax());
}

#[test]
fn correlated_residuals_widen_the_interval() {
    let unknowns = positive(&[("g", 10.0, [0.1, 1e3])]);
    // A slow oscillation over 400 points is no white noise; alternating signs are no reason to widen.
    let time = |gap: &dyn Fn(usize) -> f64| {
        let gap = DVector::from_fn(400, |i, _| gap(i));
        let fit = fit_of(&unknowns, DMatrix::from_element(400, 1, 1.0), gap, 1.0);
        Statistics::new(&unknowns, &fit, &[200, 200]).unwrap().correlation_time
    };
    assert!(time(&|i| (i as f64 / 20.0).sin()) > 10.0);
    assert_eq!(time(&|i| if i % 2 == 0 { 0.7 } else { -0.7 }), 1.0);
}

#[test]
fn intervals_are_cut_at_bounds_and_say_so() {
    // Negative parameter at its lower bound -1000 (upper end of ln |mu|).
    let mu = FitParameter::new("mu", "mu", Unit::new("Pa", 1.0), -999.9, [-1000.0, -1.0]).unwrap();
    let unknowns = Unknowns::of(vec![mu]);
    let gap = DVector::from_element(50, 0.1);
    let found = statistics(&unknowns, &fit_of(&unknowns, DMatrix::from_element(50, 1, 0.5), gap, 1.0));
    let e = &found.estimates[0];
    assert_eq!(e.at_bound, Some(BoundSide::Lower));
    assert_eq!(e.open, [true, false]);
    assert_relative_eq!(e.interval.lower, -1000.0, max_relative = 1e-12);
    assert_relative_eq!(e.interval.upper, -999.9 * (-e.half_width).exp(), max_relative = 1e-12);
}

/// What the data do not feel is open on both sides; what they feel is not widened by the bounds of the other.
#[test]
fn an_invisible_parameter_is_open_and_spoils_no_other() {
    let unknowns = positive(&[("g", 10.0, [0.1, 1e3]), ("k", 1.0, [1e-6, 1e6])]);
    let jacobian = DMatrix::from_fn(50, 2, |_, j| if j == 0 { 1.0 } else { 0.0 });
    let fit = fit_of(&unknowns, jacobian, DVector::from_element(50, 0.1), 1.0);
    let found = statistics(&unknowns, &fit);
    let k = &found.estimates[1];
    assert_eq!(k.determination, Determination::Undetermined);
    assert_eq!(k.open, [true, true]);
    assert_relative_eq!(k.interval.upper, 1e6, max_relative = 1e-9);
    assert_eq!(found.estimates[0].determination, Determination::Loose);
    // t_49 / sqrt(50): the prior of g itself is taken out again.
    assert_relative_eq!(found.estimates[0].half_width, 2.00958 / 50f64.sqrt(), max_relative = 1e-3);
}

/// The data see g (1 + k / 1000) with k between 0.1 and 10: g is known to a percent although k is not, because
/// the bounds of k leave no more room.
#[test]
fn bounds_keep_an_unfelt_parameter_from_spoiling_a_felt_one() {
    let unknowns = positive(&[("g", 10.0, [0.1, 1e3]), ("k", 1.0, [0.1, 10.0])]);
    let jacobian = DMatrix::from_fn(50, 2, |_, j| 100.0 * if j == 0 { 1.0 } else { 1e-3 });
    let fit = fit_of(&unknowns, jacobian, DVector::from_element(50, 0.1), 1.0);
    let found = statistics(&unknowns, &fit);
    assert_eq!(found.estimates[1].determination, Determination::Undetermined);
    assert!(found.estimates[0].half_width < 0.01, "{}", found.estimates[0].half_width);
}

#[test]
fn too_few_points_are_refused() {
    let unknowns = linear(&[("a", 0.0), ("b", 0.0)]);
    let fit = fit_of(&unknowns, DMatrix::identity(2, 2), DVector::zeros(2), 1.0);
    assert!(matches!(
        Statistics::new(&unknowns, &fit, &[]),
        Err(FitError::Dimension { expected: 3, found: 2, .. })
    ));
}
