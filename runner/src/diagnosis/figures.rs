//! The figures of the diagnosis's page.

use super::result::*;
use crate::data::Phase;
use crate::report::plot::{Axis, Chart, Mark, escape, palette};
use std::fmt::Write as _;

const HALF: (f64, f64) = (490.0, 300.0);
const FONT: &str = r#"font-family="Helvetica Neue, Helvetica, Arial, Liberation Sans, sans-serif""#;

/// For each test: the force, and measured minus model.
pub(super) fn curves(d: &Diagnosis) -> Vec<[String; 2]> {
    d.curves.iter().map(|c| [force(c), residual(c)]).collect()
}

/// Time on a log axis for single cycles, where the ramp would vanish on a linear one.
fn axis(c: &CurvePair) -> (Axis, Vec<usize>) {
    const LONG_S: f64 = 120.0;
    const FIRST_S: f64 = 0.05;
    let last = c.time_s.last().copied().unwrap_or(0.0);
    if last > LONG_S {
        return (Axis::linear("time (s)"), (0..c.time_s.len()).collect());
    }
    let shown: Vec<usize> = (0..c.time_s.len()).filter(|&i| c.time_s[i] >= FIRST_S).collect();
    (Axis::log("time (s)").with_range(FIRST_S, last.max(2.0 * FIRST_S)), shown)
}

fn pick(values: &[f64], shown: &[usize]) -> Vec<f64> {
    shown.iter().map(|&i| values[i]).collect()
}

fn force(c: &CurvePair) -> String {
    let (axis, shown) = axis(c);
    let t = pick(&c.time_s, &shown);
    let mut chart = Chart::new(&c.name, axis, Axis::linear("force (mN)"), HALF).with_reference(0.0);
    for specimen in &c.specimens_mn {
        chart = chart.with(None, palette::GREY, Mark::Thin, &t, &pick(specimen, &shown));
    }
    chart = chart
        .with(None, palette::INK, Mark::Points, &t, &pick(&c.measured_mn, &shown))
        .told("measured")
        .with(None, palette::BLUE, Mark::Line, &t, &pick(&c.before_mn, &shown))
        .told("plain model");
    if let Some(after) = &c.after_mn {
        chart = chart
            .with(None, palette::VERMILION, Mark::Dashed, &t, &pick(after, &shown))
            .told("with the effect");
    }
    chart.to_svg()
}

fn residual(c: &CurvePair) -> String {
    let (axis, shown) = axis(c);
    let t = pick(&c.time_s, &shown);
    let minus = |model: &[f64]| -> Vec<f64> { shown.iter().map(|&i| c.measured_mn[i] - model[i]).collect() };
    let band: Vec<f64> = shown.iter().map(|&i| 2.0 * c.sigma_mn[i]).collect();
    let low: Vec<f64> = band.iter().map(|b| -b).collect();
    let mut chart = Chart::new("Measured minus model", axis, Axis::linear("difference (mN)"), HALF)
        .with_reference(0.0)
        .with(None, palette::GREY, Mark::Band(band), &t, &low)
        .with(None, palette::BLUE, Mark::Line, &t, &minus(&c.before_mn))
        .told("minus the plain model");
    if let Some(after) = &c.after_mn {
        chart = chart
            .with(None, palette::VERMILION, Mark::Line, &t, &minus(after))
            .told("minus the model with the effect");
    }
    chart.to_svg()
}

/// White at 0, blue below, vermilion above, full at twice the threshold.
fn shade(score: f64, threshold: f64) -> String {
    let end = if score < 0.0 { [0x00, 0x72, 0xb2] } else { [0xd5, 0x5e, 0x00] };
    let t = (score.abs() / (2.0 * threshold)).min(1.0);
    let mix = |c: i32| (255.0 + t * (f64::from(c) - 255.0)).round() as i32;
    format!("rgb({},{},{})", mix(end[0]), mix(end[1]), mix(end[2]))
}

