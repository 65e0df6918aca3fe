//! The inspection as one self-contained HTML page.

use super::figures;
use super::result::*;
use super::table::{cycles, noise, odd_line, plus_minus, quartiles, ratio, water_line};
use crate::data::{Estimate, Phase};
use crate::report::plot::pretty;
use crate::report::{document, glossary, shapes};
use maud::{Markup, PreEscaped, html};

/// The page.
pub fn page(inspection: &Inspection) -> String {
    let names: Vec<&str> = inspection.tests.iter().map(|t| t.name.as_str()).collect();
    let title = format!("Inspection of {}", crate::inference::wording::list(&names));
    let body = html! {
        h1 { (title) }
        p.meta { "What the measurements say themselves, without a model. Median [quartiles] of the specimens." }
        @if inspection.tests.iter().any(|t| t.source.synthetic) {
            p.synthetic { "Synthetic data: computed, not measured" }
        }
        @if inspection.tests.len() > 1 { (together(inspection)) }
        @if let Some(water) = &inspection.water { h2 { "Water content" } p { (text(&water_line(water))) "." } }
        @for test in &inspection.tests { (one_test(test, inspection.contact_threshold_mn)) }
        (glossary())
        (origin(inspection))
    };
    document(&title, SWATCHES, &body)
}

const SWATCHES: &str = ".legend { color: var(--grey); font-size: 13px; margin: 6px 0 0; max-width: none; } \
    .legend span { margin-right: 18px; white-space: nowrap; } \
    .legend svg { vertical-align: -2px; margin-right: 6px; } td, th { white-space: nowrap; } \
    .scroll { overflow-x: auto; } td.wrap { white-space: normal; }";

/// Typographic signs instead of typewriter ones.
fn text(plain: &str) -> String {
    let signs = pretty(plain).replace(" - ", " – ").replace("kg/m^3", "kg/m³");
    let mut out = String::with_capacity(signs.len());
    let mut before = ' ';
    for (i, c) in signs.char_indices() {
        let digit_follows = signs[i + c.len_utf8()..].starts_with(|n: char| n.is_ascii_digit());
        // A minus begins a number: not the hyphen within a word or a range of names.
        out.push(if c == '-' && digit_follows && " [(=".contains(before) { '−' } else { c });
        before = c;
    }
    out
}

fn together(inspection: &Inspection) -> Markup {
    html! {
        h2 { "The tests against each other" }
        @if !inspection.ratios.is_empty() {
            div.scroll { table {
                thead { tr {
                    th { "tests" } th.number { "cycle" } th.number { "rates" } th.number { "peaks" }
                    th.number { "ends of hold" } th.number { "peaks / ends of hold" }
                } }
                tbody { @for r in &inspection.ratios { tr {
                    td { (r.test) " / " (r.reference) } td.number { (r.cycle) }
                    td.number { (format!("{:.2}", r.rate)) } td.number { (text(&ratio(r.peak))) }
                    td.number { (text(&ratio(r.hold_end))) } td.number { (text(&ratio(r.rate_effect))) }
                } } }
            } }
            p.caption {
                "Ratios of medians, ± one standard uncertainty from the scatter of specimens, taken as different \
                 ones in each test. A material with fading memory has forgotten the rate by the end of equal holds: \
                 the ratio there is one of amplitudes between two sets of specimens. What the peaks' ratio has \
                 beyond it is the effect of the rate."
            }
        }
        div.pair { @for figure in figures::by_cycle(inspection) { (PreEscaped(figure)) } }
    }
}

fn one_test(test: &TestInspection, threshold_mn: f64) -> Markup {
    let autocorrelation = figures::autocorrelation(test);
    html! {
        h2 { (test.name) }
        p.meta {
            (cycles(test)) ", " (test.points) " points, "
            @if test.specimens.is_empty() { "one curve" } @else { (test.specimens.len()) " specimens" }
        }
        @if !test.source.notes.is_empty() { ul { @for note in &test.source.notes { li { (text(note)) } } } }
        @if !test.odd_specimens.is_empty() {
            ul { @for odd in &test.odd_specimens { li { b { (text(&odd_line(odd))) } } } }
        }
        (forces(test))
        (legend())
        @if let Some(f) = figures::as_read(test) { (shapes(&f)) }
        @for figure in figures::whole(test) { (shapes(&figure)) }
        div.pair {
            @if let Some(f) = figures::loading(test) { (PreEscaped(f)) }
            @if let Some(f) = figures::holds(test) { (PreEscaped(f)) }
        }
        p.caption {
            "Left: median and quartiles of the specimens. Right: medians, cycle 1 in the colour of the letters with its quartiles, the last \
             cycle red, those between blue. The hold is divided into the last \
             decade of time before its end (late), the decade before that (middle) and what is earlier."
        }
        h3 { "Contact and baseline" }
        (contacts(test, threshold_mn))
        div.pair {
            @if let Some(f) = figures::loadings(test) { (PreEscaped(f)) }
            @if let Some(f) = &autocorrelation { (PreEscaped(f)) }
        }
        @if autocorrelation.is_some() {
            p.caption { "Autocorrelation of the force while the punch rests in the air, drift taken out; grey band: two standard \
                 deviations for independent samples." }
        }
        h3 { "Noise" }
        ul { @for line in noise(&test.noise) { li { (text(&line)) } } }
    }
}

