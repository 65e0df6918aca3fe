//! Densities whose moments are known.

use super::*;
use nalgebra::DVector;

/// Rows of `J x = d` with unit errors: normal, of covariance `(J' J)^-1`.
struct Normal;

const ROOT: [[f64; 2]; 2] = [[2.0, 0.3], [0.0, 0.5]];

impl Density for Normal {
    fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![-50.0; 2], vec![50.0; 2])
    }
    fn logarithms(&mut self, points: &[Vec<f64>]) -> Result<Vec<f64>, EvaluationFailure> {
        points.iter().map(|x| Ok(self.with_gradient(x)?.map_or(f64::NEG_INFINITY, |g| g.0))).collect()
    }
    fn with_gradient(&mut self, x: &[f64]) -> Result<Option<(f64, Vec<f64>)>, EvaluationFailure> {
        let r = ROOT.map(|row| row[0] * (x[0] - 1.0) + row[1] * (x[1] + 2.0));
        let slope = (0..2).map(|j| -(r[0] * ROOT[0][j] + r[1] * ROOT[1][j])).collect();
        Ok(Some((-0.5 * (r[0] * r[0] + r[1] * r[1]), slope)))
    }
}

/// `x_0 = N(0, 1)`, `x_1 = x_0^2 + N(0, 0.5)`: mean of x_1 is 1, its variance 2.25.
struct Banana;

impl Density for Banana {
    fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![-20.0, -60.0], vec![20.0, 60.0])
    }
    fn logarithms(&mut self, points: &[Vec<f64>]) -> Result<Vec<f64>, EvaluationFailure> {
        points.iter().map(|x| Ok(self.with_gradient(x)?.map_or(f64::NEG_INFINITY, |g| g.0))).collect()
    }
    fn with_gradient(&mut self, x: &[f64]) -> Result<Option<(f64, Vec<f64>)>, EvaluationFailure> {
        let rest = (x[1] - x[0] * x[0]) / 0.5;
        let value = -0.5 * (x[0] * x[0] + rest * rest);
        Ok(Some((value, vec![-x[0] + rest * 2.0 * x[0] / 0.5, -rest / 0.5])))
    }
}

fn moments(draws: &[Vec<f64>], j: usize) -> (f64, f64) {
    let n = draws.len() as f64;
    let mean = draws.iter().map(|d| d[j]).sum::<f64>() / n;
    (mean, draws.iter().map(|d| (d[j] - mean).powi(2)).sum::<f64>() / n)
}

fn covariance() -> DMatrix<f64> {
    let j = DMatrix::from_fn(2, 2, |i, k| ROOT[i][k]);
    j.tr_mul(&j).try_inverse().unwrap()
}

#[test]
fn a_normal_posterior_is_sampled_by_importance() {
    let plan = SamplePlan { proposals: 4000, draws: 2000, ..SamplePlan::default() };
    let found =
        sample(&mut Normal, Peak { mode: &[1.0, -2.0], covariance: &covariance(), bends: &[] }, &plan)
            .unwrap();
    assert!(found.method == Method::Importance && found.k_hat < 0.3, "{} {:?}", found.k_hat, found.method);
    assert!(found.effective > 1500.0, "{}", found.effective);
    for (j, centre) in [1.0, -2.0].into_iter().enumerate() {
        let (mean, variance) = moments(&found.draws, j);
        let expected = covariance()[(j, j)];
        assert!((mean - centre).abs() < 0.1 * expected.sqrt(), "{mean}");
        assert!((variance / expected - 1.0).abs() < 0.15, "{variance} {expected}");
    }
}

#[test]
fn nuts_samples_the_same_normal_posterior() {
    let plan = SamplePlan { draws: 1500, ..SamplePlan::default() };
    let to = Straightened::new(&Peak { mode: &[1.0, -2.0], covariance: &covariance(), bends: &[] }).unwrap();
    let found = nuts::sample(&mut Normal, &to, &DVector::from_row_slice(&[0.1, 0.1]), &plan).unwrap();
    for (j, centre) in [1.0, -2.0].into_iter().enumerate() {
        let (mean, variance) = moments(&found.draws, j);
        let expected = covariance()[(j, j)];
        assert!((mean - centre).abs() < 0.15 * expected.sqrt(), "{mean}");
        assert!((variance / expected - 1.0).abs() < 0.25, "{variance} {expected}");
    }
}

