//! The report as one self-contained HTML page: styles and figures inside, nothing from outside.

use super::figures;
use super::fit_report::*;
use super::glossary::{glossary, meaning};
use super::labels::labelled;
use super::plot::{Shapes, exponent, heat_map, interval_bar, pretty};
use super::posterior::section;
use crate::assumption::Assumption;
use crate::inference::statistics::{BoundSide, Determination};
use crate::inference::wording::{significant, spread};
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// The page.
pub fn page(report: &FitReport) -> String {
    let body = html! {
        (heading(report))
        (verdict(&report.verdict))
        (parameters(report))
        (derived(report))
        (nuisances(report))
        (profiles(report))
        @if let Some(posterior) = &report.posterior { (section(posterior)) }
        (gains(report))
        (curves(report))
        (characteristic_numbers(report))
        (parts(report))
        (residuals(report))
        (correlation(report))
        (course(report))
        (assumed(&report.given.assumptions))
        (glossary())
        (origin(report))
    };
    document(&report.given.title, "", &body)
}

/// A figure over the whole page, and its narrow shape for narrow screens.
pub fn shapes(figure: &Shapes) -> Markup {
    html! {
        figure.wide { (PreEscaped(&figure.wide)) }
        figure.narrow { (PreEscaped(&figure.narrow)) }
    }
}

/// A self-contained page with the common style and `more` of its own.
pub fn document(title: &str, more: &str, body: &Markup) -> String {
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) (PreEscaped(more)) }
            }
            body {
                (PreEscaped(labelled(&body.0)))
                script { (PreEscaped(include_str!("script.js"))) }
            }
        }
    };
    markup.into_string()
}

fn heading(report: &FitReport) -> Markup {
    let names = |role: Role| {
        let named =
            report.measurements.iter().filter(|m| m.curve.role == role).map(|m| m.curve.name.as_str());
        named.collect::<Vec<_>>().join(", ")
    };
    let (fit, validation) = (names(Role::Fit), names(Role::Validation));
    html! {
        h1 { (pretty(&report.given.title)) }
        p.meta {
            "Fitted to " (fit)
            @if !validation.is_empty() { ", validated on " (validation) }
            " · " (report.given.model) " · " (report.given.created)
        }
        @if report.measurements.iter().any(|m| m.synthetic) {
            p.synthetic { "Synthetic data: computed, not measured" }
        }
    }
}

fn verdict(verdict: &Verdict) -> Markup {
    let list = |items: &[String]| html! { ul { @for item in items { li { (pretty(item)) } } } };
    html! {
        div.verdict {
            p.headline { (pretty(&verdict.headline)) }
            div.columns {
                @if !verdict.determined.is_empty() {
                    div { h3 { "What the data determine" } (list(&verdict.determined)) }
                }
                @if !verdict.undetermined.is_empty() {
                    div { h3 { "What they do not" } (list(&verdict.undetermined)) }
                }
            }
            @if !verdict.warnings.is_empty() {
                div.warnings { h3 { "Mind" } (list(&verdict.warnings)) }
            }
        }
    }
}

/// Everything that was not fitted, with its unit, and whether it was given.
pub fn assumed(assumptions: &[Assumption]) -> Markup {
    html! {
        @if !assumptions.is_empty() {
            h2 { "Given and assumed" }
            p.meta { "Force in mN, depth in mm, time in s; both positive into the sample." }
            @for (given, what) in [(true, "given"), (false, "assumed: the defaults")] {
                @let rows: Vec<&Assumption> = assumptions.iter().filter(|a| a.given == given).collect();
                @if !rows.is_empty() {
                    details open[given] {
                        summary { (what) }
                        table { tbody { @for a in rows { tr {
                            td.name { (a.name) } td.number { (a.value) } td { (pretty(&a.unit)) } td { (a.meaning) }
                        } } } }
                    }
                }
            }
        }
    }
}

