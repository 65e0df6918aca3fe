//! Minima of the collection of Moré, Garbow and Hillstrom (ACM TOMS 7, 1981) and, where bounds are active,
//! of SciPy 1.17.1 `least_squares(method="trf", jac="3-point", ftol=xtol=gtol=1e-14)`.

use super::*;
use approx::assert_relative_eq;

/// Residuals from a closure, derivatives by central differences.
struct Analytic<F: Fn(&[f64]) -> Vec<f64>> {
    n: usize,
    f: F,
    fails: fn(&[f64]) -> bool,
    jacobian_fails: fn(&[f64]) -> bool,
    rejected: usize,
}

impl<F: Fn(&[f64]) -> Vec<f64>> Analytic<F> {
    fn new(n: usize, f: F) -> Self {
        Self { n, f, fails: |_| false, jacobian_fails: |_| false, rejected: 0 }
    }
}

impl<F: Fn(&[f64]) -> Vec<f64>> Problem for Analytic<F> {
    fn dimension(&self) -> usize {
        self.n
    }

    fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
        if (self.fails)(x) {
            return Err(EvaluationFailure::Failed("forbidden region".to_owned()));
        }
        Ok((self.f)(x))
    }

    fn jacobian(&mut self, x: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
        if (self.jacobian_fails)(x) {
            return Err(EvaluationFailure::Failed("no derivative here".to_owned()));
        }
        let mut jacobian = DMatrix::zeros(r.len(), self.n);
        for j in 0..self.n {
            let h = 6e-6 * x[j].abs().max(1e-3);
            let at = |sign: f64| {
                let mut y = x.to_vec();
                y[j] += sign * h;
                DVector::from_vec((self.f)(&y))
            };
            jacobian.set_column(j, &((at(1.0) - at(-1.0)) / (2.0 * h)));
        }
        Ok(jacobian)
    }

    fn rejected(&mut self, _x: &[f64]) {
        self.rejected += 1;
    }
}

fn tight() -> Options {
    Options {
        gradient_tolerance: 1e-15,
        chi_square_tolerance: 1e-13,
        noise_tolerance: 1e-13,
        step_tolerance: 1e-12,
        max_evaluations: 2000,
        ..Options::default()
    }
}

fn solve(
    n: usize,
    f: impl Fn(&[f64]) -> Vec<f64>,
    start: &[f64],
    bounds: &Bounds,
    options: &Options,
) -> Solution {
    let go = &mut |_: &IterationRecord| ControlFlow::Continue(());
    let solution = minimise(&mut Analytic::new(n, f), start, bounds, options, go).unwrap();
    assert!(bounds.contain(&solution.x), "{:?}", solution.x);
    for pair in solution.iterations.windows(2) {
        assert!(pair[1].chi_square < pair[0].chi_square, "chi^2 must fall monotonically");
    }
    solution
}

fn rosenbrock(x: &[f64]) -> Vec<f64> {
    vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]
}

fn osborne(x: &[f64]) -> Vec<f64> {
    let y = [
        0.844, 0.908, 0.932, 0.936, 0.925, 0.908, 0.881, 0.850, 0.818, 0.784, 0.751, 0.718, 0.685, 0.658,
        0.628, 0.603, 0.580, 0.558, 0.538, 0.522, 0.506, 0.490, 0.478, 0.467, 0.457, 0.448, 0.438, 0.431,
        0.424, 0.420, 0.414, 0.411, 0.406,
    ];
    let model = |t: f64| x[0] + x[1] * (-t * x[3]).exp() + x[2] * (-t * x[4]).exp();
    y.iter().enumerate().map(|(i, y)| y - model(10.0 * i as f64)).collect()
}

fn bard(x: &[f64]) -> Vec<f64> {
    let y = [0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.10, 4.39];
    let term = |(i, y): (usize, &f64)| {
        let u = i as f64 + 1.0;
        let v = 16.0 - u;
        y - (x[0] + u / (v * x[1] + u.min(v) * x[2]))
    };
    y.iter().enumerate().map(term).collect()
}

