//! Generalised least squares: problems whose residuals share errors, with what is known of their variables before
//! the measurement as further residuals.

use super::problem::{EvaluationFailure, Problem};
use super::products::products;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// A linear map that makes correlated noise white: `Cov(apply(noise)) = 1`.
pub trait Whitening {
    /// The whitened vector.
    fn apply(&self, values: &DVector<f64>) -> DVector<f64>;

    /// The transpose of the map, applied to white values, times the independent deviation of each point: a vector whose square is
    /// the part of `|values|^2` that the independent errors cause.
    fn white_part(&self, values: &DVector<f64>) -> DVector<f64>;

    /// The whitened columns.
    fn apply_columns(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut whitened = columns.clone();
        whitened
            .column_iter_mut()
            .for_each(|mut column| column.copy_from(&self.apply(&column.clone_owned())));
        whitened
    }
}

/// Normal knowledge of each variable before the measurement.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Prior {
    /// Mean of each variable.
    pub mean: Vec<f64>,
    /// Standard deviation of each variable.
    pub deviation: Vec<f64>,
}

impl Prior {
    /// `(x - mean) / deviation`.
    pub fn residual(&self, x: &[f64]) -> Vec<f64> {
        x.iter().zip(self.mean.iter().zip(&self.deviation)).map(|(x, (m, s))| (x - m) / s).collect()
    }

    /// No knowledge.
    #[must_use]
    pub fn flat(&self) -> Self {
        Self { mean: self.mean.clone(), deviation: vec![f64::INFINITY; self.mean.len()] }
    }

    /// The same knowledge and that of further variables.
    #[must_use]
    pub fn with(&self, mean: f64, deviation: f64) -> Self {
        let mut longer = self.clone();
        longer.mean.push(mean);
        longer.deviation.push(deviation);
        longer
    }
}

/// Independent deviations of residuals, and errors that they share, which may grow with what is computed.
pub trait SharedNoise {
    /// Deviation of each residual.
    fn white(&self) -> &DVector<f64>;

    /// The shared errors where these values are computed: a column each, one standard deviation large.
    fn shared(&self, computed: &DVector<f64>) -> DMatrix<f64>;

    /// Whether each of them grows with what is computed; the others are the same wherever.
    fn grows(&self) -> Vec<bool>;

    /// Change of each point of `shared(computed) * heights` per change of what is computed there.
    fn growth(&self, heights: &DVector<f64>) -> DVector<f64>;
}

/// A problem whose residuals (computed minus measured) share errors: their heights `u`, standard normal, are fitted
/// along and eliminated (variable projection, Kaufman's Jacobian).
///
/// Residuals `[(f - y + A(f) u) / s; u; prior]`, with the best `u` for each `f`: their square is
/// `(f - y)' Sigma(f)^-1 (f - y)` with `Sigma(f) = S^2 + A A'`. An error in proportion to the force has to grow with the
/// computed force: were it fixed, a model of half the height would miss by half of everything (Peelle's puzzle).
pub struct SharedErrors<'a, P, N> {
    problem: P,
    noise: &'a N,
    measured: DVector<f64>,
    prior: Prior,
    grows: Vec<bool>,
    /// `V'V`, where both errors are the same wherever.
    fixed: DMatrix<f64>,
}

/// Shared errors at one point, and their best heights.
struct Heights {
    /// `A / s`.
    columns: DMatrix<f64>,
    normal: Cholesky<f64, Dyn>,
    /// `u`.
    best: DVector<f64>,
}

impl<'a, P: Problem, N: SharedNoise> SharedErrors<'a, P, N> {
    /// The problem with this noise; `prior` has one entry per variable.
    pub fn new(problem: P, noise: &'a N, measured: DVector<f64>, prior: Prior) -> Self {
        let grows = noise.grows();
        let columns = scaled(noise.shared(&measured), noise.white());
        let fixed = products(&columns, |i, j| (grows[i] || grows[j]).then_some(0.0));
        Self { problem, noise, measured, prior, grows, fixed }
    }

