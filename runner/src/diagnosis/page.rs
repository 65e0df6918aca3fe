//! The diagnosis as one self-contained HTML page.

use super::figures;
use super::result::*;
use crate::inference::wording::{fixed, list, significant};
use crate::report::plot::{heat_map, pretty};
use crate::report::{assumed, document, glossary};
use maud::{Markup, PreEscaped, html};

/// The page.
pub fn page(d: &Diagnosis) -> String {
    let names: Vec<&str> = d.tests.iter().map(|t| t.name.as_str()).collect();
    let title = format!("Diagnosis of {}", list(&names));
    let body = html! {
        h1 { (title) }
        div.verdict {
            p.headline { (pretty(&d.verdict.text)) }
            @if !d.warnings.is_empty() {
                div.warnings { h3 { "Mind" } ul { @for w in &d.warnings { li { (w) } } } }
            }
        }
        (curves(d))
        (location(d))
        (effects(d))
        (models(d))
        (held_out(d))
        (parameters(d))
        (not_testable(d))
        (next(d))
        (parity(d))
        (assumed(&d.assumptions))
        (glossary())
        (origin(d))
    };
    document(&title, STYLE, &body)
}

const STYLE: &str = ".scroll { overflow-x: auto; } td, th { white-space: nowrap; } td.wrap, th.number { white-space: normal; }";

fn number(value: f64, digits: usize) -> String {
    fixed(value, digits).replace('-', "−")
}

fn probability(p: f64) -> String {
    if p < 1e-3 { "< 0.001".to_owned() } else { format!("{p:.3}") }
}

fn curves(d: &Diagnosis) -> Markup {
    html! {
        h2 { "Measured and model, before and after" }
        @for figure in figures::curves(d) { div.pair { @for half in figure { (PreEscaped(half)) } } }
        p.caption {
            "Left: force (thin lines: every specimen), with what the plain model gives (blue) and the model with the effect (vermilion). Right: measured minus model; \
             grey band: ± two standard deviations of the measured curve, error of the simulation included."
        }
    }
}

fn location(d: &Diagnosis) -> Markup {
    html! {
        h2 { "Where the plain model misses" }
        (PreEscaped(figures::residual_map(d)))
        p.caption {
            "Score of the residual's level in each phase, of its tilt, and of the relaxation times of the holds: standard normal if there is nothing \
             but noise. The largest of all " (d.location.spots.len() + d.effects.len()) " scores passes " (number(d.location.threshold, 1))
            " by noise alone in one of 20 cases; the largest one here has the family-wise probability "
            (probability(d.location.probability)) ". Scores beyond the threshold are printed in bold."
        }
    }
}

fn effects(d: &Diagnosis) -> Markup {
    let shown: Vec<usize> = (0..d.effects.len()).filter(|&i| d.effects[i].testable).collect();
    let numbers: Vec<String> = (1..=shown.len()).map(|n| n.to_string()).collect();
    let matrix: Vec<Vec<f64>> =
        shown.iter().map(|&i| shown.iter().map(|&j| d.overlap[i][j]).collect()).collect();
    html! {
        h2 { "Which effects would look like it" }
        (PreEscaped(figures::score_bars(d)))
        div.scroll { table {
            thead { tr {
                th { "" } th { "effect" } th.number { "score" } th.number { "probability" } th.number { "expected magnitude" }
                th.number { "predicted gain" } th.number { "gain of refit" } th.number { "hidden by refit" }
                th.number { "power" } th.number { "evidence" } th { "looks the same" }
            } }
            tbody { @for (n, &i) in shown.iter().enumerate() {
                @let e = &d.effects[i];
                tr {
                    td.number { (n + 1) } td.wrap { (e.title) @if e.name.contains(" against ") { " (" (e.name) ")" } }
                    td.number { (number(e.score, 1)) } td.number { (probability(e.probability)) }
                    td.number { (magnitude(e, e.magnitude, e.magnitude_sigma)) }
                    td.number { (number(e.predicted_gain, 1)) }
                    td.number { (e.actual_gain.map_or_else(|| "–".to_owned(), |g| number(g, 1))) }
                    td.number { (number(100.0 * e.absorbed, 0)) " %" }
                    td.number { (number(e.power, 1)) } td.number { (number(e.evidence, 1)) }
                    td { (e.group.join(", ")) }
                }
            } }
        } }
        p.caption {
            "Score: residual along what a refit of the parameters leaves of the effect, standard normal without it. Gain: decrease of χ². Power: \
             score that the plausible scale would give. Evidence: twice the natural logarithm of the odds against the plain model."
        }
        @if shown.len() > 1 {
            h3 { "Overlap of the signatures" }
            (PreEscaped(heat_map(&numbers, &matrix)))
            p.caption { "Cosine between what a refit leaves of two effects (numbers of the table). Beyond ±0.9 these data cannot tell the two apart." }
        }
    }
}