fn brown_dennis(x: &[f64]) -> Vec<f64> {
    let term = |i: usize| {
        let t = i as f64 / 5.0;
        (x[0] + t * x[1] - t.exp()).powi(2) + (x[2] + x[3] * t.sin() - t.cos()).powi(2)
    };
    (1..=20).map(term).collect()
}

#[test]
fn rosenbrock_without_and_with_bounds() {
    let free = solve(2, rosenbrock, &[-1.2, 1.0], &Bounds::none(2), &tight());
    assert!(free.chi_square < 1e-20, "{}", free.chi_square);
    assert_relative_eq!(free.x[0], 1.0, epsilon = 1e-9);
    assert!(free.stop.converged());

    // Upper bound on x0 excludes the minimum: it moves to (0.5, 0.25), chi^2 = 0.25 (SciPy agrees).
    let bounds = Bounds::new(vec![-50.0, -50.0], vec![0.5, 100.0]).unwrap();
    let bounded = solve(2, rosenbrock, &[-2.0, -1.0], &bounds, &tight());
    assert_relative_eq!(bounded.x[0], 0.5, epsilon = 1e-7);
    assert_relative_eq!(bounded.x[1], 0.25, epsilon = 1e-6);
    assert_relative_eq!(bounded.chi_square, 0.25, max_relative = 1e-7);

    // SciPy from the same start: the local minimum (-1.22102624, 1.5), chi^2 = 4.94122932.
    let bounds = Bounds::new(vec![f64::NEG_INFINITY, 1.5], vec![f64::INFINITY; 2]).unwrap();
    let bounded = solve(2, rosenbrock, &[-2.0, 1.6], &bounds, &tight());
    assert_relative_eq!(bounded.x[0], -1.22102624, epsilon = 1e-6);
    assert_relative_eq!(bounded.chi_square, 4.94122932, max_relative = 1e-7);
}

#[test]
fn known_minima_of_more_garbow_hillstrom() {
    let kowalik = |x: &[f64]| {
        let y = [0.1957, 0.1947, 0.1735, 0.1600, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246];
        let u = [4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625];
        let model = |u: f64| x[0] * (u * u + u * x[1]) / (u * u + u * x[2] + x[3]);
        y.iter().zip(u).map(|(y, u)| y - model(u)).collect()
    };
    let freudenstein_roth = |x: &[f64]| {
        vec![
            -13.0 + x[0] + ((5.0 - x[1]) * x[1] - 2.0) * x[1],
            -29.0 + x[0] + ((x[1] + 1.0) * x[1] - 14.0) * x[1],
        ]
    };
    let helical = |x: &[f64]| {
        let turn = x[1].atan2(x[0]) / std::f64::consts::TAU;
        vec![10.0 * (x[2] - 10.0 * turn), 10.0 * (x[0].hypot(x[1]) - 1.0), x[2]]
    };
    let s = solve(4, kowalik, &[0.25, 0.39, 0.415, 0.39], &Bounds::none(4), &tight());
    assert_relative_eq!(s.chi_square, 3.07505604e-4, max_relative = 1e-7);
    let s = solve(3, bard, &[1.0; 3], &Bounds::none(3), &tight());
    assert_relative_eq!(s.chi_square, 8.21487730658e-3, max_relative = 1e-9);
    assert_relative_eq!(s.x[2], 2.34369517861, max_relative = 1e-5);
    let s = solve(5, osborne, &[0.5, 1.5, -1.0, 0.01, 0.02], &Bounds::none(5), &tight());
    assert_relative_eq!(s.chi_square, 5.46489469748e-5, max_relative = 1e-8);
    let s = solve(4, brown_dennis, &[25.0, 5.0, -5.0, -1.0], &Bounds::none(4), &tight());
    assert_relative_eq!(s.chi_square, 85822.2016264, max_relative = 1e-9);
    let s = solve(2, freudenstein_roth, &[0.5, -2.0], &Bounds::none(2), &tight());
    assert_relative_eq!(s.chi_square, 48.9842536792, max_relative = 1e-8);
    let s = solve(3, helical, &[-1.0, 0.0, 0.0], &Bounds::none(3), &tight());
    assert!(s.chi_square < 1e-18, "{}", s.chi_square);
}

