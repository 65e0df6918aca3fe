//! What the fitted values are worth: covariance, 95 % intervals, correlations.
//!
//! With `J` the Jacobian in the optimiser's (log) variables at the solution and residuals in units of their
//! standard deviation,
//! `C = (J^T J / (s^2 q) + B)^-1 + sum_k g_k g_k^T`, `g_k` the shift of the parameters by `v_k`:
//! - `s^2`: 1 for known noise, but never less than the reduced chi^2 (a model that misses the data is not known
//!   to the data's precision); the reduced chi^2 itself when the noise is unknown;
//! - `q`: integrated autocorrelation time of the residuals in points, where neighbours are correlated;
//! - both of what known noise's common errors leave, `e = r - V (1 + V'V)^-1 V' r`: chi^2 is then `r' (1 + V V')^-1 r = r'e`;
//! - `B`: what the bounds say, `12 / (upper - lower)^2` on the diagonal;
//! - `v_k`: residual caused by one standard deviation of an error common to all points, such as the amplitude
//!   of the specimens.

use super::parameter::{FitParameter, Transform};
use super::problem::FitError;
use super::shared_errors::likeliest_heights;
use super::solution::Solution;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Half-width of the 95 % interval in ln(value) up to which a value counts as determined (a quarter).
pub const DETERMINED_HALF_WIDTH: f64 = 0.25;
/// Beyond this (a factor of three either way) it counts as not determined at all.
pub const UNDETERMINED_HALF_WIDTH: f64 = 1.1;

/// An error that all points share, e.g. the amplitude of a sample of specimens.
#[derive(Debug, Clone, PartialEq)]
pub struct CommonError {
    /// What it is, for the report.
    pub name: String,
    /// Change of the residuals by one standard deviation of it.
    pub residual: Vec<f64>,
}

/// What is known about the noise in the residuals.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Noise {
    /// Residuals are in units of their standard deviation; otherwise that is estimated from the fit.
    pub known: bool,
    /// Errors common to many points.
    pub common: Vec<CommonError>,
    /// Numbers of residuals in consecutive stretches (one per measurement); neighbours within a stretch are
    /// tested for correlation. Empty: no test.
    pub stretches: Vec<usize>,
}

/// A 95 % interval, within the parameter's bounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

/// How well a value is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Determination {
    /// To a quarter or better.
    Determined,
    /// Between a quarter and a factor of three.
    Loose,
    /// Not even to a factor of three.
    Undetermined,
}

impl Determination {
    /// Classifies a half-width in ln(value).
    pub fn of(half_width: f64) -> Self {
        if half_width <= DETERMINED_HALF_WIDTH {
            Self::Determined
        } else if half_width <= UNDETERMINED_HALF_WIDTH {
            Self::Loose
        } else {
            Self::Undetermined
        }
    }
}

/// End of the admissible range at which a value sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BoundSide {
    /// The lower bound of the value.
    Lower,
    /// The upper bound of the value.
    Upper,
}

/// One fitted parameter, values in SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterEstimate {
    /// The parameter.
    pub parameter: FitParameter,
    /// Fitted value.
    pub value: f64,
    /// 95 % interval, cut at the bounds.
    pub interval: Interval,
    /// The interval reaches the lower or upper bound: the data set no limit on that side.
    pub open: [bool; 2],
    /// Half-width of the uncut interval, relative (in ln(value) for log parameters).
    pub half_width: f64,
    /// Part of its square that comes from common errors (0 to 1).
    pub common_share: f64,
    /// How well it is known.
    pub determination: Determination,
    /// Sits at this bound.
    pub at_bound: Option<BoundSide>,
}

/// Everything that follows from residuals and Jacobian at the solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    /// Sum of squared residuals.
    pub chi_square: f64,
    /// Part of it that errors account for which many points share; 0 where the noise is not known.
    pub shared_chi_square: f64,
    /// Number of residuals.
    pub points: usize,
    /// Degrees of freedom.
    pub degrees_of_freedom: usize,
    /// The rest of chi^2 per degree of freedom.
    pub reduced_chi_square: f64,
    /// Standard deviation of a residual that the intervals rest on, `sqrt(s^2 q)`.
    pub noise: f64,
    /// Integrated autocorrelation time of the residuals in points (1: uncorrelated).
    pub correlation_time: f64,
    /// 97.5 % quantile of the t distribution.
    pub t_quantile: f64,
    /// Covariance of the optimiser's variables is `root root^T`.
    root: DMatrix<f64>,
    /// Correlation of each pair.
    pub correlation: DMatrix<f64>,
    /// Estimates in the order of the parameters.
    pub estimates: Vec<ParameterEstimate>,
}

