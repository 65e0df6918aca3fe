//! What the fitted values are worth: covariance, 95 % intervals, correlations.
//!
//! With `J` the derivatives of the force at the solution, `Sigma` the covariance of the data and `P` the precision of what was known
//! before, the variables have the covariance `C = (J' Sigma^-1 J + P)^-1`, the sum of what each error of the data contributes,
//! `C J' Sigma^-1 [white part and common errors] Sigma^-1 J C`, and of `C P C`.
//! - `Sigma` is taken `s^2` times as large, `s^2` the chi^2 per degree of freedom where that is above 1 (a model that misses the data
//!   is not known to the data's precision), or where the size of the noise is unknown; its white part `q` times more, `q` the
//!   integrated autocorrelation time of the residuals in points.
//! - The quantile is Student's t with Satterthwaite's degrees of freedom: a contribution `v_k` to a variance that was estimated with
//!   `n_k` degrees (n - 1 of n specimens) counts as such, `(sum v_k)^2 / sum (v_k^2 / n_k)`.
//! - An interval says what the data say: the prior of the variables that the quantity is made of is taken out of their covariance,
//!   and where nothing is left the interval is open. The priors of the other variables stay in.

mod bend;
mod curvature;
mod estimate;

pub use bend::Bend;
pub use estimate::{BoundSide, Determination, Interval, ParameterEstimate};

use super::fit::Fit;
use super::parameter::FitParameter;
use super::resolution::Resolution;
use super::unknowns::Unknowns;
use crate::fit::{FitError, Prior, Whitening, likeliest_heights};
use crate::noise::Covariance;
use curvature::{Curvature, correlation};
use estimate::{of_product, of_variable};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Half-width of the 95 % interval in ln(value) up to which a value counts as determined (a quarter).
pub const DETERMINED_HALF_WIDTH: f64 = 0.25;
/// Beyond this (a factor of three either way) it counts as not determined at all.
pub const UNDETERMINED_HALF_WIDTH: f64 = 1.1;
/// Half-width in ln(value) of one of which nothing is known: beyond any bounds, and its exponential is still a number.
const NOTHING_KNOWN: f64 = 300.0;
/// Less information than this part of the prior's is rounding.
const NO_INFORMATION: f64 = 1e-6;

/// Everything that follows from a fit.
#[derive(Debug, Clone)]
pub struct Statistics {
    /// `(measured - model)' Sigma^-1 (measured - model)`.
    pub chi_square: f64,
    /// Part of it that the heights of the errors account for which many points share.
    pub shared_chi_square: f64,
    /// Number of points.
    pub points: usize,
    /// Degrees of freedom.
    pub degrees_of_freedom: usize,
    /// chi^2 per degree of freedom.
    pub reduced_chi_square: f64,
    /// Factor on the deviations of the data that the intervals rest on, `s`.
    pub scale: f64,
    /// Integrated autocorrelation time of the residuals in points (1: uncorrelated).
    pub correlation_time: f64,
    /// Whether the size of the noise was known.
    pub noise_known: bool,
    /// Columns whose squares sum up to the variables' covariance: the white part, the common errors, the prior.
    root: DMatrix<f64>,
    /// Degrees of freedom of each block of columns of `root`: its first column, and its degrees.
    blocks: Vec<(usize, f64)>,
    /// First column of `root`, and number of them, that are errors which the fit takes up.
    unseen: (usize, usize),
    /// The covariance of the data that all this rests on.
    pub covariance: Covariance,
    /// Variances of the variables before the measurement.
    prior: DVector<f64>,
    /// Whitened derivatives by the `terms`.
    pub design: DMatrix<f64>,
    /// The same over the white deviation of each point alone.
    pub white_design: DMatrix<f64>,
    /// Correlation of each pair of the fitted parameters.
    pub correlation: DMatrix<f64>,
    /// The variables as people count them ([`Unknowns::terms`]).
    pub terms: Vec<ParameterEstimate>,
    /// Correlation of each pair of them.
    pub term_correlation: DMatrix<f64>,
    /// The fitted parameters under the FMU's names.
    pub estimates: Vec<ParameterEstimate>,
    /// How the directions that the data hardly determine bend.
    bends: Vec<Bend>,
    /// Which branches the data tell apart.
    pub resolution: Resolution,
}