#[test]
fn badly_scaled_meyer_needs_jacobian_scaling() {
    let meyer = |x: &[f64]| {
        let y = [
            34780.0, 28610.0, 23650.0, 19630.0, 16370.0, 13720.0, 11540.0, 9744.0, 8261.0, 7030.0, 6005.0,
            5147.0, 4427.0, 3820.0, 3307.0, 2872.0,
        ];
        let model = |t: f64| x[0] * (x[1] / (t + x[2])).exp();
        y.iter().enumerate().map(|(i, y)| model(50.0 + 5.0 * i as f64) - y).collect()
    };
    let options = Options { scaling: Scaling::Jacobian, ..tight() };
    let s = solve(3, meyer, &[0.02, 4000.0, 250.0], &Bounds::none(3), &options);
    assert_relative_eq!(s.chi_square, 87.9458551705, max_relative = 1e-7);
    assert_relative_eq!(s.x[1], 6181.34634629, max_relative = 1e-6);
}

#[test]
fn solution_on_bounds_agrees_with_scipy() {
    let bounds = Bounds::new(vec![0.4, 0.0, -3.0, 0.005, 0.001], vec![0.5, 1.6, 0.0, 0.05, 0.03]).unwrap();
    let s = solve(5, osborne, &[0.45, 1.5, -1.0, 0.01, 0.02], &bounds, &tight());
    assert_relative_eq!(s.chi_square, 0.00258192962158, max_relative = 1e-6);
    for (x, expected) in s.x.iter().zip([0.4, 1.6, -1.16283414264, 0.0131915719354, 0.0260563550576]) {
        assert_relative_eq!(*x, expected, max_relative = 1e-4);
    }
    let bounds = Bounds::new(vec![0.1, 0.5, 0.5], vec![3.0, 3.0, 2.0]).unwrap();
    let s = solve(3, bard, &[0.5, 1.0, 1.0], &bounds, &tight());
    assert_relative_eq!(s.chi_square, 0.00958228472115, max_relative = 1e-7);
    assert_relative_eq!(s.x[1], 1.51945062583, max_relative = 1e-4);
}

#[test]
fn a_start_on_the_bound_is_moved_inside() {
    let bounds = Bounds::new(vec![0.0, 0.0], vec![2.0, 2.0]).unwrap();
    let s = solve(2, rosenbrock, &[0.0, 2.0], &bounds, &tight());
    assert!(s.chi_square < 1e-16, "{}", s.chi_square);
}

/// Only the product of the two parameters enters: the valley `x0 x1 = 6` is a curve of minima.
#[test]
fn rank_deficient_jacobian_ends_on_the_valley() {
    let product = |x: &[f64]| (1..=5).map(|i| i as f64 * (x[0] * x[1] - 6.0)).collect::<Vec<_>>();
    let s = solve(2, product, &[1.0, 1.5], &Bounds::none(2), &tight());
    assert_relative_eq!(s.x[0] * s.x[1], 6.0, epsilon = 1e-9);
    assert!(s.iteration_count() < 15, "{}", s.iteration_count());

    // Powell's singular function: rank 2 of 4 at the minimum.
    let powell = |x: &[f64]| {
        vec![
            x[0] + 10.0 * x[1],
            5f64.sqrt() * (x[2] - x[3]),
            (x[1] - 2.0 * x[2]).powi(2),
            10f64.sqrt() * (x[0] - x[3]).powi(2),
        ]
    };
    let s = solve(4, powell, &[3.0, -1.0, 0.0, 1.0], &Bounds::none(4), &tight());
    assert!(s.chi_square < 1e-12, "{}", s.chi_square);
}