fn legend() -> Markup {
    html! {
        p.legend { @for phase in Phase::ALL {
            span {
                svg width="22" height="12" {
                    rect width="22" height="12" fill=(figures::colour(phase)) fill-opacity="0.3" {}
                }
                (phase.name())
            }
        } }
    }
}

fn forces(test: &TestInspection) -> Markup {
    let after: Vec<f64> =
        test.cycles.first().map_or(vec![], |c| c.force_after.iter().map(|f| f.after_s).collect());
    html! {
        div.scroll { table {
            thead { tr {
                th.number { "cycle" } th.number { "depth (mm)" } th.number { "rate (mm/s)" } th.number { "peak (mN)" }
                @for s in &after { th.number { "after " (s) " s" } }
                th.number { "end of hold (mN)" } th.number { "relaxation (%)" } th.number { "peak / first" }
            } }
            tbody { @for c in &test.cycles { tr {
                td.number { (c.times.number) } td.number { (format!("{:.3}", c.depth_mm)) }
                td.number { (format!("{:.3}", c.rate_mm_per_s.value)) } td.number { (quartiles(c.peak_mn, 2)) }
                @for s in &after { td.number {
                    @if let Some(f) = c.force_after.iter().find(|f| f.after_s == *s) {
                        (format!("{:.2}", f.force_mn.median))
                    }
                } }
                td.number { (quartiles(c.hold_end_mn, 2)) } td.number { (quartiles(c.relaxation_percent, 1)) }
                td.number { (quartiles(c.peak_over_first, 3)) }
            } } }
        } }
    }
}

fn contacts(test: &TestInspection, threshold_mn: f64) -> Markup {
    let optional = |e: Option<Estimate>| e.map_or_else(|| "–".to_owned(), |e| text(&plus_minus(e)));
    let at = |c: &ContactInspection| Estimate { value: c.threshold_mm.median, sigma: c.threshold_sigma_mm };
    let onset =
        |c: &ContactInspection| Some(Estimate { value: c.onset_mm?.median, sigma: c.onset_sigma_mm? });
    html! {
        div.scroll { table {
            thead { tr {
                th.number { "cycle" } th.number { "contact at " (threshold_mn) " mN (mm)" } th.number { "onset (mm)" }
                th.number { "retraction minimum (mN)" } th.number { "noise alone (mN)" }
                th.number { "off contact before (mN)" } th.number { "after (mN)" } th.number { "drift (mN)" }
            } }
            tbody { @for c in &test.cycles { tr {
                td.number { (c.times.number) }
                td.number { (optional(c.contact.as_ref().map(at))) }
                td.number { (optional(c.contact.as_ref().and_then(onset))) }
                td.number { @if let Some(r) = c.retraction {
                    (text(&quartiles(r.minimum_mn, 3))) @if r.adhesion { b { " adhesion" } }
                } }
                td.number { @if let Some(r) = c.retraction { (text(&format!("{:.3}", r.noise_alone_mn))) } }
                td.number { (optional(c.off_contact.off_contact_before_mn)) }
                td.number { (optional(c.off_contact.off_contact_after_mn)) }
                td.number { (optional(c.off_contact.drift_mn)) }
            } } }
        } }
        p.caption {
            "Contact: displacement at which the force passes the threshold above that off contact, median of the specimens ± uncertainty of \
             one (noise over slope, sampling); onset: where the force begins, by extrapolation of the samples up to \
             three thresholds. Noise alone: what the smallest of as many noise samples would pass in one of a \
             hundred cycles; a minimum below it is adhesion. Off contact and drift: mean of the specimens ± \
             standard error."
        }
    }
}

fn origin(inspection: &Inspection) -> Markup {
    html! {
        h2 { "Origin" }
        table { tbody { @for t in &inspection.tests { tr {
            td { b { (t.name) } } td { span.mono { (t.source.file) } }
            td.wrap { @if t.source.comments.is_empty() { "the file does not say where its data come from" }
                @else { (t.source.comments.join("; ")) } }
        } } } }
        p.mono { (inspection.command) }
        p.caption { "Schema " (inspection.schema) }
    }
}