fn known(determination: Determination, half_width: f64) -> Markup {
    let (class, text) = match determination {
        Determination::Determined => ("determined", format!("± {}", spread(half_width))),
        Determination::Loose => ("loose", format!("± {}", spread(half_width))),
        Determination::Undetermined => ("undetermined", "not determined".to_owned()),
        Determination::Unresolved => ("loose", "not told apart".to_owned()),
    };
    html! { span class=(class) { (text.replace("± a factor", "a factor")) } }
}

fn parameters(report: &FitReport) -> Markup {
    let end = |v: f64, open: bool| if open { "open".to_owned() } else { set(v, 3) };
    html! {
        h2 { "Parameters" }
        table {
            thead { tr {
                th { "" } th.number { "value" } th { "unit" } th { "95 % interval" } th { "within its bounds" }
                th { "known to" } th { "name" }
            } }
            tbody {
                @for p in in_order_of_time(report) { tr {
                    td.symbol { (pretty(&p.symbol)) }
                    td.number { (set(p.value, 4)) }
                    td { (pretty(&p.unit)) }
                    td { (end(p.lower, p.open[0])) " … " (end(p.upper, p.open[1])) }
                    td { (PreEscaped(interval_bar(p.value, (p.lower, p.upper), (p.lower_bound, p.upper_bound),
                        p.determination == Determination::Determined))) }
                    td {
                        (known(p.determination, p.half_width))
                        @match p.at_bound {
                            Some(BoundSide::Lower) => " · at lower bound",
                            Some(BoundSide::Upper) => " · at upper bound",
                            None => "",
                        }
                    }
                    td.name { (p.name) span.meaning { (meaning(&p.name)) } }
                } }
                @for f in &report.given.fixed { tr {
                    td.symbol { (pretty(&f.symbol)) }
                    td.number { (set(f.value, 4)) }
                    td { (pretty(&f.unit)) }
                    td.meta colspan="3" { (f.how) }
                    td.name { (f.name) span.meaning { (meaning(&f.name)) } }
                } }
            }
        }
        p.caption {
            "Intervals are computed in log parameters (the sign stays), with the t distribution"
            @if !report.fit.common_errors.is_empty() {
                ", and include errors common to all points: " (report.fit.common_errors.join(", "))
            }
            "; bounds count as knowledge of the range"
            ". The bar shows the interval within the bounds on a logarithmic scale of the magnitude. “Open”: the \
             interval reaches the bound, so the data set no limit on that side."
        }
    }
}

/// Parameters with those of the fastest branch first, whatever its number is.
fn in_order_of_time(report: &FitReport) -> Vec<&ParameterRow> {
    let branch = |p: &ParameterRow| -> Option<usize> {
        p.name.strip_prefix("material.branch[")?.split_once(']')?.0.parse().ok()
    };
    let time = |k: usize| {
        let symbol = format!("tau_{k}");
        report.derived.iter().find(|d| d.symbol == symbol).map_or(f64::INFINITY, |d| d.value)
    };
    let mut rows: Vec<&ParameterRow> = report.parameters.iter().collect();
    let places: Vec<usize> = (0..rows.len()).filter(|&i| branch(rows[i]).is_some()).collect();
    let mut branches: Vec<&ParameterRow> = places.iter().map(|&i| rows[i]).collect();
    branches.sort_by(|a, b| {
        let key = |p: &ParameterRow| branch(p).map_or(f64::INFINITY, time);
        key(a).total_cmp(&key(b))
    });
    places.into_iter().zip(branches).for_each(|(i, row)| rows[i] = row);
    rows
}

fn derived(report: &FitReport) -> Markup {
    html! {
        @if !report.derived.is_empty() {
            h2 { "Combinations of parameters" }
            table {
                thead { tr {
                    th { "" } th { "formula" } th.number { "value" } th { "unit" } th { "95 % interval" }
                    th { "known to" } th { "name" }
                } }
                tbody { @for d in &report.derived { tr {
                    td.symbol { (pretty(&d.symbol)) }
                    td { (pretty(&d.formula)) }
                    td.number { (set(d.value, 3)) }
                    td { (pretty(&d.unit)) }
                    td {
                        @if d.determination == Determination::Undetermined { "—" }
                        @else { (set(d.lower, 3)) " … " (set(d.upper, 3)) }
                    }
                    td { (known(d.determination, d.half_width)) }
                    td.name { (d.name) }
                } } }
            }
            p.caption { "Intervals by the delta method from the full covariance of the parameters." }
        }
    }
}