impl Statistics {
    /// Statistics of a solution.
    ///
    /// # Errors
    /// When there are not more residuals than parameters, or sizes do not fit.
    pub fn new(parameters: &[FitParameter], solution: &Solution, noise: &Noise) -> Result<Self, FitError> {
        let (m, n) = solution.jacobian.shape();
        check_sizes(parameters, noise, m, n)?;
        let degrees_of_freedom = m - n;
        let own = own_residual(&solution.residual, noise);
        let shared_chi_square =
            solution.chi_square - own.dot(&DVector::from_column_slice(&solution.residual));
        let reduced = (solution.chi_square - shared_chi_square) / degrees_of_freedom as f64;
        let correlation_time = correlation_time(own.as_slice(), &noise.stretches);
        let scale = if noise.known { reduced.max(1.0) } else { reduced };
        let variance = scale * correlation_time;
        let precision = Precision::new(&solution.jacobian, variance.sqrt(), parameters);
        let random = precision.root();
        let mut root = random.clone().resize_horizontally(n + noise.common.len(), 0.0);
        for (k, common) in noise.common.iter().enumerate() {
            root.set_column(n + k, &precision.shift(&DVector::from_column_slice(&common.residual)));
        }
        let t_quantile = student_quantile(degrees_of_freedom as f64 / correlation_time);
        let estimates = parameters
            .iter()
            .enumerate()
            .map(|(j, p)| {
                let (total, own) = (root.row(j).norm_squared(), random.row(j).norm_squared());
                let common_share = if total > 0.0 { 1.0 - own / total } else { 0.0 };
                estimate(p, solution.x[j], t_quantile * total.sqrt(), common_share)
            })
            .collect();
        Ok(Self {
            chi_square: solution.chi_square,
            shared_chi_square,
            points: m,
            degrees_of_freedom,
            reduced_chi_square: reduced,
            noise: variance.sqrt(),
            correlation_time,
            t_quantile,
            correlation: correlation(&root),
            root,
            estimates,
        })
    }

    /// Half-width of the 95 % interval of a quantity with gradient `gradient` in the optimiser's variables.
    pub fn half_width(&self, gradient: &DVector<f64>) -> f64 {
        // Through the root: the covariance itself cancels catastrophically for the well-determined
        // combination of two parameters that are each undetermined.
        self.t_quantile * self.root.tr_mul(gradient).norm()
    }

    /// Covariance of the optimiser's variables.
    pub fn covariance(&self) -> DMatrix<f64> {
        &self.root * self.root.transpose()
    }
}

/// What the likeliest common errors leave of the residuals, where the noise is known.
fn own_residual(residual: &[f64], noise: &Noise) -> DVector<f64> {
    let residual = DVector::from_column_slice(residual);
    if !noise.known || noise.common.is_empty() {
        return residual;
    }
    let columns: Vec<DVector<f64>> =
        noise.common.iter().map(|c| DVector::from_column_slice(&c.residual)).collect();
    let common = DMatrix::from_columns(&columns);
    let Some((_, heights)) = likeliest_heights(&common, &residual) else { return residual };
    residual - common * heights
}

fn check_sizes(parameters: &[FitParameter], noise: &Noise, m: usize, n: usize) -> Result<(), FitError> {
    let fits = |what, expected, found| {
        if expected == found { Ok(()) } else { Err(FitError::Dimension { what, expected, found }) }
    };
    fits("parameters", n, parameters.len())?;
    for common in &noise.common {
        fits("common error", m, common.residual.len())?;
    }
    if !noise.stretches.is_empty() {
        fits("stretches of residuals", m, noise.stretches.iter().sum())?;
    }
    if m <= n {
        return Err(FitError::Dimension {
            what: "residuals (more than parameters)",
            expected: n + 1,
            found: m,
        });
    }
    Ok(())
}

/// SVD of the Jacobian over the noise, with one row per parameter below it for what its bounds say: a uniform
/// distribution over a range of width W has the variance W^2 / 12. Without it, the linearisation would let a
/// parameter that the data do not feel run far beyond its bounds and take others with it.
struct Precision {
    u: DMatrix<f64>,
    v_t: DMatrix<f64>,
    inverse: DVector<f64>,
    noise: f64,
}

