//! The page of a study.

use super::Plan;
use super::digest::Curve;
use super::gather::{Found, Row};
use super::report::{GroupMean, PopulationReport, ValueReport};
use crate::inference::wording::significant;
use crate::report::document;
use crate::report::plot::{Axis, Chart, Mark, palette, pretty};
use maud::{Markup, PreEscaped, html};
use std::collections::BTreeSet;

/// Specimens of a group in a figure; of more, some evenly chosen ones.
const MOST_POINTS: usize = 200;
/// Small multiples beside each other.
const STYLE: &str =
    ".multiples{display:grid;grid-template-columns:repeat(auto-fill,minmax(240px,1fr));gap:8px}";

/// A value in the population, in one line.
pub(super) fn in_words(v: &ValueReport) -> String {
    let unit = if v.unit == "1" { "" } else { v.unit.as_str() };
    let group = |g: &GroupMean| {
        let m = g.mean?;
        let name = if g.group.is_empty() { String::new() } else { format!("{} ", g.group) };
        let [value, lower, upper] = [m.value, m.lower, m.upper].map(|x| significant(x, 3));
        Some(format!("{name}{value} [{lower}, {upper}] {unit}").trim_end().to_owned())
    };
    let mut parts: Vec<String> = v.groups.iter().filter_map(group).collect();
    parts.push(format!("spread {}", spread(v)));
    for d in &v.differences {
        let [value, lower, upper] = [d.ratio.value, d.ratio.lower, d.ratio.upper].map(|x| significant(x, 3));
        parts.push(format!("{} / {}: {value} [{lower}, {upper}]", d.of, d.over));
    }
    format!("{}: {}", v.symbol, parts.join("; "))
}

/// The spread between specimens as a part of the value.
fn spread(v: &ValueReport) -> String {
    let [value, lower, upper] =
        [v.spread.value, v.spread.lower, v.spread.upper].map(|s| significant(100.0 * s.exp_m1(), 2));
    format!("{value} % [{lower}, {upper}]")
}

/// The page.
pub(super) fn page(plan: &Plan, rows: &[Row], report: &PopulationReport) -> String {
    let title = format!("Study of {}", plan.header.table.file_name().unwrap_or_default().to_string_lossy());
    let body = html! {
        h1 { (title) }
        p.meta { (report.done) " of " (report.units) " units have results · " (plan.header.question.command()) }
        @if !report.warnings.is_empty() {
            div.warnings { h3 { "Mind" } ul { @for w in &report.warnings { li { (w) } } } }
        }
        (population(report))
        (answers(report))
        (by_group(rows, report))
        (outliers(report))
        (failures(rows))
        (curves(rows))
    };
    document(&title, STYLE, &body)
}

fn population(report: &PopulationReport) -> Markup {
    html! { @if !report.values.is_empty() {
        h2 { "Population" }
        table {
            thead { tr {
                th { "" } th { "unit" } th { "group" } th.number { "specimens" } th.number { "mean" } th { "95 % interval" }
                th { "spread between specimens" } th { "known within one" }
                th { "specimens for " (significant(report.difference_percent, 3)) " %" }
            } }
            tbody { @for v in &report.values { @for (k, g) in v.groups.iter().enumerate() { tr {
                td.symbol { (pretty(&v.symbol)) }
                td { (pretty(&v.unit)) }
                td { (g.group) }
                td.number { (g.specimens) }
                @if let Some(m) = g.mean {
                    td.number { (significant(m.value, 3)) }
                    td { (significant(m.lower, 3)) " … " (significant(m.upper, 3)) }
                } @else { td.number { "—" } td { "—" } }
                @if k == 0 {
                    td { (spread(v)) }
                    td { "± " (significant(100.0 * v.own_sigma.exp_m1(), 2)) " %" }
                    td { (v.specimens_needed.map_or_else(|| "—".to_owned(), |n| format!("{n} in each group"))) }
                } @else { td {} td {} td {} }
            } } } }
        }
        @if report.values.iter().any(|v| !v.differences.is_empty()) {
            h3 { "Differences between groups" }
            table {
                thead { tr { th { "" } th { "ratio of" } th.number { "value" } th { "95 % interval" } th { "" } } }
                tbody { @for v in &report.values { @for d in &v.differences { tr {
                    td.symbol { (pretty(&v.symbol)) }
                    td { (d.of) " / " (d.over) }
                    td.number { (significant(d.ratio.value, 3)) }
                    td { (significant(d.ratio.lower, 3)) " … " (significant(d.ratio.upper, 3)) }
                    td { @if d.ratio.contains(1.0) { "no difference shown" } @else { b { "they differ" } } }
                } } } }
            }
        }
        p.caption {
            "Geometric means and the spread of a hierarchical model: each specimen counts by its own likelihood, so that what is not \
             known of a specimen is no spread between them. Restricted maximum likelihood; Student's t for means and ratios, the \
             profile for the spread. Intervals are of one value each: of twenty ratios without a difference, one shows one. Specimens \
             for a difference: power 80 %, level 5 %, two groups."
        }
    } }
}