impl Statistics {
    /// Statistics of a fit of the plain model; `stretches` are the numbers of points in a row (one per measurement), whose
    /// neighbours are tested for correlation.
    ///
    /// # Errors
    /// When there are not more points than variables.
    pub fn new(unknowns: &Unknowns, fit: &Fit, stretches: &[usize]) -> Result<Self, FitError> {
        let (m, n) = fit.jacobian_mn.shape();
        if m <= n {
            let what = "points (more than parameters)";
            return Err(FitError::Dimension { what, expected: n + 1, found: m });
        }
        let degrees_of_freedom = m - n;
        let known = fit.covariance.is_known();
        let own = white_residual(fit);
        let chi_square = fit.covariance.apply(&fit.gap_mn).norm_squared();
        let reduced = chi_square / degrees_of_freedom as f64;
        let correlation_time = correlation_time(own.as_slice(), stretches);
        let square = if known { reduced.max(1.0) } else { reduced };
        // A perfect fit of unknown noise would otherwise divide by zero.
        let scale = square.sqrt().max(f64::MIN_POSITIVE.sqrt());
        let covariance = fit.covariance.scaled(scale, correlation_time.sqrt());
        let design = covariance.apply_columns(&fit.jacobian_mn);
        let curvature = Curvature::new(&design, &fit.prior.deviation);
        let mut blocks = vec![(0, degrees_of_freedom as f64 / correlation_time)];
        let mut columns = curvature.white(&covariance);
        for common in covariance.common().iter().chain(covariance.absorbed()) {
            blocks.push((columns.len(), common.degrees));
            columns.push(curvature.shift(&covariance.apply(&common.shape_mn)));
        }
        let unseen = (columns.len() - covariance.absorbed().len(), covariance.absorbed().len());
        blocks.push((columns.len(), f64::INFINITY));
        columns.extend(curvature.prior(&fit.prior.deviation));
        let root = DMatrix::from_columns(&columns);
        let white_design = {
            let mut rows = fit.jacobian_mn.clone();
            rows.column_iter_mut().for_each(|mut c| c.component_div_assign(covariance.white_mn()));
            rows
        };
        let mut statistics = Self {
            chi_square,
            shared_chi_square: (chi_square - own.norm_squared()).max(0.0),
            points: m,
            degrees_of_freedom,
            reduced_chi_square: reduced,
            scale,
            correlation_time,
            noise_known: known,
            root,
            blocks,
            unseen,
            covariance,
            prior: DVector::from_iterator(n, fit.prior.deviation.iter().map(|s| s * s)),
            design,
            white_design,
            correlation: DMatrix::zeros(0, 0),
            term_correlation: DMatrix::zeros(0, 0),
            terms: vec![],
            estimates: vec![],
            bends: vec![],
            resolution: Resolution::default(),
        };
        statistics.estimate(unknowns, &fit.solution.x);
        // The derivative by a term leaves the other terms as they are.
        if let Some(back) = unknowns.terms().1.try_inverse() {
            statistics.design = &statistics.design * &back;
            statistics.white_design = &statistics.white_design * back;
        }
        Ok(statistics)
    }

    /// The same with what is known of the bends of its valley.
    #[must_use]
    pub fn along(mut self, unknowns: &Unknowns, x: &[f64], bends: Vec<Bend>) -> Self {
        self.bends = bends;
        self.estimate(unknowns, x);
        self
    }

    /// How the directions that the data hardly determine bend, where that was asked for.
    pub fn bends(&self) -> &[Bend] {
        &self.bends
    }

    /// The same with what is known of the branches: by number nothing is claimed of those that the data do not tell apart.
    #[must_use]
    pub fn resolved(mut self, resolution: Resolution) -> Self {
        self.resolution = resolution;
        self.mark_unresolved();
        self
    }

    fn mark_unresolved(&mut self) {
        for e in self.terms.iter_mut().chain(&mut self.estimates) {
            let is_arbitrary = self.resolution.is_arbitrary(&e.parameter.name);
            e.determination = e.determination.unresolved_if(is_arbitrary);
        }
    }

