//! The result in words: the first thing that a reader sees.

use super::fit_report::*;
use crate::inference::statistics::Determination;
use crate::inference::wording::{list, significant};

/// The verdict of a report whose other fields are complete.
pub(super) fn verdict(report: &FitReport, determined: Vec<String>, unresolved: Vec<String>) -> Verdict {
    Verdict {
        headline: headline(report),
        determined,
        undetermined: unresolved.into_iter().chain(report.findings.iter().map(|f| f.text.clone())).collect(),
        warnings: warnings(report),
    }
}

fn headline(report: &FitReport) -> String {
    let free = report.parameters.len();
    let known: Vec<&str> = report
        .parameters
        .iter()
        .filter(|p| p.determination == Determination::Determined && p.at_bound.is_none())
        .filter(|p| !report.findings.iter().any(|f| f.parameters.contains(&p.name)))
        .map(|p| p.symbol.as_str())
        .collect();
    let combinations: Vec<&str> = report
        .derived
        .iter()
        .filter(|d| d.determination == Determination::Determined)
        .map(|d| d.symbol.as_str())
        .collect();
    let parameters = match (known.len(), free) {
        (k, n) if k == n => format!("The data determine all {n} free parameters"),
        (0, n) => format!("The data determine none of the {n} free parameters by itself"),
        (1, n) => format!("The data determine 1 of the {n} free parameters by itself ({})", known[0]),
        (k, n) => {
            format!("The data determine {k} of the {n} free parameters by themselves ({})", list(&known))
        }
    };
    let combinations = match combinations[..] {
        [] => String::new(),
        _ => {
            let but = if known.is_empty() { "but" } else { "and" };
            let s = if combinations.len() == 1 { "" } else { "s" };
            format!(", {but} the combination{s} {}", list(&combinations))
        }
    };
    // What is not at a minimum determines nothing yet: nobody should read on before knowing.
    let provisional = if report.fit.stop.converged() { "" } else { "The fit did not converge. " };
    format!("{provisional}{parameters}{combinations}. {}", agreement(report))
}

/// A chi^2 per degree of freedom below this is no luck: the noise is not what the data say it is.
const TOO_GOOD: f64 = 0.25;

/// Whether the model meets the data, where their noise is known.
fn agreement(report: &FitReport) -> String {
    let fit = &report.fit;
    if !fit.noise_known {
        return format!("The fit leaves {} mN rms.", significant(fitted_rms(report), 2));
    }
    let reduced = significant(fit.reduced_chi_square, 3);
    // Three standard deviations of a reduced chi^2: noise alone passes them in one of a thousand fits.
    let tolerance = 3.0 * (2.0 / fit.degrees_of_freedom as f64).sqrt();
    if fit.reduced_chi_square > 1.0 + tolerance {
        format!(
            "The model misses the data by more than their noise: chi^2 per degree of freedom is {reduced}."
        )
    } else if fit.reduced_chi_square < TOO_GOOD && fit.reduced_chi_square < 1.0 - tolerance {
        format!(
            "chi^2 per degree of freedom is {reduced}, far below one: the data scatter far less than the noise that \
             they are given (a spread of specimens, smoothed or computed curves?), so the intervals are too wide."
        )
    } else {
        format!("The model meets the data to their noise: chi^2 per degree of freedom is {reduced}.")
    }
}

fn fitted_rms(report: &FitReport) -> f64 {
    let fitted = report.measurements.iter().filter(|m| m.curve.role == Role::Fit);
    let (sum, count) = fitted.fold((0.0, 0.0), |(s, c), m| {
        let n = m.curve.time_s.len() as f64;
        (s + m.rms_mn * m.rms_mn * n, c + n)
    });
    f64::sqrt(sum / f64::max(count, 1.0))
}

/// A part of chi^2 that a reader should know of.
const NOTABLE: f64 = 0.2;

fn warnings(report: &FitReport) -> Vec<String> {
    let fit = &report.fit;
    let mut warnings = vec![];
    let synthetic: Vec<&str> =
        report.measurements.iter().filter(|m| m.synthetic).map(|m| m.curve.name.as_str()).collect();
    if !synthetic.is_empty() {
        warnings.push(format!("{}: these data are synthetic, not measured.", list(&synthetic)));
    }
    if !fit.stop.converged() {
        warnings.push(format!("The fit is {}; values and intervals are provisional.", fit.stop_text));
    }
    let at_bound: Vec<&str> =
        report.parameters.iter().filter(|p| p.at_bound.is_some()).map(|p| p.symbol.as_str()).collect();
    if !at_bound.is_empty() {
        warnings.push(format!(
            "{} at a bound: the bound, not the data, sets the value.",
            match at_bound[..] {
                [one] => format!("{one} sits"),
                _ => format!("{} sit", list(&at_bound)),
            }
        ));
    }
    if fit.noise_known && fit.shared_chi_square > NOTABLE * fit.chi_square {
        warnings.push(format!(
            "Of chi^2, {} of {} is the size of errors that many points share: they are larger than the specimens and the \
             simulation make likely.",
            significant(fit.shared_chi_square, 3),
            significant(fit.chi_square, 3)
        ));
    }
    if fit.correlation_time > 1.5 {
        warnings.push(format!(
            "Neighbouring residuals are correlated over {} points; the intervals are widened by {}.",
            significant(fit.correlation_time, 2),
            significant(fit.correlation_time.sqrt(), 2)
        ));
    }
    if fit.noise_known && fit.reduced_chi_square > 1.5 {
        warnings.push(format!(
            "The intervals are widened by {} because the model misses the data; they do not cover what is \
             missing in the model.",
            significant(fit.reduced_chi_square.sqrt(), 2)
        ));
    }
    warnings.extend(competing_minima(report));
    if report.given.runs.failed > 0 {
        warnings
            .push(format!("{} of {} simulations failed.", report.given.runs.failed, report.given.runs.runs));
    }
    warnings
}

/// Other starts that ended elsewhere at a chi^2 that the data cannot tell from the best.
fn competing_minima(report: &FitReport) -> Option<String> {
    let ended: Vec<f64> = report.given.starts.iter().filter_map(|s| s.chi_square).collect();
    let best = ended.iter().copied().fold(f64::INFINITY, f64::min);
    if ended.len() < 2 {
        return None;
    }
    let scale = fit_variance(report);
    let worse = ended.iter().filter(|&&c| c > best + 4.0 * scale).count();
    (worse > 0).then(|| {
        format!("{worse} of {} refined starts ended at a worse minimum: the start matters.", ended.len())
    })
}

/// What one unit of chi^2 is worth: 1 for known noise.
fn fit_variance(report: &FitReport) -> f64 {
    if report.fit.noise_known {
        report.fit.reduced_chi_square.max(1.0)
    } else {
        report.fit.reduced_chi_square
    }
}