/// Noise of relative size 1e-6 in the second column pretends that x1 matters.
#[test]
fn directions_below_the_jacobians_accuracy_are_left_alone() {
    let blind = |x: &[f64]| {
        (0..6).map(|i| (x[0] - 2.0) * (1.0 + i as f64) + 1e-6 * (17.0 * i as f64).sin() * x[1]).collect()
    };
    let options = Options { rank_tolerance: 1e-4, ..tight() };
    let s = solve(2, blind, &[1.0, 1.0], &Bounds::none(2), &options);
    assert_relative_eq!(s.x[0], 2.0, epsilon = 1e-5);
    assert_relative_eq!(s.x[1], 1.0, epsilon = 1e-3);
}

#[test]
fn failing_evaluations_shrink_the_region_and_are_counted() {
    // The first Gauss-Newton step goes to (1, -3.84), where the model fails.
    let mut problem = Analytic::new(2, rosenbrock);
    problem.fails = |x| x[1] < -0.4;
    problem.jacobian_fails = |x| x[0] > -1.19 && (x[1] - x[0] * x[0]).abs() > 0.1;
    let mut seen = vec![];
    let options = Options { initial_radius: Some(10.0), ..tight() };
    let s = minimise(&mut problem, &[-1.2, 1.0], &Bounds::none(2), &options, &mut |r| {
        seen.push(r.clone());
        ControlFlow::Continue(())
    })
    .unwrap();
    assert!(s.chi_square < 1e-18, "{} {}", s.chi_square, s.stop);
    for reason in ["forbidden region", "no derivative here"] {
        assert!(s.failures.iter().any(|f| f == reason), "{reason}: {:?}", s.failures);
    }
    assert!(s.iterations.iter().all(|r| !(problem.jacobian_fails)(&r.x)));
    assert!(problem.rejected >= s.failures.len());
    assert_eq!(seen, s.iterations);
}

#[test]
fn a_wall_of_failures_stops_with_its_reason_and_the_best_point() {
    let mut problem = Analytic::new(2, rosenbrock);
    problem.fails = |x| x != [-1.2, 1.0];
    let go = &mut |_: &IterationRecord| ControlFlow::Continue(());
    let s = minimise(&mut problem, &[-1.2, 1.0], &Bounds::none(2), &tight(), go).unwrap();
    assert_eq!(s.stop, StopReason::TooManyFailures);
    assert_eq!(s.failures.len(), Options::default().max_consecutive_failures);
    assert_eq!(s.x, [-1.2, 1.0]);

    problem.fails = |_| true;
    let error = minimise(&mut problem, &[-1.2, 1.0], &Bounds::none(2), &tight(), go).unwrap_err();
    assert_eq!(error, FitError::StartFailed("forbidden region".to_owned()));
}

