//! Analytic cases with known answers.

use super::*;
use crate::fit::parameter::Unit;
use crate::fit::solution::StopReason;
use approx::assert_relative_eq;

fn linear(name: &str, value: f64) -> FitParameter {
    FitParameter::new(name, name, Unit::new("", 1.0), value, [-1e6, 1e6]).unwrap()
}

fn positive(name: &str, value: f64, bounds: [f64; 2]) -> FitParameter {
    FitParameter::new(name, name, Unit::new("Pa", 1.0), value, bounds).unwrap()
}

fn solution(x: Vec<f64>, residual: Vec<f64>, jacobian: DMatrix<f64>) -> Solution {
    let chi_square = residual.iter().map(|r| r * r).sum();
    Solution {
        x,
        residual,
        jacobian,
        chi_square,
        stop: StopReason::Gradient,
        iterations: vec![],
        evaluations: 1,
        jacobians: 1,
        failures: vec![],
    }
}

/// Straight line through (1, 2.1), (2, 3.9), (3, 6.2), (4, 7.8), (5, 10.1): intercept 0.05, slope 1.99,
/// standard errors sqrt(s^2 11/10) and sqrt(s^2 / 10) with s^2 = 0.107 / 3 (textbook formulas), t_3 = 3.18245.
#[test]
fn straight_line_regression() {
    let t = [1.0, 2.0, 3.0, 4.0, 5.0];
    let y = [2.1, 3.9, 6.2, 7.8, 10.1];
    let parameters = [linear("intercept", 0.05), linear("slope", 1.99)];
    let scale = 2e6;
    let jacobian = DMatrix::from_fn(5, 2, |i, j| scale * if j == 0 { 1.0 } else { t[i] });
    let residual: Vec<f64> = t.iter().zip(y).map(|(t, y)| 0.05 + 1.99 * t - y).collect();
    let s = solution(vec![0.05 / scale, 1.99 / scale], residual, jacobian);
    let statistics = Statistics::new(&parameters, &s, &Noise::default()).unwrap();
    assert_relative_eq!(statistics.chi_square, 0.107, max_relative = 1e-12);
    assert_relative_eq!(statistics.t_quantile, 3.182446305, max_relative = 1e-8);
    let variance: f64 = 0.107 / 3.0;
    for (estimate, factor) in statistics.estimates.iter().zip([1.1, 0.1]) {
        let half = 3.182446305 * (variance * factor).sqrt();
        assert_relative_eq!(estimate.interval.upper - estimate.value, half, max_relative = 1e-8);
        assert_relative_eq!(estimate.value - estimate.interval.lower, half, max_relative = 1e-8);
    }
    // Correlation of intercept and slope: -mean(t) / sqrt(mean(t^2)) = -3 / sqrt(11).
    assert_relative_eq!(statistics.correlation[(0, 1)], -3.0 / 11f64.sqrt(), max_relative = 1e-12);
}

#[test]
fn known_noise_is_kept_unless_the_model_misses_the_data() {
    let parameters = [positive("g", 10.0, [0.1, 1e3])];
    let jacobian = DMatrix::from_element(100, 1, 2.0);
    let with = |residual: f64| {
        let s = solution(vec![10f64.ln()], vec![residual; 100], jacobian.clone());
        let noise = Noise { known: true, ..Noise::default() };
        Statistics::new(&parameters, &s, &noise).unwrap()
    };
    // Var = 1 / (100 * 4): half-width t / 20; in the value, a factor.
    let small = with(0.3);
    let half_width = small.estimates[0].half_width;
    assert_relative_eq!(half_width, small.t_quantile / 20.0, max_relative = 5e-4);
    let e = &small.estimates[0];
    assert_relative_eq!(e.interval.upper / e.value, e.value / e.interval.lower, max_relative = 1e-12);
    // Residuals three times the noise widen it by 3 sqrt(100 / 99).
    let ratio = with(3.0).estimates[0].half_width / small.estimates[0].half_width;
    assert_relative_eq!(ratio, 3.0 * (100.0 / 99.0f64).sqrt(), max_relative = 3e-3);
}

/// A force proportional to one modulus and a 12 % amplitude error over 10 specimens: ln G is uncertain by
/// 0.12 / sqrt(10) whatever the white noise.
#[test]
fn common_amplitude_error_dominates() {
    let parameters = [positive("g", 10.0, [0.1, 1e3])];
    let force: Vec<f64> = (0..200).map(|i| 100.0 / (1.0 + 0.1 * i as f64)).collect();
    let jacobian = DMatrix::from_column_slice(200, 1, &force);
    let amplitude = 0.12 / 10f64.sqrt();
    let common =
        CommonError { name: "specimens".to_owned(), residual: force.iter().map(|f| f * amplitude).collect() };
    let s = solution(vec![10f64.ln()], vec![0.5; 200], jacobian);
    let noise = Noise { known: true, common: vec![common], stretches: vec![] };
    let statistics = Statistics::new(&parameters, &s, &noise).unwrap();
    let white: f64 = 1.0 / force.iter().map(|f| f * f).sum::<f64>();
    let expected = statistics.t_quantile * (white + amplitude * amplitude).sqrt();
    assert_relative_eq!(statistics.estimates[0].half_width, expected, max_relative = 1e-5);
    assert!(statistics.estimates[0].common_share > 0.95);
}