fn answers(report: &PopulationReport) -> Markup {
    let kinds: BTreeSet<&String> = report.answers.iter().flat_map(|a| a.counts.keys()).collect();
    html! { @if !report.answers.is_empty() {
        h2 { "Answers" }
        table {
            thead { tr { th { "by" } th { "" } @for kind in &kinds { th.number { (kind) } } } }
            tbody { @for a in &report.answers { tr {
                td { (a.by) } td { (a.group) }
                @for kind in &kinds { td.number { (a.counts.get(*kind).copied().unwrap_or(0)) } }
            } } }
        }
    } }
}

/// Every specimen's value with its interval, the groups beside each other.
fn by_group(rows: &[Row], report: &PopulationReport) -> Markup {
    let figure = |v: &ValueReport| {
        let unit = if v.unit == "1" { String::new() } else { format!(" ({})", v.unit) };
        let y = Axis::log(&format!("{}{unit}", v.symbol));
        let mut chart = Chart::new(&v.symbol, Axis::linear("specimen"), y, (460.0, 260.0));
        let mut place = 0.0;
        for (k, group) in v.groups.iter().enumerate() {
            let colour = palette::measurement(k);
            let first = place;
            let of_group = |r: &&Row| r.unit.group.as_deref().unwrap_or("") == group.group;
            let step = rows.iter().filter(of_group).count().div_ceil(MOST_POINTS).max(1);
            for row in rows.iter().filter(of_group).step_by(step) {
                let Found::Fit(fit) = &row.found else { continue };
                let Some(value) = fit.values.iter().find(|x| *x.symbol == *v.symbol) else { continue };
                place += 1.0;
                if value.lower > 0.0 && value.upper / value.lower < 1e3 {
                    chart = chart.with(None, colour, Mark::Thin, &[place; 2], &[value.lower, value.upper]);
                    chart = chart.with(None, colour, Mark::Points, &[place], &[value.value]);
                    chart = chart.told(&row.unit.specimen);
                }
            }
            if let Some(mean) = group.mean.filter(|m| m.lower > 0.0) {
                let label = Some(group.group.as_str()).filter(|g| !g.is_empty());
                let x = [first + 0.5, place + 0.5];
                chart = chart.with(label, colour, Mark::Line, &x, &[mean.value; 2]);
            }
            place += 1.0;
        }
        chart.to_svg()
    };
    html! { @if !report.values.is_empty() {
        h2 { "Values by group" }
        div.pair { @for v in report.values.iter().filter(|v| v.groups.iter().any(|g| g.mean.is_some_and(|m| m.lower > 0.0))) {
            (PreEscaped(figure(v)))
        } }
        p.caption { "Points with 95 % intervals: specimens; lines: the groups' means. Of a group of more than " (MOST_POINTS) " some are drawn." }
    } }
}

fn outliers(report: &PopulationReport) -> Markup {
    html! { @if !report.outliers.is_empty() {
        h2 { "Specimens far from their group" }
        table {
            thead { tr { th { "specimen" } th { "in" } th.number { "standard deviations" } } }
            tbody { @for o in &report.outliers { tr {
                td { (o.specimen) } td.symbol { (pretty(&o.symbol)) } td.number { (significant(o.distance, 2)) }
            } } }
        }
        p.caption { "Further than chance brings the most distant of so many, in one study of twenty for each value. They are in the estimates above." }
    } }
}

fn failures(rows: &[Row]) -> Markup {
    let is_told = |r: &&Row| r.state != "done";
    html! { @if rows.iter().any(|r| is_told(&r)) {
        h2 { "Without a full result" }
        table {
            thead { tr { th.number { "unit" } th { "specimen" } th { "state" } th { "reason" } } }
            tbody { @for r in rows.iter().filter(is_told) { tr {
                td.number { (r.unit.unit) } td { (r.unit.specimen) } td { (r.state) } td { (r.reason) }
            } } }
        }
    } }
}

fn curves(rows: &[Row]) -> Markup {
    let of = |row: &Row| -> Option<(String, String)> {
        let (curves, told): (&[Curve], String) = match &row.found {
            Found::Fit(fit) => (&fit.curves, format!("χ²/dof {}", significant(fit.reduced_chi_square, 2))),
            Found::Verdict(v) => (&v.curves, v.answer.clone()),
            Found::Nothing => return None,
        };
        if curves.is_empty() {
            return None;
        }
        let (x, y) = (Axis::linear("time (s)"), Axis::linear("force (mN)"));
        let mut chart = Chart::new(&row.unit.specimen, x, y, (260.0, 180.0));
        for (k, c) in curves.iter().enumerate() {
            let colour = palette::measurement(k);
            chart = chart.with(None, palette::GREY, Mark::Points, &c.time_s, &c.measured_mn).told(&c.name);
            chart = chart.with(None, colour, Mark::Line, &c.time_s, &c.model_mn).told(&c.name);
        }
        Some((chart.to_svg(), told))
    };
    let shown: Vec<(String, String)> = rows.iter().filter_map(of).collect();
    html! { @if !shown.is_empty() {
        h2 { "Every specimen" }
        div.multiples { @for (figure, told) in &shown { figure { (PreEscaped(figure)) p.meta { (told) } } } }
        p.caption {
            "Points: measured; lines: model."
            @if shown.len() < rows.iter().filter(|r| !matches!(r.found, Found::Nothing)).count() {
                " Shown are those that are fitted worst."
            }
        }
    } }
}
