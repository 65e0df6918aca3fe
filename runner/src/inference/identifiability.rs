//! What the data do not determine: directions of the log parameters along which the residuals hardly change.
//!
//! The SVD of the Jacobian gives orthogonal directions with their sensitivities; those along which the 95 %
//! interval is wider than a quarter span the weak subspace. Its SVD basis mixes unrelated parameters (their
//! singular values are near each other), so it is reduced to a sparse basis by elimination with pivoting:
//! each basis vector then names one group of parameters that trade off against each other.

use super::derived::DerivedEstimate;
use super::parameter::FitParameter;
use super::statistics::{DETERMINED_HALF_WIDTH, Determination, ParameterEstimate, Statistics};
use super::wording;
use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// 97.5 % quantile of the normal distribution.
const NORMAL_QUANTILE: f64 = 1.96;
/// Entries of a sparse direction below this fraction of its largest are not named.
const NAMED: f64 = 0.15;

/// What kind of ignorance a finding states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FindingKind {
    /// One parameter that changes nothing in the data, by a factor of ten or more.
    Invisible,
    /// One parameter that is known only roughly.
    Loose,
    /// Several parameters that the data know only in combination.
    TradeOff,
}

/// One thing that the data do not determine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Finding {
    /// Its kind.
    pub kind: FindingKind,
    /// Names of the parameters.
    pub parameters: Vec<String>,
    /// Direction in log parameters, largest component 1, in the order of `parameters`.
    pub direction: Vec<f64>,
    /// Largest half-width of the 95 % interval in ln(value) among those that are not determined by themselves.
    pub half_width: f64,
    /// Correlation, for a pair.
    pub correlation: Option<f64>,
    /// Change of the residuals by moving a factor of ten along the direction, rms in units of the noise.
    pub decade_change: f64,
    /// Name of the derived quantity, known well, that the group enters through.
    pub known_combination: Option<String>,
    /// The finding in words.
    pub text: String,
}

/// The analysis of one solution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Identifiability {
    /// Singular values of the Jacobian in units of the noise, descending: sensitivity per e-fold.
    pub singular_values: Vec<f64>,
    /// Directions that belong to them (unit vectors in the order of the parameters).
    pub directions: Vec<Vec<f64>>,
    /// What is not determined, worst first.
    pub findings: Vec<Finding>,
    /// Which branches the data do not tell apart, in words.
    pub unresolved: Vec<String>,
    /// What is determined, in words: derived quantities first, then single parameters.
    pub determined: Vec<String>,
}

impl Identifiability {
    /// Analyses the statistics of a fit; `derived` supplies names for the combinations that are known.
    pub fn new(statistics: &Statistics, derived: &[DerivedEstimate]) -> Self {
        let parameters: Vec<&FitParameter> = statistics.terms.iter().map(|e| &e.parameter).collect();
        let relative = |design: &DMatrix<f64>| per_relative_change(&statistics.terms, design);
        let (jacobian, white) = (relative(&statistics.design), relative(&statistics.white_design));
        let svd = jacobian.svd(false, true);
        let Some(v_t) = svd.v_t else { unreachable!("it was asked for") };
        let t = NORMAL_QUANTILE;
        let weak: Vec<usize> = (0..svd.singular_values.len())
            .filter(|&k| t > DETERMINED_HALF_WIDTH * svd.singular_values[k])
            .collect();
        let mut findings: Vec<Finding> = sparse_basis(&v_t.select_rows(&weak))
            .into_iter()
            .filter_map(|direction| describe(&direction, &white, &parameters, statistics, derived))
            // A direction may be weak although each of its parameters is known.
            .filter(|finding| finding.half_width > DETERMINED_HALF_WIDTH)
            .collect();
        findings.sort_by(|a, b| b.half_width.total_cmp(&a.half_width));
        let unnamed = |name: &str| !findings.iter().any(|f| f.parameters.iter().any(|p| p == name));
        Self {
            determined: wording::determined(statistics, derived, unnamed),
            unresolved: wording::unresolved(&statistics.resolution),
            singular_values: svd.singular_values.as_slice().to_vec(),
            directions: v_t.row_iter().map(|r| r.iter().copied().collect()).collect(),
            findings,
        }
    }

    /// Names of the parameters in any finding, without repetition.
    pub fn undetermined_names(&self) -> Vec<String> {
        let mut names: Vec<String> = vec![];
        for name in self.findings.iter().flat_map(|f| &f.parameters) {
            if !names.contains(name) {
                names.push(name.clone());
            }
        }
        names
    }
}