#[test]
fn budget_and_stop_request_keep_the_best_point() {
    let start = [0.5, 1.5, -1.0, 0.01, 0.02];
    let options = Options { max_evaluations: 5, ..tight() };
    let s = solve(5, osborne, &start, &Bounds::none(5), &options);
    assert_eq!((s.stop, s.evaluations), (StopReason::EvaluationBudget, 5));
    assert!(s.chi_square < s.iterations[0].chi_square);

    let s = minimise(&mut Analytic::new(5, osborne), &start, &Bounds::none(5), &tight(), &mut |r| {
        if r.iteration == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .unwrap();
    assert_eq!((s.stop, s.iteration_count()), (StopReason::StopRequested, 3));
}

#[test]
fn a_valley_that_bends_is_followed() {
    // A narrow parabola: every straight step of the region's length ends on its slope.
    let f = |x: &[f64]| vec![1e3 * (x[1] - x[0] * x[0]), 1.0 - x[0]];
    let s = solve(2, f, &[-1.2, 1.44], &Bounds::none(2), &Options { initial_radius: Some(0.5), ..tight() });
    // Without corrections: 200 evaluations, 195 iterations.
    assert!(s.stop.converged() && s.evaluations < 100, "{} {:?}", s.evaluations, s.stop);
    assert!(s.iteration_count() < 30, "{}", s.iteration_count());
    assert!((s.x[0] - 1.0).abs() < 1e-6, "{:?}", s.x);
}

#[test]
fn the_same_fit_twice_is_identical_to_the_bit() {
    let run = || solve(5, osborne, &[0.5, 1.5, -1.0, 0.01, 0.02], &Bounds::none(5), &tight());
    assert_eq!(run(), run());
}

#[test]
fn impossible_input_is_refused() {
    assert!(matches!(Bounds::new(vec![1.0], vec![1.0]), Err(FitError::Bounds { index: 0, .. })));
    let bounds = Bounds::new(vec![0.0, 0.0], vec![1.0, 1.0]).unwrap();
    let go = &mut |_: &IterationRecord| ControlFlow::Continue(());
    let outside = minimise(&mut Analytic::new(2, rosenbrock), &[0.5, 2.0], &bounds, &tight(), go);
    assert!(matches!(outside, Err(FitError::StartOutside { index: 1, .. })));
    let nan = minimise(&mut Analytic::new(2, rosenbrock), &[f64::NAN, 0.2], &bounds, &tight(), go);
    assert!(matches!(nan, Err(FitError::StartOutside { index: 0, .. })));
}

#[test]
fn noise_of_the_residuals_ends_a_fit_that_has_arrived() {
    // Residuals with jumps of a hundredth wherever a solver would take another step: no descent is seen below them.
    let jump = |x: f64| 0.01 * f64::from((1e4 * x).sin() > 0.0);
    let f = |x: &[f64]| vec![x[0] - 1.0, 3.0 + jump(x[0]) + 0.1 * x[1], 2.0 - jump(x[1]) + x[1]];
    let options = Options { chi_square_tolerance: 1e-4, noise_tolerance: 1e-4, ..Options::default() };
    let solution = solve(2, f, &[4.0, 3.0], &Bounds::none(2), &options);
    assert!(solution.stop.converged() && solution.evaluations < 12, "{solution:?}");
    assert!((solution.x[0] - 1.0).abs() < 0.1 && (solution.x[1] + 2.27).abs() < 0.2, "{:?}", solution.x);
}

#[test]
fn steps_far_beyond_a_bend_end_no_fit() {
    // A step of Newton's from 30 leads to -1355, a quarter of it to -317, where the residual is twice as large: both miss more than there is.
    let f = |x: &[f64]| vec![x[0].atan() * (1.0 + (-((x[0] + 317.0) / 100.0).powi(2)).exp())];
    let options = Options { initial_radius: Some(1e4), ..tight() };
    let solution = solve(1, f, &[30.0], &Bounds::none(1), &options);
    assert!(solution.x[0].abs() < 1e-6, "{solution:?}");
}

#[test]
fn a_jump_of_the_residuals_ends_a_fit_before_it() {
    // What would be gained lies beyond a jump that costs more: a quarter of the step meets the whole of it.
    let f = |x: &[f64]| vec![30.0 + f64::from(x[0] > 0.0), 0.5 * (x[0] - 1.0), 0.5 * (x[1] - 1.0)];
    let solution = solve(2, f, &[-1e-8, 1.0], &Bounds::none(2), &tight());
    // Where only a short step ends it: 47 evaluations.
    assert!(solution.stop.converged() && solution.evaluations <= 9, "{solution:?}");
    assert_eq!(solution.x[0], -1e-8);
}

#[test]
fn short_steps_that_gain_nothing_end_a_fit() {
    // Half as steep from one tenth to the next as between them: the region does not grow, and a hundred steps gain a hundredth.
    let f = |x: &[f64]| vec![100.0, 10.0 - x[0] + 0.05 * (10.0 * x[0]).floor()];
    let options = Options { initial_radius: Some(0.15), chi_square_tolerance: 1e-3, ..tight() };
    let solution = solve(1, f, &[0.01], &Bounds::none(1), &options);
    assert!(solution.stop.converged() && solution.evaluations < 5, "{solution:?}");
    // Where all of it is gained, none of them is too short.
    let steep = |x: &[f64]| vec![f(x)[1]];
    let solution = solve(1, steep, &[0.01], &Bounds::none(1), &options);
    assert!(solution.chi_square < 0.1, "{solution:?}");
}