/// A magnitude (plausible scales) with its deviation, in the effect's unit where it has one.
fn magnitude(e: &EffectSummary, value: f64, sigma: f64) -> String {
    let (scale, unit) = match e.unit.as_str() {
        "" => (1.0, "scales".to_owned()),
        unit => (e.scale, pretty(unit)),
    };
    plus_minus(value * scale, (sigma * scale).abs(), &unit)
}

fn plus_minus(value: f64, sigma: f64, unit: &str) -> String {
    format!("{} ± {} {unit}", significant(value, 2), significant(sigma, 2)).replace('-', "−")
}

/// Magnitudes of a model's effects.
fn magnitudes(d: &Diagnosis, m: &ModelSummary) -> String {
    // A switch has none.
    let of =
        |name: &String| d.effects.iter().find(|e| e.name == *name && m.effects.len() == m.magnitudes.len());
    let one = |(k, (value, sigma)): (usize, &(f64, f64))| match m.effects.get(k).and_then(of) {
        Some(effect) => magnitude(effect, *value, *sigma),
        None => plus_minus(*value, *sigma, "scales"),
    };
    m.magnitudes.iter().enumerate().map(one).collect::<Vec<_>>().join("; ")
}

fn models(d: &Diagnosis) -> Markup {
    html! {
        @if !d.models.is_empty() {
            h2 { "Models against each other" }
            (PreEscaped(figures::evidence_bars(d)))
            div.scroll { table {
                thead { tr {
                    th { "model" } th.number { "χ²" } th.number { "points" } th.number { "evidence" } th.number { "share" }
                    th.number { "noise alone leaves such a rest" } th.number { "rms (mN)" } th { "magnitude" }
                } }
                tbody { @for m in std::iter::once(&d.baseline).chain(&d.models) { tr {
                    td { @if m.effects.is_empty() { "plain model" } @else { (m.effects.join(" and ")) } }
                    td.number { (number(m.chi_square, 1)) } td.number { (m.points) } td.number { (number(m.evidence, 1)) }
                    td.number { @if !m.effects.is_empty() { (number(100.0 * m.probability, 1)) " %" } }
                    td.number { (probability(m.adequacy)) } td.number { (number(m.rms_mn, 4)) }
                    td { (magnitudes(d, m)) }
                } } }
            } }
            p.caption { "Each model is refitted with all parameters. “Something else” is a smooth error of any shape that no refit absorbs." }
        }
    }
}