/// Laplace at the mode sees the width of the banana's skin only.
fn skin() -> DMatrix<f64> {
    DMatrix::from_diagonal(&DVector::from_row_slice(&[1.0, 0.25]))
}

/// Its bend, but for this part of it.
fn bend(missed: f64) -> [Bend; 1] {
    let at = |z: f64| (z, DVector::from_row_slice(&[z, (1.0 - missed) * z * z]));
    [Bend { deviation: DVector::from_row_slice(&[1.0, 0.0]), floor: vec![at(1.0), at(-1.0)] }]
}

fn assert_banana(draws: &[Vec<f64>], tolerance: f64) {
    let ((mean, variance), (along, spread)) = (moments(draws, 1), moments(draws, 0));
    assert!(
        (mean - 1.0).abs() < tolerance && (variance / 2.25 - 1.0).abs() < 2.0 * tolerance,
        "{mean} {variance}"
    );
    assert!(along.abs() < tolerance && (spread - 1.0).abs() < tolerance, "{along} {spread}");
}

#[test]
fn a_banana_whose_bend_is_known_is_sampled_by_importance() {
    for missed in [0.0, 0.1] {
        let mut all = vec![];
        for seed in 0..10 {
            let plan = SamplePlan { proposals: 2000, seed, ..SamplePlan::default() };
            let bends = bend(missed);
            let peak = Peak { mode: &[0.0, 0.0], covariance: &skin(), bends: &bends };
            let found = sample(&mut Banana, peak, &plan).unwrap();
            assert!(found.k_hat < TRUSTED_K_HAT && found.method == Method::Importance, "{}", found.k_hat);
            all.extend(found.draws);
        }
        assert_banana(&all, 0.08);
    }
}

#[test]
fn a_banana_whose_bend_nobody_knows_is_left_to_nuts() {
    let plan = SamplePlan { draws: 20_000, tuning: 1000, ..SamplePlan::default() };
    let peak = Peak { mode: &[0.0, 0.0], covariance: &skin(), bends: &[] };
    let found = sample(&mut Banana, peak, &plan).unwrap();
    assert!(found.k_hat > TRUSTED_K_HAT && found.method == Method::Nuts, "{}", found.k_hat);
    // Draws of a banana remember each other: its arms are narrow for a step that suits its middle.
    assert_banana(&found.draws, 0.25);
}

#[test]
fn nuts_hardly_remembers_in_straightened_variables() {
    let plan = SamplePlan { draws: 1000, ..SamplePlan::default() };
    let bends = bend(0.1);
    let peak = Peak { mode: &[0.0, 0.0], covariance: &skin(), bends: &bends };
    let to = Straightened::new(&peak).unwrap();
    let found = nuts::sample(&mut Banana, &to, &DVector::from_row_slice(&[0.1, 0.1]), &plan).unwrap();
    assert!(found.effective > 250.0, "{}", found.effective);
    assert_banana(&found.draws, 0.15);
}

#[test]
fn what_lies_beyond_a_bound_has_no_weight() {
    struct Half;
    impl Density for Half {
        fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
            (vec![0.0], vec![30.0])
        }
        fn logarithms(&mut self, points: &[Vec<f64>]) -> Result<Vec<f64>, EvaluationFailure> {
            assert!(points.iter().all(|x| x[0] >= 0.0), "a run outside the bounds");
            Ok(points.iter().map(|x| -0.5 * x[0] * x[0]).collect())
        }
        fn with_gradient(&mut self, x: &[f64]) -> Result<Option<(f64, Vec<f64>)>, EvaluationFailure> {
            Ok(Some((-0.5 * x[0] * x[0], vec![-x[0]])))
        }
    }
    // A half normal: mean sqrt(2 / pi).
    let plan = SamplePlan { proposals: 4000, draws: 2000, ..SamplePlan::default() };
    let to =
        Straightened::new(&Peak { mode: &[0.0], covariance: &DMatrix::identity(1, 1), bends: &[] }).unwrap();
    let (by_importance, heaviest) = importance::sample(&mut Half, &to, &plan).unwrap();
    let by_nuts = nuts::sample(&mut Half, &to, &heaviest, &plan).unwrap();
    assert!(
        by_nuts.effective > 500.0 && by_nuts.divergent < 20,
        "{} {}",
        by_nuts.effective,
        by_nuts.divergent
    );
    for found in [by_importance, by_nuts] {
        let mean = moments(&found.draws, 0).0;
        assert!((mean - 0.798).abs() < 0.04, "{mean}");
    }
}