    /// How far the 95 % interval of a quantity reaches down and up, where `moved(by)` is its change from the optimum: the linearised fit's
    /// half-width, and to the second order what the bends of the valley do to its mean and variance.
    pub fn reach(&self, gradient: &DVector<f64>, moved: &dyn Fn(&DVector<f64>) -> Option<f64>) -> [f64; 2] {
        let half_width = self.half_width(gradient);
        let quantile = self.quantile(gradient);
        let (mut mean, mut variance) = (0.0, (half_width / quantile).powi(2));
        for bend in &self.bends {
            let (shift, more) = bend.moments(gradient, moved);
            mean += shift;
            variance += more;
        }
        let wide = (quantile * variance.sqrt()).min(NOTHING_KNOWN);
        [(wide - mean).max(0.0), (wide + mean).max(0.0)]
    }

    /// Least squares around `x`: whitened derivatives and gap (mN), below them the rows of the prior of the variables that `prior_of` names, or
    /// zeros where the size of the noise is not known.
    pub(super) fn stacked(
        &self,
        prior: &Prior,
        x: &DVector<f64>,
        (jacobian_mn, gap_mn): (&DMatrix<f64>, &DVector<f64>),
        prior_of: &dyn Fn(usize) -> bool,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let (m, n) = jacobian_mn.shape();
        let mut design = self.covariance.apply_columns(jacobian_mn).resize_vertically(m + n, 0.0);
        let mut rest = self.covariance.apply(gap_mn).resize_vertically(m + n, 0.0);
        for j in (0..n).filter(|&j| prior_of(j) && self.covariance.is_known()) {
            design[(m + j, j)] = 1.0 / prior.deviation[j];
            rest[m + j] = (prior.mean[j] - x[j]) / prior.deviation[j];
        }
        (design, rest)
    }

    /// Half-width of the 95 % interval of a quantity with gradient `gradient` in the optimiser's variables, by what the data say of
    /// the variables that it is made of: `(C_pp^-1 - P_pp)^-1` for their block of covariance and prior precision.
    pub fn half_width(&self, gradient: &DVector<f64>) -> f64 {
        let own: Vec<usize> = (0..gradient.len()).filter(|&j| gradient[j] != 0.0).collect();
        // In units of the prior's deviations.
        let deviations = self.prior.select_rows(&own).map(f64::sqrt);
        let mut root = self.root.select_rows(&own);
        root.row_iter_mut().zip(deviations.iter()).for_each(|(mut row, s)| row /= *s);
        let block = &root * root.transpose();
        let Some(information) = block.try_inverse().map(|i| i - DMatrix::identity(own.len(), own.len()))
        else {
            return NOTHING_KNOWN;
        };
        let eigen = information.symmetric_eigen();
        let along = eigen.eigenvectors.tr_mul(&gradient.select_rows(&own).component_mul(&deviations));
        let each = along.iter().zip(eigen.eigenvalues.iter());
        let variance: f64 = each.map(|(g, known)| g * g / known.max(NO_INFORMATION)).sum();
        (self.quantile(gradient) * variance.sqrt()).min(NOTHING_KNOWN)
    }

    /// Standard deviation of a quantity by what no fit sees, such as the common height of the specimens.
    pub fn unseen(&self, gradient: &DVector<f64>) -> f64 {
        self.root.tr_mul(gradient).rows(self.unseen.0, self.unseen.1).norm()
    }

    /// The half-width without that.
    pub fn seen_half_width(&self, gradient: &DVector<f64>) -> f64 {
        let unseen = self.quantile(gradient) * self.unseen(gradient);
        let all = self.half_width(gradient);
        (all * all - unseen * unseen).max(0.01 * all * all).sqrt()
    }

    /// Variance of a quantity, and the part of it that comes from errors which many points share.
    fn variance(&self, gradient: &DVector<f64>) -> (f64, f64) {
        // Through the root: the covariance itself cancels catastrophically for the well-determined
        // combination of two parameters that are each undetermined.
        let along = self.root.tr_mul(gradient);
        let first = self.blocks.get(1).map_or(along.len(), |b| b.0);
        let last = self.blocks.last().map_or(along.len(), |b| b.0);
        (along.norm_squared(), along.rows(first, last - first).norm_squared())
    }

