//! Prediction of what was not fitted.
//!
//! Around its optimum a model is linear: fitting some points and predicting the others is then algebra, and errors common to both are
//! carried over as they are.

use super::normal_equations::{NormalEquations, scaled_rows};
use crate::inference::effect::{Candidate, Scope};
use crate::inference::fit::Fit;
use crate::noise::Observation;
use nalgebra::{DMatrix, DVector};

/// Points that are fitted and points that are predicted.
#[derive(Debug, Clone, PartialEq)]
pub struct Split {
    /// In words.
    pub name: String,
    /// Fitted points.
    pub fitted: Vec<usize>,
    /// Predicted points.
    pub predicted: Vec<usize>,
    /// Whether whole tests are predicted.
    pub is_of_tests: bool,
}

impl Split {
    /// Whether it can say anything of these effects: what differs between tests is not learned without one of them.
    pub fn can_tell(&self, members: &[usize], candidates: &[Candidate]) -> bool {
        !self.is_of_tests || members.iter().all(|k| candidates[*k].effect.scope == Scope::Shared)
    }
}

/// Every test predicted from the others, and late cycles from early ones.
pub fn splits(observations: &[Observation]) -> Vec<Split> {
    let mut labels = Vec::new();
    for (test, o) in observations.iter().enumerate() {
        labels.extend(o.cycle.iter().map(|&cycle| (test, cycle)));
    }
    let split = |name: String, is_of_tests: bool, is_predicted: &dyn Fn(usize, usize) -> bool| {
        let chosen = |wanted: bool| {
            (0..labels.len()).filter(|&i| is_predicted(labels[i].0, labels[i].1) == wanted).collect()
        };
        Split { name, fitted: chosen(false), predicted: chosen(true), is_of_tests }
    };
    let mut all = Vec::new();
    if observations.len() > 1 {
        for (test, o) in observations.iter().enumerate() {
            all.push(split(format!("{} predicted from the rest", o.name()), true, &|t, _| t == test));
        }
    }
    let cycles = observations.iter().map(|o| o.cycles.len()).min().unwrap_or(0);
    if cycles > 1 {
        let early = cycles.div_ceil(2);
        let name = format!("cycles after {early} predicted from those before");
        all.push(split(name, false, &|_, c| c >= early));
    }
    all
}

/// A model that fits one part and predicts the other.
pub struct Predictor {
    split: Split,
    /// What the fitted points tell.
    known: NormalEquations,
    /// Rows of the predicted points.
    predicted: DMatrix<f64>,
    /// White deviation of the predicted points (mN).
    white_mn: DVector<f64>,
    /// Deviation of the prediction's error at each predicted point (mN).
    pub deviation_mn: DVector<f64>,
    /// Share of the prior's variance of each variable that the fitted points leave.
    pub left: Vec<f64>,
}

impl Predictor {
    /// Of a fit; `None` where the normal equations cannot be solved.
    pub fn new(fit: &Fit, split: &Split) -> Option<Self> {
        let covariance = &fit.covariance;
        let (n, variables) = fit.jacobian_mn.shape();
        let common = covariance.common_columns();
        let mut all = DMatrix::zeros(n, variables + common.ncols());
        all.columns_mut(0, variables).copy_from(&fit.jacobian_mn);
        all.columns_mut(variables, common.ncols()).copy_from(&common);
        let white_mn = |points: &[usize]| covariance.white_mn().select_rows(points);
        let known = NormalEquations::new(fit, all.select_rows(&split.fitted), &white_mn(&split.fitted))?;
        let left = known.left[..variables].to_vec();
        let predicted = all.select_rows(&split.predicted);
        let white_mn = white_mn(&split.predicted);
        let half = known.precision.l().solve_lower_triangular(&predicted.transpose())?;
        let deviation_mn = DVector::from_fn(white_mn.len(), |i, _| {
            (half.column(i).norm_squared() + white_mn[i].powi(2)).sqrt()
        });
        Some(Self { split: split.clone(), known, predicted, white_mn, deviation_mn, left })
    }

    /// What is predicted from what.
    pub fn split(&self) -> &Split {
        &self.split
    }

    /// The predicted points.
    pub fn points(&self) -> &[usize] {
        &self.split.predicted
    }

    /// Measured minus predicted (mN) at the predicted points, for `gap_mn` measured minus model at the optimum.
    pub fn error_mn(&self, gap_mn: &DVector<f64>) -> DVector<f64> {
        let found = self.known.solve(&gap_mn.select_rows(&self.split.fitted));
        gap_mn.select_rows(&self.split.predicted) - &self.predicted * found
    }

    /// Twice the log of the density that the prediction gave to what was measured at some of its points.
    pub fn log_score(&self, error_mn: &DVector<f64>, points: &[usize]) -> f64 {
        let white = self.white_mn.select_rows(points);
        let rows = self.predicted.select_rows(points);
        // Post = inv(H) = inv(L') inv(L): its half times the rows are errors that the predicted points share.
        let Some(half) = self.known.precision.l().solve_lower_triangular(&rows.transpose()) else {
            return f64::NEG_INFINITY;
        };
        let v = scaled_rows(&half.transpose(), &white.map(|s| 1.0 / s));
        let e = error_mn.select_rows(points).component_div(&white);
        let small = DMatrix::identity(v.ncols(), v.ncols()) + v.tr_mul(&v);
        let Some(small) = small.cholesky() else { return f64::NEG_INFINITY };
        let projected = v.tr_mul(&e);
        let square = e.norm_squared() - projected.dot(&small.solve(&projected));
        let log_white: f64 = 2.0 * white.iter().map(|s| s.ln()).sum::<f64>();
        let log_small: f64 = 2.0 * small.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        -square - log_white - log_small
    }
}