/// Residuals that are three times a common error: what is left of chi^2 is `9 |v|^2 / (1 + |v|^2)` (Sherman and Morrison), no
/// misfit, and no neighbours are correlated.
#[test]
fn a_common_error_is_no_misfit() {
    let parameters = [linear("a", 0.0)];
    let shape: Vec<f64> = (0..400).map(|i| 2.0 + (i as f64 / 40.0).sin()).collect();
    let white = |i: usize| if i.is_multiple_of(2) { 0.7 } else { -0.7 };
    let s = solution(vec![0.0], shape.iter().map(|v| 3.0 * v).collect(), DMatrix::from_element(400, 1, 0.01));
    let common = CommonError { name: "height".to_owned(), residual: shape.clone() };
    let noise = Noise { known: true, common: vec![common], stretches: vec![400] };
    let statistics = Statistics::new(&parameters, &s, &noise).unwrap();
    let square: f64 = shape.iter().map(|v| v * v).sum();
    let left = statistics.chi_square - statistics.shared_chi_square;
    assert_relative_eq!(left, 9.0 * square / (1.0 + square), max_relative = 1e-9);
    let noisy = shape.iter().enumerate().map(|(i, v)| 3.0 * v + white(i)).collect();
    let s = solution(vec![0.0], noisy, DMatrix::from_element(400, 1, 0.01));
    let statistics = Statistics::new(&parameters, &s, &noise).unwrap();
    assert!((statistics.reduced_chi_square - 0.5).abs() < 0.05, "{}", statistics.reduced_chi_square);
    assert_eq!(statistics.correlation_time, 1.0);
}

#[test]
fn correlated_residuals_widen_the_interval() {
    let parameters = [positive("g", 10.0, [0.1, 1e3])];
    // A slow oscillation over 400 points is no white noise; alternating signs are no reason to widen.
    let slow: Vec<f64> = (0..400).map(|i| (i as f64 / 20.0).sin()).collect();
    let fast: Vec<f64> = (0..400).map(|i| if i % 2 == 0 { 0.7 } else { -0.7 }).collect();
    let time = |residual: Vec<f64>| {
        let s = solution(vec![10f64.ln()], residual, DMatrix::from_element(400, 1, 1.0));
        let noise = Noise { known: true, common: vec![], stretches: vec![200, 200] };
        Statistics::new(&parameters, &s, &noise).unwrap().correlation_time
    };
    assert!(time(slow) > 10.0);
    assert_eq!(time(fast), 1.0);
}

#[test]
fn intervals_are_cut_at_bounds_and_say_so() {
    // Negative parameter at its lower bound -1000 (upper end of ln |mu|).
    let mu = FitParameter::new("mu", "mu", Unit::new("Pa", 1.0), -500.0, [-1000.0, -1.0]).unwrap();
    let s = solution(vec![999.9f64.ln()], vec![0.1; 50], DMatrix::from_element(50, 1, 0.5));
    let noise = Noise { known: true, ..Noise::default() };
    let statistics = Statistics::new(&[mu], &s, &noise).unwrap();
    let e = &statistics.estimates[0];
    assert_eq!(e.at_bound, Some(BoundSide::Lower));
    assert_eq!(e.open, [true, false]);
    assert_relative_eq!(e.interval.lower, -1000.0, max_relative = 1e-12);
    assert_relative_eq!(e.interval.upper, -999.9 * (-e.half_width).exp(), max_relative = 1e-12);
}

#[test]
fn an_invisible_parameter_is_known_by_its_bounds_alone() {
    let parameters = [positive("g", 10.0, [0.1, 1e3]), positive("k", 1.0, [1e-6, 1e6])];
    let jacobian = DMatrix::from_fn(50, 2, |_, j| if j == 0 { 1.0 } else { 0.0 });
    let s = solution(vec![10f64.ln(), 0.0], vec![0.1; 50], jacobian);
    let noise = Noise { known: true, ..Noise::default() };
    let statistics = Statistics::new(&parameters, &s, &noise).unwrap();
    let k = &statistics.estimates[1];
    assert_eq!(k.determination, Determination::Undetermined);
    assert_eq!(k.open, [true, true]);
    // Uniform over twelve decades.
    let width = 12.0 * 10f64.ln();
    assert_relative_eq!(k.half_width, statistics.t_quantile * width / 12f64.sqrt(), max_relative = 1e-9);
    assert_relative_eq!(k.interval.upper, 1e6, max_relative = 1e-9);
    assert_eq!(statistics.estimates[0].determination, Determination::Loose);
}

/// The data see g (1 + k / 1000) with k between 0.1 and 10: g is known to a percent although k is not, because
/// the bounds of k leave no more room.
#[test]
fn bounds_keep_an_unfelt_parameter_from_spoiling_a_felt_one() {
    let parameters = [positive("g", 10.0, [0.1, 1e3]), positive("k", 1.0, [0.1, 10.0])];
    let jacobian = DMatrix::from_fn(50, 2, |_, j| 100.0 * if j == 0 { 1.0 } else { 1e-3 });
    let s = solution(vec![10f64.ln(), 0.0], vec![0.1; 50], jacobian);
    let noise = Noise { known: true, ..Noise::default() };
    let statistics = Statistics::new(&parameters, &s, &noise).unwrap();
    assert_eq!(statistics.estimates[1].determination, Determination::Undetermined);
    assert!(statistics.estimates[0].half_width < 0.01, "{}", statistics.estimates[0].half_width);
}

#[test]
fn too_few_points_are_refused() {
    let parameters = [linear("a", 0.0), linear("b", 0.0)];
    let s = solution(vec![0.0; 2], vec![0.0; 2], DMatrix::identity(2, 2));
    assert!(matches!(
        Statistics::new(&parameters, &s, &Noise::default()),
        Err(FitError::Dimension { expected: 3, found: 2, .. })
    ));
}