    /// The problem without its noise.
    pub fn inner(&self) -> &P {
        &self.problem
    }

    fn heights(&self, raw: &DVector<f64>) -> Result<Heights, EvaluationFailure> {
        let white = self.noise.white();
        let columns = scaled(self.noise.shared(&(raw + &self.measured)), white);
        let known = |i: usize, j: usize| (!self.grows[i] && !self.grows[j]).then(|| self.fixed[(i, j)]);
        let (normal, likeliest) = by_products(products(&columns, known), &columns, &raw.component_div(white))
            .ok_or_else(|| EvaluationFailure::Failed("forces are not finite".to_owned()))?;
        Ok(Heights { columns, normal, best: -likeliest })
    }
}

/// Factors of `1 + V'V` and the likeliest heights `(1 + V'V)^-1 V' r` of the errors `V`, for residuals in units of the white
/// noise; `None` only where values are not finite.
pub fn likeliest_heights(
    columns: &DMatrix<f64>,
    residual: &DVector<f64>,
) -> Option<(Cholesky<f64, Dyn>, DVector<f64>)> {
    by_products(products(columns, |_, _| None), columns, residual)
}

/// The same, where `V'V` is known.
fn by_products(
    products: DMatrix<f64>,
    columns: &DMatrix<f64>,
    residual: &DVector<f64>,
) -> Option<(Cholesky<f64, Dyn>, DVector<f64>)> {
    let k = columns.ncols();
    let normal = (DMatrix::identity(k, k) + products).cholesky()?;
    let heights = normal.solve(&columns.tr_mul(residual));
    Some((normal, heights))
}

/// Rows divided by `white`.
fn scaled(mut columns: DMatrix<f64>, white: &DVector<f64>) -> DMatrix<f64> {
    columns.column_iter_mut().for_each(|mut c| c.component_div_assign(white));
    columns
}