/// Scores by test, cycle and pattern (rows) and phase or relaxation time (columns).
pub(super) fn residual_map(d: &Diagnosis) -> String {
    const CELL: (f64, f64) = (88.0, 30.0);
    const LEFT: f64 = 170.0;
    let spots = &d.location.spots;
    let mut rows: Vec<(String, Option<usize>, String)> = Vec::new();
    for s in spots {
        let row = (s.test.clone(), s.cycle, s.pattern.clone());
        if !rows.contains(&row) {
            rows.push(row);
        }
    }
    let mut times: Vec<f64> = spots.iter().filter_map(|s| s.time_s).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let columns = Phase::ALL.len().max(times.len());
    let blocks = [
        rows.iter().filter(|r| r.1.is_some()).collect::<Vec<_>>(),
        rows.iter().filter(|r| r.1.is_none()).collect(),
    ];
    let (width, height) = (LEFT + CELL.0 * columns as f64 + 4.0, CELL.1 * (rows.len() as f64 + 2.0) + 16.0);
    let mut svg = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" class="cells" {FONT} font-size="12"><title>scores of the residual</title>"#
    );
    let mut y = 0.0;
    for (block, rows) in blocks.iter().enumerate() {
        let heads: Vec<String> = match block {
            0 => Phase::ALL.iter().map(|p| p.name().to_owned()).collect(),
            _ => times.iter().map(|t| format!("{t} s")).collect(),
        };
        for (j, head) in heads.iter().enumerate() {
            let x = LEFT + (j as f64 + 0.5) * CELL.0;
            let _ = write!(
                svg,
                r#"<text x="{x}" y="{}" text-anchor="middle" fill="{}">{head}</text>"#,
                y + 20.0,
                palette::GREY
            );
        }
        y += CELL.1;
        for (test, cycle, pattern) in rows {
            let cycle_text = cycle.map_or_else(|| "holds".to_owned(), |c| format!("cycle {c}"));
            let label = escape(&format!("{test}, {cycle_text}, {pattern}"));
            let _ = write!(
                svg,
                r#"<text x="{}" y="{}" text-anchor="end" fill="{}">{label}</text>"#,
                LEFT - 8.0,
                y + 19.0,
                palette::INK
            );
            for s in spots.iter().filter(|s| s.test == *test && s.cycle == *cycle && s.pattern == *pattern) {
                let by_phase = s.phase.and_then(|p| Phase::ALL.iter().position(|q| *q == p));
                let by_time = s.time_s.and_then(|t| times.iter().position(|u| *u == t));
                let Some(j) = by_phase.or(by_time) else { continue };
                let x = LEFT + j as f64 * CELL.0;
                let beyond = s.score.abs() > d.location.threshold;
                let _ = write!(
                    svg,
                    r#"<rect x="{}" y="{}" width="{}" height="{}" rx="3" fill="{}" stroke="{}"/><text x="{}" y="{}" text-anchor="middle" font-weight="{}" fill="{}">{}</text>"#,
                    x + 1.0,
                    y + 1.0,
                    CELL.0 - 2.0,
                    CELL.1 - 2.0,
                    shade(s.score, d.location.threshold),
                    palette::FAINT,
                    x + 0.5 * CELL.0,
                    y + 19.0,
                    if beyond { "bold" } else { "normal" },
                    if s.score.abs() > 1.3 * d.location.threshold { "white" } else { palette::INK },
                    format!("{:.1}", s.score).replace('-', "−"),
                );
            }
            y += CELL.1;
        }
    }
    svg.push_str("</svg>");
    svg
}

/// Horizontal bars with labels and values; `marks` are vertical lines.
fn bars(title: &str, bars: &[(String, f64, &str)], marks: &[f64]) -> String {
    const ROW: f64 = 24.0;
    const LEFT: f64 = 270.0;
    const WIDTH: f64 = 620.0;
    let reach = bars.iter().map(|b| b.1.abs()).chain(marks.iter().map(|m| m.abs())).fold(1.0, f64::max);
    let low = bars.iter().map(|b| b.1).chain(marks.iter().copied()).fold(0.0, f64::min);
    let unit = WIDTH / (reach - low).max(1e-9);
    let at = |v: f64| LEFT + (v - low) * unit;
    let height = ROW * bars.len() as f64 + 10.0;
    let width = LEFT + WIDTH + 60.0;
    let mut svg = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" {FONT} font-size="12"><title>{title}</title>"#
    );
    for (i, (label, value, colour)) in bars.iter().enumerate() {
        let y = ROW * i as f64 + 4.0;
        let (from, to) = (at(value.min(0.0)), at(value.max(0.0)));
        let _ = write!(
            svg,
            r#"<text x="{}" y="{}" text-anchor="end" fill="{ink}">{}</text><rect x="{from}" y="{y}" width="{}" height="{}" fill="{colour}"/><text x="{}" y="{}" fill="{ink}">{}</text>"#,
            LEFT - 8.0,
            y + 13.0,
            escape(label),
            (to - from).max(0.5),
            ROW - 7.0,
            to + 5.0,
            y + 13.0,
            format!("{value:.1}").replace('-', "−"),
            ink = palette::INK,
        );
    }
    for mark in marks.iter().chain([&0.0]) {
        let (x, dash) = (at(*mark), if *mark == 0.0 { "none" } else { "4 3" });
        let _ = write!(
            svg,
            r#"<path d="M{x} 0V{height}" stroke="{}" stroke-dasharray="{dash}" fill="none"/>"#,
            palette::GREY
        );
    }
    svg.push_str("</svg>");
    svg
}

/// Scores of all testable effects, with the threshold that noise alone seldom passes.
pub(super) fn score_bars(d: &Diagnosis) -> String {
    let counted = |e: &&EffectSummary| e.testable;
    let bar = |e: &EffectSummary| {
        let named = d.verdict.effects.contains(&e.name);
        (e.name.clone(), e.score, if named { palette::VERMILION } else { palette::SKY })
    };
    let all: Vec<_> = d.effects.iter().filter(counted).map(bar).collect();
    bars("score of each effect", &all, &[d.location.threshold, -d.location.threshold])
}

/// Evidence of all models against no gap.
pub(super) fn evidence_bars(d: &Diagnosis) -> String {
    let mut all: Vec<_> =
        d.models.iter().map(|m| (m.effects.join(" and "), m.evidence, palette::BLUE)).collect();
    all.push(("something else".to_owned(), d.something_else_evidence, palette::PURPLE));
    all.push(("no gap".to_owned(), 0.0, palette::GREY));
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    bars("twice the log evidence against no gap", &all, &[])
}