fn nuisances(report: &FitReport) -> Markup {
    html! {
        @if !report.given.nuisances.is_empty() {
            h2 { "Zeros that were fitted" }
            table {
                thead { tr { th { "" } th.number { "higher by" } th { "unit" } th { "95 % interval" } } }
                tbody { @for n in &report.given.nuisances { tr {
                    td { (n.name) }
                    td.number { (set(n.value, 3)) }
                    td { (n.unit) }
                    td { (set(n.lower, 3)) " … " (set(n.upper, 3)) }
                } } }
            }
            p.caption {
                "Unknowns of each test, found with the parameters, whose intervals include what is not known of them: how much higher \
                 the surface lies, and the load cell reads without load, than was read from the file. The curves below are corrected."
            }
        }
    }
}

fn profiles(report: &FitReport) -> Markup {
    html! {
        @if !report.profiles.is_empty() {
            h2 { "Profiles of the likelihood" }
            div.pair { @for figure in figures::profiles(report) { (PreEscaped(figure)) } }
            p.caption {
                "Rise of χ² when a value is given and everything else is fitted; the interval ends where it passes the line. Made \
                 where asked for, and where the linearised interval is open or curved."
            }
        }
    }
}

fn gains(report: &FitReport) -> Markup {
    html! {
        @if !report.gains.is_empty() {
            h2 { "What further cycles add" }
            table {
                thead { tr {
                    th { "" } th.number { "from the first loading and hold" } th.number { "from everything" }
                    th.number { "better by" }
                } }
                tbody { @for g in &report.gains { tr {
                    td.symbol { (pretty(&g.symbol)) }
                    td.number { (known(Determination::of(g.first_hold), g.first_hold)) }
                    td.number { (known(Determination::of(g.all), g.all)) }
                    td.number { (set(g.first_hold / g.all, 2)) " times" }
                } } }
            }
            p.caption { "Half-widths of the 95 % intervals at the same solution, from the rows of those points alone." }
        }
    }
}

fn curves(report: &FitReport) -> Markup {
    html! {
        h2 { "Measured and model" }
        (shapes(&figures::absolute_force(report)))
        div.pair {
            (PreEscaped(figures::loading_peak(report)))
            (PreEscaped(figures::normalised_relaxation(report)))
        }
        p.caption {
            "Points: measured"
            @if report.measurements.iter().any(|m| !m.curve.specimens.is_empty()) { "; thin lines: every specimen" }
            @if report.measurements.iter().any(|m| m.curve.spread_mn.is_some()) { "; band: ± one standard deviation between specimens" }
            "; line: model. "
            @for m in &report.measurements {
                (m.curve.name) @if m.curve.role == Role::Fit { " was fitted" } @else { " is predicted" } ". "
            }
        }
    }
}

fn characteristic_numbers(report: &FitReport) -> Markup {
    let pair = |p: Pair, digits| format!("{} / {}", set(p.measured, digits), set(p.model, digits));
    html! {
        table {
            thead { tr {
                th { "measured / model" } th.number { "peak force (mN)" } th.number { "force at the end (mN)" }
                th.number { "relaxation (%)" } th.number { "χ²" } th.number { "χ² per point" }
                th.number { "rms difference (mN)" }
            } }
            tbody { @for m in &report.measurements { tr {
                td { b { (m.curve.name) } @if m.curve.role == Role::Fit { " (fit)" } @else { " (validation)" } }
                td.number { (pair(m.peak_mn, 4)) }
                td.number { (pair(m.end_mn, 3)) }
                td.number { (pair(m.relaxation_percent, 3)) }
                td.number { (set(m.curve.chi_square, 4)) }
                td.number { (set(m.chi_square_per_point, 3)) }
                td.number { (set(m.rms_mn, 2)) }
            } } }
        }
        @for ratio in &report.ratios {
            p { (ratio.name) ": measured " b { (set(ratio.value.measured, 4)) } ", model " b { (set(ratio.value.model, 4)) } }
        }
    }
}