/// Derivatives per relative change of each term.
fn per_relative_change(terms: &[ParameterEstimate], design: &DMatrix<f64>) -> DMatrix<f64> {
    let mut design = design.clone();
    for (term, mut column) in terms.iter().zip(design.column_iter_mut()) {
        column /= term.parameter.relative_slope(term.parameter.to_internal(term.value));
    }
    design
}

/// Reduced row echelon form with complete pivoting: rows span the same space with as few entries as the
/// coupling between parameters allows. Each row's largest entry is scaled to 1.
fn sparse_basis(rows: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let mut b = rows.clone();
    let (w, n) = b.shape();
    let (mut used_rows, mut used_columns) = (vec![false; w], vec![false; n]);
    for _ in 0..w {
        let mut pivot = (0, 0, 0.0);
        for (i, j) in (0..w).flat_map(|i| (0..n).map(move |j| (i, j))) {
            if !used_rows[i] && !used_columns[j] && b[(i, j)].abs() > f64::abs(pivot.2) {
                pivot = (i, j, b[(i, j)]);
            }
        }
        let (i, j, value) = pivot;
        if value == 0.0 {
            break;
        }
        (used_rows[i], used_columns[j]) = (true, true);
        let row = b.row(i) / value;
        for other in (0..w).filter(|&o| o != i) {
            let factor = b[(other, j)];
            let reduced = b.row(other) - &row * factor;
            b.set_row(other, &reduced);
        }
        b.set_row(i, &row);
    }
    let scaled = |row: Vec<f64>| {
        let largest = row.iter().copied().fold(0.0, |a: f64, v| if v.abs() > a.abs() { v } else { a });
        row.into_iter().map(|v| v / largest).collect()
    };
    b.row_iter().map(|r| scaled(r.iter().copied().collect())).collect()
}

/// What is not known along a direction; nothing where each of its parameters is.
fn describe(
    direction: &[f64],
    jacobian: &DMatrix<f64>,
    parameters: &[&FitParameter],
    statistics: &Statistics,
    derived: &[DerivedEstimate],
) -> Option<Finding> {
    let group: Vec<usize> = (0..direction.len()).filter(|&j| direction[j].abs() > NAMED).collect();
    let is_known = |j: &usize| statistics.terms[*j].determination == Determination::Determined;
    let open: Vec<usize> = group.iter().copied().filter(|j| !is_known(j)).collect();
    if open.is_empty() {
        return None;
    }
    let names: Vec<String> = group.iter().map(|&j| parameters[j].name.clone()).collect();
    let half_width = open.iter().map(|&j| statistics.terms[j].half_width).fold(0.0, f64::max);
    let column: nalgebra::DVector<f64> = group.iter().map(|&j| jacobian.column(j) * direction[j]).sum();
    let decade = std::f64::consts::LN_10 * column.norm();
    let kind = match group.len() {
        1 if decade < NORMAL_QUANTILE => FindingKind::Invisible,
        1 => FindingKind::Loose,
        _ => FindingKind::TradeOff,
    };
    let known = known_combination(&names, derived);
    let correlation = match group[..] {
        [i, j] => Some(statistics.term_correlation[(i, j)]),
        _ => None,
    };
    let mut finding = Finding {
        kind,
        parameters: names,
        direction: group.iter().map(|&j| direction[j]).collect(),
        half_width,
        correlation,
        decade_change: decade / (jacobian.nrows() as f64).sqrt(),
        known_combination: known.map(|d| d.name.clone()),
        text: String::new(),
    };
    let symbols = |of: &[usize]| -> Vec<&str> {
        of.iter().map(|&j| statistics.terms[j].parameter.symbol.as_str()).collect()
    };
    finding.text = wording::finding(&finding, &symbols(&group), &symbols(&open), known);
    Some(finding)
}

/// The best known derived quantity that depends on just these parameters, if it is known well.
fn known_combination<'a>(names: &[String], derived: &'a [DerivedEstimate]) -> Option<&'a DerivedEstimate> {
    derived
        .iter()
        .filter(|d| names.len() > 1 && d.depends_on.len() > 1)
        .filter(|d| d.depends_on.iter().all(|n| names.contains(n)))
        .filter(|d| d.determination == Determination::Determined)
        .min_by(|a, b| a.half_width.total_cmp(&b.half_width))
}

#[cfg(test)]
#[path = "identifiability_tests.rs"]
mod tests;
