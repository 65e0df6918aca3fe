//! From a solution and its curves to the report: everything that can be computed is computed here.

use super::first_hold::gains;
use super::fit_report::*;
use super::verdict;
use crate::fit::{FitError, Solution};
use crate::inference::derived::{self, DerivedEstimate, DerivedQuantity, Values};
use crate::inference::statistics::{Determination, Interval};
use crate::inference::{Fit, Identifiability, ParameterEstimate, Statistics, Unknowns};
use crate::noise::Covariance;
use nalgebra::DMatrix;

/// What a report is made of.
pub struct Assembly<'a> {
    /// What stands in it as it is.
    pub given: Given,
    /// What was fitted.
    pub unknowns: &'a Unknowns,
    /// The best fit.
    pub fit: &'a Fit,
    /// What its values are worth.
    pub statistics: Statistics,
    /// Profiles of the likelihood.
    pub profiles: Vec<ProfileRow>,
    /// Points that count less in a robust fit.
    pub far_points: Option<usize>,
    /// Numbers of points in a row, one per measurement that was fitted.
    pub stretches: &'a [usize],
    /// Quantities to compute from the parameters.
    pub derived: &'a [DerivedQuantity],
    /// Adds parameters (SI) that nobody set.
    pub complete: &'a dyn Fn(&mut Values),
    /// Rows of the solution that belong to the first loading and hold of a test.
    pub first_holds: Vec<usize>,
    /// Measurements, those fitted first.
    pub curves: Vec<MeasuredCurve>,
}

impl Assembly<'_> {
    /// Computes statistics, identifiability, derived quantities and characteristic numbers.
    ///
    /// # Errors
    /// When sizes do not fit or there are not more residuals than parameters.
    pub fn build(self) -> Result<FitReport, FitError> {
        for curve in &self.curves {
            curve.check()?;
        }
        let (fit, unknowns) = (self.fit, self.unknowns);
        let solution = &fit.solution;
        let mut statistics = self.statistics;
        let mut derived = derived::estimate(self.derived, unknowns, &solution.x, &statistics, self.complete);
        let gains = gains(unknowns, self.derived, fit, self.stretches, &self.first_holds, self.complete);
        take(&self.profiles, &mut statistics, &mut derived);
        let analysis = Identifiability::new(&statistics, &derived);
        let measurements: Vec<_> = self.curves.into_iter().map(MeasuredCurve::evaluate).collect();
        let mut report = FitReport {
            schema: SCHEMA.to_owned(),
            given: self.given,
            verdict: Verdict::default(),
            parameters: statistics.estimates.iter().map(|e| row(e, &self.profiles)).collect(),
            derived: derived
                .iter()
                .map(|d| DerivedRow {
                    name: d.name.clone(),
                    symbol: d.symbol.clone(),
                    formula: d.formula.clone(),
                    unit: d.unit.name.clone(),
                    value: d.unit.from_si(d.value),
                    lower: d.unit.from_si(d.interval.lower),
                    upper: d.unit.from_si(d.interval.upper),
                    half_width: d.half_width,
                    determination: d.determination,
                })
                .collect(),
            gains,
            profiles: self.profiles,
            posterior: None,
            correlation: Correlation {
                symbols: unknowns.free().iter().map(|p| p.symbol.clone()).collect(),
                matrix: rows(&statistics.correlation),
            },
            findings: analysis.findings.clone(),
            singular_values: analysis.singular_values.clone(),
            ratios: ratios(&measurements),
            measurements,
            fit: summary(solution, &statistics, &fit.covariance),
            iterations: solution
                .iterations
                .iter()
                .map(|r| IterationRow {
                    iteration: r.iteration,
                    chi_square: r.chi_square,
                    step_norm: r.step_norm,
                    optimality: r.optimality,
                    values: values_at(unknowns, &r.x),
                })
                .collect(),
        };
        report.verdict = verdict::verdict(&report, analysis.determined, analysis.unresolved);
        if let Some(far) = self.far_points {
            let text = format!(
                "Robust fit: {far} of {} points lie far from the rest and count less.",
                report.fit.points
            );
            report.verdict.warnings.push(text);
        }
        Ok(report)
    }
}

/// How well a value is known by another interval; a better one tells no branches apart.
fn again(before: Determination, half_width: f64) -> Determination {
    Determination::of(half_width).unresolved_if(before == Determination::Unresolved)
}

/// Puts the intervals of the profiles in the place of the linearised ones.
fn take(profiles: &[ProfileRow], statistics: &mut Statistics, derived: &mut [DerivedEstimate]) {
    for profile in profiles {
        let half_width = match profile.open {
            [false, false] => Some(0.5 * (profile.upper / profile.lower).ln().abs()),
            _ => None,
        };
        let interval = |si: f64| Interval { lower: profile.lower * si, upper: profile.upper * si };
        let estimates = statistics.terms.iter_mut().chain(&mut statistics.estimates);
        for e in estimates.filter(|e| e.parameter.name == profile.name) {
            (e.interval, e.open) = (interval(e.parameter.unit.si), profile.open);
            if let Some(half_width) = half_width {
                (e.half_width, e.determination) = (half_width, again(e.determination, half_width));
            }
        }
        if let Some(half_width) = half_width
            && let Some(d) = derived.iter_mut().find(|d| d.name == profile.name)
        {
            d.interval = interval(d.unit.si);
            (d.half_width, d.determination) = (half_width, again(d.determination, half_width));
        }
    }
}