impl<P: Problem, N: SharedNoise> Problem for SharedErrors<'_, P, N> {
    fn dimension(&self) -> usize {
        self.problem.dimension()
    }

    fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
        let raw = DVector::from_vec(self.problem.residual(x)?);
        let heights = self.heights(&raw)?;
        let left = raw.component_div(self.noise.white()) + &heights.columns * &heights.best;
        Ok(left.iter().copied().chain(heights.best.iter().copied()).chain(self.prior.residual(x)).collect())
    }

    fn jacobian(&mut self, x: &[f64], r: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
        // The inner problem may difference its own residuals: it must see those.
        let inner = self.problem.residual(x)?;
        let raw = DVector::from_vec(inner.clone());
        let heights = self.heights(&raw)?;
        let mut change = self.problem.jacobian(x, &inner)?;
        let factor = self.noise.growth(&heights.best).add_scalar(1.0);
        change.column_iter_mut().for_each(|mut column| column.component_mul_assign(&factor));
        let change = scaled(change, self.noise.white());
        let taken_up = heights.normal.solve(&heights.columns.tr_mul(&change));
        let (data, k, n) = (change.nrows(), heights.best.len(), x.len());
        debug_assert_eq!(data + k + n, r.len());
        let mut all = DMatrix::zeros(data + k + n, n);
        all.rows_mut(0, data).copy_from(&(change - &heights.columns * &taken_up));
        all.rows_mut(data, k).copy_from(&-taken_up);
        for (j, deviation) in self.prior.deviation.iter().enumerate() {
            all[(data + k + j, j)] = 1.0 / deviation;
        }
        Ok(all)
    }

    fn prefetch(&mut self, points: &[Vec<f64>]) {
        self.problem.prefetch(points);
    }

    fn rejected(&mut self, x: &[f64]) {
        self.problem.rejected(x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Bounds, Options, minimise};
    use std::ops::ControlFlow;

    /// Two measurements of one number that share an error: computed `(x, x)`, measured `(1, 4)`.
    struct Twice;

    const MEASURED: [f64; 2] = [1.0, 4.0];

    impl Problem for Twice {
        fn dimension(&self) -> usize {
            1
        }
        fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, EvaluationFailure> {
            Ok(MEASURED.iter().map(|y| x[0] - y).collect())
        }
        fn jacobian(&mut self, _: &[f64], _: &[f64]) -> Result<DMatrix<f64>, EvaluationFailure> {
            Ok(DMatrix::from_element(2, 1, 1.0))
        }
    }

    /// White noise, and a shared error: fixed, or this part of what is computed.
    struct Simple {
        white: DVector<f64>,
        fixed: f64,
        part: f64,
    }

    impl SharedNoise for Simple {
        fn white(&self) -> &DVector<f64> {
            &self.white
        }
        fn shared(&self, computed: &DVector<f64>) -> DMatrix<f64> {
            let fixed = DVector::from_element(computed.len(), self.fixed);
            DMatrix::from_columns(&[fixed, computed * self.part])
        }
        fn grows(&self) -> Vec<bool> {
            vec![false, true]
        }
        fn growth(&self, heights: &DVector<f64>) -> DVector<f64> {
            DVector::from_element(self.white.len(), self.part * heights[1])
        }
    }

    fn solve(noise: &Simple, prior: Prior) -> (f64, f64) {
        let mut problem = SharedErrors::new(Twice, noise, DVector::from_row_slice(&MEASURED), prior);
        let go = &mut |_: &_| ControlFlow::Continue(());
        let found = minimise(&mut problem, &[0.5], &Bounds::none(1), &Options::default(), go).unwrap();
        (found.x[0], found.jacobian.column(0).norm_squared())
    }

    #[test]
    fn the_minimum_is_the_generalised_least_squares_estimate() {
        let noise = Simple { white: DVector::from_vec(vec![0.6, 1.8]), fixed: 0.9, part: 0.0 };
        let (x, curvature) = solve(&noise, Prior { mean: vec![2.0], deviation: vec![0.5] });
        let covariance = DMatrix::from_diagonal(&noise.white.component_mul(&noise.white)).add_scalar(0.81);
        let weight = covariance.try_inverse().unwrap();
        let ones = DVector::from_element(2, 1.0);
        let y = DVector::from_row_slice(&MEASURED);
        let precision = ones.dot(&(&weight * &ones)) + 4.0;
        let expected = (ones.dot(&(&weight * y)) + 4.0 * 2.0) / precision;
        assert!((x - expected).abs() < 1e-6, "{x} {expected}");
        assert!((curvature - precision).abs() < 1e-9);
    }

    #[test]
    fn errors_in_proportion_do_not_make_a_model_too_low() {
        // Peelle's puzzle: the best common value of 1 and 4 with a shared error of 50 % lies between them.
        let prior = Prior { mean: vec![2.5], deviation: vec![1e3] };
        let noise = Simple { white: DVector::from_vec(vec![0.2, 0.2]), fixed: 0.0, part: 0.5 };
        let (x, _) = solve(&noise, prior.clone());
        assert!((x - 2.5).abs() < 1e-3, "{x}");
    }

    #[test]
    fn the_jacobian_gives_the_gradient_of_the_square() {
        let prior = Prior { mean: vec![2.0], deviation: vec![3.0] };
        let noise = Simple { white: DVector::from_vec(vec![0.6, 1.8]), fixed: 0.4, part: 0.3 };
        let mut problem = SharedErrors::new(Twice, &noise, DVector::from_row_slice(&MEASURED), prior);
        let mut square = |x: f64| problem.residual(&[x]).unwrap().iter().map(|r| r * r).sum::<f64>();
        let slope = (square(1.7001) - square(1.6999)) / 2e-4;
        let r = problem.residual(&[1.7]).unwrap();
        let j = problem.jacobian(&[1.7], &r).unwrap();
        let gradient = 2.0 * j.column(0).dot(&DVector::from_vec(r));
        assert!((gradient - slope).abs() < 1e-6 * slope.abs(), "{gradient} {slope}");
    }
}
