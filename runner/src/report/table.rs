//! The report on a console.

use super::fit_report::*;
use crate::inference::statistics::{BoundSide, Determination};
use crate::inference::wording::{significant, spread};
use crate::text::{WIDTH, wrapped};
use std::fmt::Write;

/// The report as plain text.
pub fn table(report: &FitReport) -> String {
    let mut out = format!("{}\n{}\n\n", report.given.title, "=".repeat(report.given.title.chars().count()));
    paragraph(&mut out, "", &report.verdict.headline);
    section(&mut out, "Not determined", &report.verdict.undetermined);
    section(&mut out, "Mind", &report.verdict.warnings);

    let parameters: Vec<Vec<String>> = report
        .parameters
        .iter()
        .map(|p| vec![p.symbol.clone(), value(p.value, &p.unit), interval(p), note(p), p.name.clone()])
        .collect();
    columns(&mut out, ["parameter", "value", "95 % interval", "", "name"], &parameters);
    let derived: Vec<Vec<String>> = report
        .derived
        .iter()
        .map(|d| {
            let range = format!("{} .. {}", significant(d.lower, 3), significant(d.upper, 3));
            let range = if d.determination == Determination::Undetermined { "-".to_owned() } else { range };
            let known = known(d.determination, d.half_width);
            vec![d.symbol.clone(), value(d.value, &d.unit), range, known, d.formula.clone()]
        })
        .collect();
    columns(&mut out, ["derived", "value", "95 % interval", "known to", "formula"], &derived);
    let nuisances: Vec<Vec<String>> = report
        .given
        .nuisances
        .iter()
        .map(|n| {
            let range = format!("{} .. {}", significant(n.lower, 3), significant(n.upper, 3));
            vec![n.name.clone(), value(n.value, &n.unit), range]
        })
        .collect();
    columns(&mut out, ["beyond what was read", "higher by", "95 % interval"], &nuisances);
    let pair =
        |p: Pair, digits| format!("{} / {}", significant(p.measured, digits), significant(p.model, digits));
    let measurements: Vec<Vec<String>> = report
        .measurements
        .iter()
        .map(|m| {
            let role = if m.curve.role == Role::Fit { "fit" } else { "validation" };
            vec![
                format!("{} ({role})", m.curve.name),
                format!("{} mN", pair(m.peak_mn, 4)),
                format!("{} %", pair(m.relaxation_percent, 3)),
                format!(
                    "{} ({})",
                    significant(m.curve.chi_square, 4),
                    significant(m.chi_square_per_point, 3)
                ),
                format!("{} mN", significant(m.rms_mn, 2)),
            ]
        })
        .collect();
    let header = ["measured / model", "peak force", "relaxation", "chi^2 (per point)", "rms"];
    columns(&mut out, header, &measurements);
    for ratio in &report.ratios {
        let _ = writeln!(out, "{}: {}", ratio.name, pair(ratio.value, 4));
    }
    for p in &report.profiles {
        let end = |v: f64, open: bool| if open { "open".to_owned() } else { significant(v, 3) };
        let range = format!("{} .. {}", end(p.lower, p.open[0]), end(p.upper, p.open[1]));
        let why = if p.asked { "asked for" } else { "the linearised interval is open or curved" };
        let _ = writeln!(out, "profile of {}: {range} {} ({why})", p.symbol, p.unit);
    }
    if let Some(posterior) = &report.posterior {
        let _ = writeln!(out, "posterior: {}", posterior.summary);
    }
    if !report.gains.is_empty() {
        let rows: Vec<Vec<String>> = report
            .gains
            .iter()
            .map(|g| {
                let better = format!("{} times", significant(g.first_hold / g.all, 2));
                let known = |half_width| known(Determination::of(half_width), half_width);
                vec![g.symbol.clone(), known(g.first_hold), known(g.all), better]
            })
            .collect();
        out.push('\n');
        columns(&mut out, ["", "first loading and hold", "everything", "better by"], &rows);
    }
    let (fit, runs) = (&report.fit, &report.given.runs);
    let _ = writeln!(
        out,
        "\n{}\n{} iterations, {} runs, {} from the cache, {} failed; {:.2} runs at a time; {:.1} s",
        fit.stop_text,
        fit.iterations,
        runs.runs,
        runs.cache_hits,
        runs.failed,
        runs.mean_in_flight,
        runs.wall_time_s
    );
    out
}

fn value(value: f64, unit: &str) -> String {
    format!("{} {unit}", significant(value, 4)).trim_end().to_owned()
}

fn known(determination: Determination, half_width: f64) -> String {
    match determination {
        Determination::Undetermined => "not determined".to_owned(),
        Determination::Unresolved => "not told apart".to_owned(),
        _ => spread(half_width),
    }
}

fn interval(p: &ParameterRow) -> String {
    let end = |v: f64, open: bool| if open { "open".to_owned() } else { significant(v, 3) };
    format!("{} .. {}", end(p.lower, p.open[0]), end(p.upper, p.open[1]))
}

fn note(p: &ParameterRow) -> String {
    let profile = if p.profiled { " (profile)" } else { "" };
    let known = known(p.determination, p.half_width);
    match p.at_bound {
        Some(BoundSide::Lower) => format!("at lower bound; {known}{profile}"),
        Some(BoundSide::Upper) => format!("at upper bound; {known}{profile}"),
        None => format!("{known}{profile}"),
    }
}

fn section(out: &mut String, heading: &str, items: &[String]) {
    if items.is_empty() {
        return;
    }
    let _ = writeln!(out, "\n{heading}:");
    for item in items {
        paragraph(out, "  - ", item);
    }
}

/// Writes a paragraph.
fn paragraph(out: &mut String, lead: &str, text: &str) {
    let _ = writeln!(out, "{}", wrapped(&format!("{lead}{text}"), lead.trim_start().len()));
}

/// Appends rows under a header, each column as wide as its widest cell. What does not fit beside each other follows below, the
/// first column once more in front.
pub(crate) fn columns<const N: usize>(out: &mut String, header: [&str; N], rows: &[Vec<String>]) {
    if rows.is_empty() {
        return;
    }
    let width = |j: usize| {
        let cells = rows.iter().map(|r| r[j].chars().count());
        cells.chain([header[j].chars().count()]).max().unwrap_or(0)
    };
    let mut write = |block: &[usize], cells: &dyn Fn(usize) -> String| {
        let line: String = block.iter().map(|&j| format!("{:<w$}  ", cells(j), w = width(j))).collect();
        let _ = writeln!(out, "{}", line.trim_end());
    };
    let mut next = 0;
    while next < N {
        let mut block: Vec<usize> = if next == 0 { vec![] } else { vec![0] };
        let mut room = WIDTH + 2 - block.iter().map(|&j| width(j) + 2).sum::<usize>().min(WIDTH);
        while next < N && (width(next) + 2 <= room || block.len() < 2) {
            block.push(next);
            room = room.saturating_sub(width(next) + 2);
            next += 1;
        }
        write(&[], &|_| String::new());
        write(&block, &|j| header[j].to_owned());
        rows.iter().for_each(|row| write(&block, &|j| row[j].clone()));
    }
}