    /// 97.5 % quantile of the t distribution for a quantity.
    pub fn quantile(&self, gradient: &DVector<f64>) -> f64 {
        let along = self.root.tr_mul(gradient);
        let ends = self.blocks.iter().skip(1).map(|b| b.0).chain([along.len()]);
        let (mut sum, mut squares) = (0.0, 0.0);
        // What is known before is no estimate: its block comes last and is left out.
        for ((first, degrees), end) in self.blocks.iter().zip(ends).take(self.blocks.len() - 1) {
            let part = along.rows(*first, end - first).norm_squared();
            sum += part;
            squares += part * part / degrees;
        }
        student_quantile(if squares > 0.0 { sum * sum / squares } else { f64::INFINITY })
    }

    /// Covariance of the optimiser's variables.
    pub fn of_variables(&self) -> DMatrix<f64> {
        &self.root * self.root.transpose()
    }

    /// Covariance of the optimiser's variables by all that a fit sees.
    pub fn of_what_a_fit_sees(&self) -> DMatrix<f64> {
        let shifts = self.root.columns(self.unseen.0, self.unseen.1);
        self.of_variables() - shifts * shifts.transpose()
    }

    /// What each error that no fit sees adds to the variables when it is one deviation large, and its degrees of freedom.
    pub fn unseen_shifts(&self) -> Vec<(DVector<f64>, f64)> {
        let degrees = |column: usize| {
            let block = self.blocks.partition_point(|(first, _)| *first <= column);
            self.blocks.get(block.saturating_sub(1)).map_or(f64::INFINITY, |b| b.1)
        };
        let columns = self.unseen.0..self.unseen.0 + self.unseen.1;
        columns.map(|k| (self.root.column(k).into_owned(), degrees(k))).collect()
    }

    fn estimate(&mut self, unknowns: &Unknowns, x: &[f64]) {
        let (terms, rows) = unknowns.terms();
        let share = |gradient: &DVector<f64>| {
            let (total, shared) = self.variance(gradient);
            if total > 0.0 { shared / total } else { 0.0 }
        };
        let in_terms = &rows * DVector::from_column_slice(x);
        let of_row = |(j, p): (usize, &FitParameter)| {
            let gradient = rows.row(j).transpose();
            let reach = self.reach(&gradient, &|moved| Some(gradient.dot(moved)));
            of_variable(p, in_terms[j], reach, share(&gradient))
        };
        let terms: Vec<ParameterEstimate> = terms.iter().enumerate().map(of_row).collect();
        let values = unknowns.settings(x);
        let mut gradients = Vec::new();
        let estimates = unknowns.free().iter().enumerate().map(|(j, p)| {
            if *p == unknowns.variables()[j] {
                gradients.push(rows.row(j).transpose());
                return terms[j].clone();
            }
            let value = values[&p.name];
            let mut gradient = DVector::zeros(x.len());
            let follows = unknowns.gradient(x, &p.name);
            follows.iter().for_each(|(k, slope)| gradient[*k] = slope / value);
            let reach = self.reach(&gradient, &|moved| Some(gradient.dot(moved)));
            let side = |k: usize| of_variable(&unknowns.variables()[k], x[k], [0.0; 2], 0.0).at_bound;
            let bound = follows.iter().find_map(|(k, slope)| Some((side(*k)?, slope / value)));
            let found = of_product(p, value, reach, share(&gradient), bound);
            gradients.push(gradient);
            found
        });
        let estimates = estimates.collect();
        let along: Vec<_> = gradients.iter().map(|g| self.root.tr_mul(g)).collect();
        self.correlation = correlation(&DMatrix::from_columns(&along).transpose());
        self.term_correlation = correlation(&(&rows * &self.root));
        (self.terms, self.estimates) = (terms, estimates);
        self.mark_unresolved();
    }
}

/// What the likeliest common errors leave of the gap, in units of the white noise.
pub fn white_residual(fit: &Fit) -> DVector<f64> {
    let white = fit.covariance.white_mn();
    let scaled = fit.gap_mn.component_div(white);
    let mut columns = fit.covariance.common_columns();
    columns.column_iter_mut().for_each(|mut c| c.component_div_assign(white));
    let Some((_, heights)) = likeliest_heights(&columns, &scaled) else { return scaled };
    scaled - columns * heights
}

fn student_quantile(degrees_of_freedom: f64) -> f64 {
    /// Beyond this the t distribution is normal to six digits.
    const MANY: f64 = 1e6;
    // Only a non-positive number of degrees of freedom is refused, and that is excluded here.
    StudentsT::new(0.0, 1.0, degrees_of_freedom.clamp(1.0, MANY))
        .map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
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