fn held_out(d: &Diagnosis) -> Markup {
    let part =
        |v: Option<f64>| v.map_or_else(|| "undefined".to_owned(), |v| format!("{} %", number(100.0 * v, 0)));
    html! {
        h2 { "How much of the gap goes, in data that were not fitted" }
        @match &d.shrinkage {
            Some(s) => p {
                (s.of) ": " b { (part(s.value)) }
                @if let Some((low, high)) = s.interval { ", 90 % interval " (part(Some(low))) " to " (part(Some(high))) }
                ", from " (number(s.before_mn, 3)) " mN to " (number(s.after_mn, 3)) " mN."
            },
            None => p { "Undefined: there is no accepted effect, or nothing that could be predicted." },
        }
        @for h in &d.held_out {
            h3 { (h.split) }
            p.meta {
                "Gain in log predictive density by " (list(&h.chosen)) ", which the fitted part alone chooses: " (number(0.5 * h.score, 1))
                @if !h.informative { "; the fitted part does not determine its size" }
            }
            table {
                thead { tr { th { "part" } th.number { "gap before (mN)" } th.number { "after (mN)" } th.number { "gone" } th.number { "90 % interval" } } }
                tbody { @for p in &h.parts { tr {
                    td { (p.part) } td.number { (number(p.before_mn, 3)) } td.number { (number(p.after_mn, 3)) }
                    td.number { (part(p.shrinkage)) }
                    td.number { @if let Some((low, high)) = p.interval { (part(Some(low))) " to " (part(Some(high))) } }
                } } }
            }
        }
        @if !d.held_out.is_empty() {
            p.caption { "Gap: root mean square distance of the prediction from the force without its noise, as all of the data tell it. Undefined where the measurements do not make the predictions with the effect twenty times as likely as those without." }
        }
    }
}

fn parameters(d: &Diagnosis) -> Markup {
    let count = if d.verdict.kind == Kind::Pair { 2 } else { 1 };
    let after =
        d.models.iter().find(|m| m.effects.len() == count && d.verdict.effects.starts_with(&m.effects));
    html! {
        h2 { "Parameters before and after" }
        table {
            thead { tr { th { "parameter" } th.number { "plain model" } @if after.is_some() { th.number { "with the effect" } } th { "unit" } } }
            tbody { @for (i, (name, value, unit)) in d.baseline.parameters.iter().enumerate() { tr {
                td { (name) } td.number { (significant(*value, 4)) }
                @if let Some(after) = after { td.number { (after.parameters.get(i).map_or_else(String::new, |p| significant(p.1, 4))) } }
                td { (pretty(unit)) }
            } } }
        }
    }
}

fn not_testable(d: &Diagnosis) -> Markup {
    html! {
        @if !d.not_testable.is_empty() {
            h2 { "What these data cannot test" }
            table { tbody { @for n in &d.not_testable { tr { td { (n.name) } td.wrap { (n.reason) } } } } }
        }
    }
}

fn next(d: &Diagnosis) -> Markup {
    html! {
        @if !d.next.is_empty() {
            h2 { "What to measure next" }
            ul {
                @for p in &d.proposals { li { (p.in_words()) } }
                @for n in &d.next { li { (n) } }
            }
        }
    }
}

fn parity(d: &Diagnosis) -> Markup {
    html! {
        h2 { "Relations that need no fit" }
        div.scroll { table {
            thead { tr { th { "relation" } th { "of" } th.number { "value" } th.number { "without effect" } th { "unit" } th { "a deviation shows" } } }
            tbody { @for Parity { relation, of, deviation: v, shows } in &d.parity { tr {
                td { (relation) } td { (of) }
                td.number { (number(v.value, 3)) @if let Some(s) = v.sigma { " ± " (number(s, 3)) } }
                td.number { (v.expected.map_or_else(|| "–".to_owned(), |e| number(e, 3))) }
                td { (v.unit) } td { (shows) }
            } } }
        } }
    }
}

fn origin(d: &Diagnosis) -> Markup {
    html! {
        h2 { "Origin" }
        table {
            thead { tr { th { "test" } th.number { "points" } th.number { "cycles" } th.number { "specimens" } th.number { "noise of the curve (mN)" } th.number { "scatter of heights" } } }
            tbody { @for t in &d.tests { tr {
                td { (t.name) } td.number { (t.points) } td.number { (t.cycles) } td.number { (t.specimens) }
                td.number { (number(t.noise.white_mn, 3)) }
                td.number { (t.noise.height_scatter.map_or_else(|| "–".to_owned(), |s| format!("{} %", number(100.0 * s, 1)))) }
            } } }
        }
        p.mono { (d.command) }
        p.caption { "Schema " (d.schema) "; " (number(d.seconds, 0)) " s." }
    }
}