impl MeasuredCurve {
    fn check(&self) -> Result<(), FitError> {
        let n = self.time_s.len();
        let optional = |v: &Option<Vec<f64>>| v.as_ref().map_or(n, Vec::len);
        let sigma = if self.sigma_mn.is_empty() { n } else { self.sigma_mn.len() };
        for (what, found) in [
            ("displacement", self.displacement_mm.len()),
            ("measured force", self.measured_mn.len()),
            ("spread", optional(&self.spread_mn)),
            ("sigma", sigma),
            ("model force", self.model_mn.len()),
            ("solid force", optional(&self.model_solid_mn)),
            ("fluid force", optional(&self.model_fluid_mn)),
        ] {
            if found != n {
                return Err(FitError::Dimension { what, expected: n, found });
            }
        }
        if n == 0 {
            return Err(FitError::Dimension { what: "points of a measurement", expected: 1, found: 0 });
        }
        Ok(())
    }

    fn evaluate(self) -> MeasurementResult {
        let n = self.time_s.len() as f64;
        let difference = || self.model_mn.iter().zip(&self.measured_mn).map(|(a, b)| a - b);
        let square = difference().map(|d| d * d).sum::<f64>();
        let peak = |f: &[f64]| f.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let end = |f: &[f64]| f.last().copied().unwrap_or(f64::NAN);
        // No peak, no relaxation; a NaN could not be read back from JSON.
        let relaxation = |f: &[f64]| if peak(f) > 0.0 { 100.0 * (1.0 - end(f) / peak(f)) } else { 0.0 };
        let pair =
            |g: &dyn Fn(&[f64]) -> f64| Pair { measured: g(&self.measured_mn), model: g(&self.model_mn) };
        let synthetic =
            self.provenance.as_ref().is_some_and(|p| p.to_ascii_lowercase().contains("synthetic"));
        MeasurementResult {
            chi_square_per_point: self.chi_square / n,
            rms_mn: (square / n).sqrt(),
            peak_mn: pair(&peak),
            end_mn: pair(&end),
            relaxation_percent: pair(&relaxation),
            synthetic,
            curve: self,
        }
    }
}

/// Values of the fitted parameters at a point of the optimiser, in the units of people.
fn values_at(unknowns: &Unknowns, x: &[f64]) -> Vec<f64> {
    let values = unknowns.settings(x);
    unknowns.free().iter().map(|p| p.unit.from_si(values[&p.name])).collect()
}

fn row(e: &ParameterEstimate, profiles: &[ProfileRow]) -> ParameterRow {
    let p = &e.parameter;
    let shown = |v: f64| p.unit.from_si(v);
    ParameterRow {
        name: p.name.clone(),
        symbol: p.symbol.clone(),
        unit: p.unit.name.clone(),
        value: shown(e.value),
        lower: shown(e.interval.lower),
        upper: shown(e.interval.upper),
        open: e.open,
        half_width: e.half_width,
        determination: e.determination,
        at_bound: e.at_bound,
        start: shown(p.start),
        lower_bound: shown(p.lower),
        upper_bound: shown(p.upper),
        common_share: e.common_share,
        profiled: profiles.iter().any(|profile| profile.name == p.name),
    }
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|r| r.iter().copied().collect()).collect()
}

/// Peak ratios of each pair of measurements, the higher peak above.
fn ratios(measurements: &[MeasurementResult]) -> Vec<Ratio> {
    let mut ratios = vec![];
    for (i, a) in measurements.iter().enumerate() {
        for b in &measurements[i + 1..] {
            if a.peak_mn.measured <= 0.0
                || b.peak_mn.measured <= 0.0
                || b.peak_mn.model <= 0.0
                || a.peak_mn.model <= 0.0
            {
                continue;
            }
            let (a, b) = if a.peak_mn.measured >= b.peak_mn.measured { (a, b) } else { (b, a) };
            ratios.push(Ratio {
                name: format!("peak {} / peak {}", a.curve.name, b.curve.name),
                value: Pair {
                    measured: a.peak_mn.measured / b.peak_mn.measured,
                    model: a.peak_mn.model / b.peak_mn.model,
                },
            });
        }
    }
    ratios
}

fn summary(solution: &Solution, statistics: &Statistics, covariance: &Covariance) -> FitSummary {
    FitSummary {
        stop: solution.stop,
        stop_text: solution.stop.to_string(),
        iterations: solution.iteration_count(),
        evaluations: solution.evaluations,
        chi_square: statistics.chi_square,
        shared_chi_square: statistics.shared_chi_square,
        points: statistics.points,
        degrees_of_freedom: statistics.degrees_of_freedom,
        reduced_chi_square: statistics.reduced_chi_square,
        noise_known: statistics.noise_known,
        correlation_time: statistics.correlation_time,
        common_errors: kinds(covariance),
    }
}

/// Kinds of errors that many points share: names without what distinguishes one of a kind from the next.
fn kinds(covariance: &Covariance) -> Vec<String> {
    let mut kinds: Vec<String> = Vec::new();
    for common in covariance.common().iter().chain(covariance.absorbed()) {
        let kind = common.name.split(", ").next().unwrap_or(&common.name);
        if !kinds.iter().any(|k| k == kind) {
            kinds.push(kind.to_owned());
        }
    }
    kinds
}