impl Precision {
    fn new(jacobian: &DMatrix<f64>, noise: f64, parameters: &[FitParameter]) -> Self {
        let (m, n) = jacobian.shape();
        // A perfect fit of unknown noise would otherwise divide by zero.
        let noise = noise.max(f64::MIN_POSITIVE.sqrt());
        let mut stacked = (jacobian / noise).resize_vertically(m + n, 0.0);
        for (j, p) in parameters.iter().enumerate() {
            let (low, high) = p.internal_bounds();
            stacked[(m + j, j)] = 12f64.sqrt() / (high - low);
        }
        let svd = stacked.svd(true, true);
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { unreachable!("both sides were asked for") };
        let u = u.rows(0, m).into_owned();
        Self { u, v_t, inverse: svd.singular_values.map(|s| 1.0 / s), noise }
    }

    /// `R` with `R R^T = C`.
    fn root(&self) -> DMatrix<f64> {
        self.v_t.transpose() * DMatrix::from_diagonal(&self.inverse)
    }

    /// Shift of the parameters by a common shift `v` of the residuals.
    fn shift(&self, v: &DVector<f64>) -> DVector<f64> {
        self.v_t.tr_mul(&self.u.tr_mul(v).component_mul(&self.inverse)) / self.noise
    }
}

fn correlation(root: &DMatrix<f64>) -> DMatrix<f64> {
    let covariance = root * root.transpose();
    DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        match (i == j, scale > 0.0) {
            (true, _) => 1.0,
            (false, true) => (covariance[(i, j)] / scale).clamp(-1.0, 1.0),
            (false, false) => 0.0,
        }
    })
}

fn student_quantile(degrees_of_freedom: f64) -> f64 {
    // Only a non-positive number of degrees of freedom is refused, and that is excluded here.
    StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0)).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

fn estimate(p: &FitParameter, x: f64, half_width_x: f64, common_share: f64) -> ParameterEstimate {
    let (low, high) = p.internal_bounds();
    let reach = |x: f64| p.to_value(x.clamp(low, high));
    let (a, b) = (reach(x - half_width_x), reach(x + half_width_x));
    let (mut open, mut interval) =
        ([x - half_width_x <= low, x + half_width_x >= high], Interval { lower: a.min(b), upper: a.max(b) });
    let near = 0.01 * (high - low).min(1.0);
    let mut at_bound = match () {
        () if x - low < near => Some(BoundSide::Lower),
        () if high - x < near => Some(BoundSide::Upper),
        () => None,
    };
    if let Transform::Logarithmic { negative: true } = p.transform {
        open.swap(0, 1);
        at_bound = at_bound.map(|side| match side {
            BoundSide::Lower => BoundSide::Upper,
            BoundSide::Upper => BoundSide::Lower,
        });
    }
    let value = p.to_value(x);
    // A value a rounding error outside its own cut interval would look like a mistake.
    interval.lower = interval.lower.min(value);
    interval.upper = interval.upper.max(value);
    let half_width = half_width_x * p.relative_slope(x);
    ParameterEstimate {
        parameter: p.clone(),
        value,
        interval,
        open,
        half_width,
        common_share,
        determination: Determination::of(half_width),
        at_bound,
    }
}

/// Integrated autocorrelation time of the residuals over their stretches, at least 1; 1 unless the lag-1
/// correlation is significant. Summed up to the first non-positive term.
fn correlation_time(residual: &[f64], stretches: &[usize]) -> f64 {
    let mut parts = vec![];
    let mut from = 0;
    for &length in stretches {
        let part = &residual[from..from + length];
        let mean = part.iter().sum::<f64>() / length.max(1) as f64;
        parts.push(part.iter().map(|r| r - mean).collect::<Vec<_>>());
        from += length;
    }
    let total: f64 = parts.iter().flatten().map(|r| r * r).sum();
    let longest = stretches.iter().copied().max().unwrap_or(0);
    let rho = |lag: usize| {
        let sum: f64 =
            parts.iter().map(|p| p.iter().zip(p.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>()).sum();
        sum / total
    };
    let significant = 2.0 / (residual.len().max(1) as f64).sqrt();
    if total == 0.0 || longest < 8 || rho(1) < significant {
        return 1.0;
    }
    1.0 + 2.0 * (1..longest / 2).map(rho).take_while(|&r| r > 0.0).sum::<f64>()
}

#[cfg(test)]
#[path = "statistics_tests.rs"]
mod tests;