fn parts(report: &FitReport) -> Markup {
    let parts = figures::solid_and_fluid(report);
    html! {
        @if !parts.is_empty() {
            h2 { "Solid and fluid parts of the force" }
            div.pair { @for figure in &parts { (PreEscaped(figure)) } }
            p.caption {
                "Grey points: measured. The fluid part is the pore pressure over the contact area, the solid part the \
                 rest of the model's force."
            }
        }
    }
}

fn residuals(report: &FitReport) -> Markup {
    html! {
        h2 { "Residuals" }
        div.pair { @for figure in figures::residuals(report) { (PreEscaped(figure)) } }
        @if report.measurements.iter().any(|m| !m.curve.sigma_mn.is_empty()) {
            p.caption { "In units of each point's standard deviation; the grey band holds 95 % of white noise." }
        }
    }
}

fn correlation(report: &FitReport) -> Markup {
    let c = &report.correlation;
    html! {
        h2 { "Correlation of the parameters" }
        figure { (PreEscaped(heat_map(&c.symbols, &c.matrix))) }
        p.caption {
            "Of the logarithms of the magnitudes. −1: a rise of one is made up for by a fall of the other, so only \
             their product is known; +1: only their ratio."
        }
    }
}

fn course(report: &FitReport) -> Markup {
    let (fit, runs) = (&report.fit, &report.given.runs);
    html! {
        h2 { "Course of the fit" }
        p { b { (pretty(&fit.stop_text)) } }
        div.facts {
            (fact(&fit.iterations.to_string(), "iterations"))
            (fact(&set(fit.chi_square, 4), &format!("χ² of {} points", fit.points)))
            (fact(&set(fit.reduced_chi_square, 3), "χ² per degree of freedom"))
            (fact(&fit.degrees_of_freedom.to_string(), "degrees of freedom"))
            (fact(&runs.runs.to_string(), "simulations"))
            (fact(&runs.cache_hits.to_string(), "taken from the cache"))
            (fact(&runs.failed.to_string(), "failed"))
            (fact(&format!("{:.2}", runs.mean_in_flight), "at a time during a Jacobian"))
        }
        @if !runs.failures.is_empty() {
            details { summary { "Why simulations failed" } ul { @for f in &runs.failures { li.mono { (f) } } } }
        }
        div.pair {
            @if let Some(figure) = figures::convergence(report) { (PreEscaped(figure)) }
            @if let Some(figure) = figures::waterfall(report) { (PreEscaped(figure)) }
        }
    }
}

fn fact(value: &str, what: &str) -> Markup {
    html! { div { b { (value) } span { (what) } } }
}

fn origin(report: &FitReport) -> Markup {
    html! {
        h2 { "Origin" }
        table { tbody {
            @for m in &report.measurements { tr {
                td { b { (m.curve.name) } }
                td { span.mono { (m.curve.file) } }
                td { (m.curve.provenance.as_deref().unwrap_or("the file does not say where its data come from")) }
            } }
        } }
        p.mono { (report.given.command) }
        @if !report.given.settings.is_empty() {
            details { summary { "Settings" }
                table { tbody { @for s in &report.given.settings { tr { td.name { (s.name) } td { (pretty(&s.value)) } } } } }
            }
        }
        p.caption { "Schema " (report.schema) ". Wall time " (set(runs_wall(report), 3)) " s." }
    }
}

fn runs_wall(report: &FitReport) -> f64 {
    report.given.runs.wall_time_s
}

/// A number for print: real minus sign, powers of ten raised.
fn set(value: f64, digits: usize) -> String {
    let text = significant(value, digits);
    match text.split_once('e') {
        Some((mantissa, power)) => format!("{mantissa} · 10{}", exponent(power)),
        None => text,
    }
    .replace('-', "−")
}
