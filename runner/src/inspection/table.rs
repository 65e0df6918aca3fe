//! The inspection on a console.

use super::result::*;
use super::water::WaterContent;
use crate::data::{Estimate, Quartiles};
use crate::inference::wording::significant;
use crate::report::columns;
use std::fmt::Write;

/// The inspection as plain text.
pub fn table(inspection: &Inspection) -> String {
    let mut out = String::new();
    for test in &inspection.tests {
        describe(&mut out, test);
        forces(&mut out, test);
        contacts(&mut out, test, inspection.contact_threshold_mn);
        for line in noise(&test.noise) {
            let _ = writeln!(out, "{line}");
        }
        for odd in &test.odd_specimens {
            let _ = writeln!(out, "warning: {}", odd_line(odd));
        }
        for note in &test.source.notes {
            let _ = writeln!(out, "note: {note}");
        }
        out.push('\n');
    }
    ratios(&mut out, &inspection.ratios);
    if let Some(w) = &inspection.water {
        let _ = writeln!(
            out,
            "{}\nfor a model: --set material.n0s={}",
            water_line(w),
            significant(w.n0s.value, 4)
        );
    }
    out.trim_end().to_owned()
}

fn describe(out: &mut String, test: &TestInspection) {
    let specimens = match test.specimens.len() {
        0 => "one curve".to_owned(),
        n => format!("{n} specimens; median [quartiles]"),
    };
    let synthetic = if test.source.synthetic { " - SYNTHETIC: computed, not measured" } else { "" };
    let _ = writeln!(out, "{}: {}, {} points, {specimens}{synthetic}", test.name, cycles(test), test.points);
    if !test.shifts_s.is_empty() {
        let shifts = test.specimens.iter().zip(&test.shifts_s);
        let shifts: Vec<String> = shifts.map(|(n, s)| format!("{n} {:+.4}", s.value)).collect();
        let _ = writeln!(out, "clocks shifted onto the ramps of the first (s): {}", shifts.join(", "));
    }
}

/// An odd specimen, and what becomes of it.
pub(super) fn odd_line(odd: &OddSpecimen) -> String {
    let then = if odd.left_out { "fits leave it out" } else { "is it one of these? Fits take it for one" };
    format!("specimen {}: {}; {then}", odd.name, odd.why)
}

/// `1 cycle`, `6 cycles`.
pub(super) fn cycles(test: &TestInspection) -> String {
    match test.cycles.len() {
        1 => "1 cycle".to_owned(),
        n => format!("{n} cycles"),
    }
}

fn forces(out: &mut String, test: &TestInspection) {
    let row = |c: &CycleInspection| {
        let after = |s: f64| {
            let found = c.force_after.iter().find(|f| f.after_s == s);
            found.map_or_else(|| "-".to_owned(), |f| format!("{:.2}", f.force_mn.median))
        };
        vec![
            c.times.number.to_string(),
            format!("{:.3}", c.depth_mm),
            format!("{:.3}", c.rate_mm_per_s.value),
            quartiles(c.peak_mn, 2),
            format!("{} {} {} {}", after(1.0), after(10.0), after(30.0), after(90.0)),
            quartiles(c.hold_end_mn, 2),
            quartiles(c.relaxation_percent, 1),
            quartiles(c.peak_over_first, 3),
        ]
    };
    let rows: Vec<Vec<String>> = test.cycles.iter().map(row).collect();
    let header = [
        "cycle",
        "depth mm",
        "rate mm/s",
        "peak mN",
        "after 1 10 30 90 s",
        "end of hold mN",
        "relaxation %",
        "peak / 1st",
    ];
    columns(out, header, &rows);
}

fn contacts(out: &mut String, test: &TestInspection, threshold_mn: f64) {
    let row = |c: &CycleInspection| {
        let pull = c.retraction.map_or_else(dash, |r| {
            let word = if r.adhesion { "adhesion" } else { "noise" };
            format!("{:.3} ({word}: {:.3})", r.minimum_mn.median, r.noise_alone_mn)
        });
        let contact = c.contact.as_ref();
        let onset = contact.and_then(|k| k.onset_mm.zip(k.onset_sigma_mm));
        vec![
            c.times.number.to_string(),
            contact.map_or_else(dash, |k| {
                plus_minus(Estimate { value: k.threshold_mm.median, sigma: k.threshold_sigma_mm })
            }),
            onset.map_or_else(dash, |(q, sigma)| plus_minus(Estimate { value: q.median, sigma })),
            pull,
            c.off_contact.off_contact_before_mn.map_or_else(dash, plus_minus),
            c.off_contact.off_contact_after_mn.map_or_else(dash, plus_minus),
            c.off_contact.drift_mn.map_or_else(dash, plus_minus),
        ]
    };
    let rows: Vec<Vec<String>> = test.cycles.iter().map(row).collect();
    let at = format!("contact at {threshold_mn} mN mm");
    let header = [
        "cycle",
        at.as_str(),
        "onset mm",
        "retraction minimum mN",
        "off contact before mN",
        "after mN",
        "drift mN",
    ];
    columns(out, header, &rows);
}

/// The noise in sentences.
pub(super) fn noise(n: &NoiseInspection) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(white) = n.white_mn {
        let left_out =
            if n.outliers > 0 { format!(", {} left out as outliers", n.outliers) } else { String::new() };
        lines.push(format!(
            "noise {} ({} samples{left_out}): white {} mN per specimen",
            if n.white_from == NoiseSource::OffContact { "off contact" } else { "in the late holds" },
            n.samples,
            plus_minus(white)
        ));
    }
    match (n.correlated.correlated_mn, n.correlated.correlation_time_s, n.correlated.correlated_below_mn) {
        (Some(amplitude), Some(time), _) => lines.push(format!(
            "correlated noise: {} mN, correlation time {} s",
            plus_minus(amplitude),
            plus_minus(time)
        )),
        (_, _, Some(limit)) => {
            lines.push(format!("correlated noise: none seen, below {} mN (95 %)", significant(limit, 2)));
        }
        _ => {}
    }
    if let (Some(log), Some(height)) = (n.specimen_log_deviation, n.height_of_median) {
        lines.push(format!(
            "specimens: a factor common to a whole curve scatters by {:.1} +- {:.1} % (log-normal), so the height \
             of the median is known to {:.1} %",
            log.value * 100.0,
            log.sigma * 100.0,
            height * 100.0
        ));
    }
    lines
}

fn ratios(out: &mut String, ratios: &[Ratio]) {
    if ratios.is_empty() {
        return;
    }
    let row = |r: &Ratio| {
        vec![
            format!("{} / {}", r.test, r.reference),
            r.cycle.to_string(),
            format!("{:.2}", r.rate),
            ratio(r.peak),
            ratio(r.hold_end),
            ratio(r.rate_effect),
        ]
    };
    let rows: Vec<Vec<String>> = ratios.iter().map(row).collect();
    // The columns begin with an empty line of their own.
    out.truncate(out.trim_end().len() + 1);
    let header = ["tests", "cycle", "rate", "peak", "end of hold", "peak / end of hold"];
    columns(out, header, &rows);
    out.push_str("The end of the hold tells the amplitude, peak / end of hold the effect of the rate.\n\n");
}

/// `1.061 +- 0.055`.
pub(super) fn ratio(r: RatioValue) -> String {
    match r.sigma {
        Some(sigma) => format!("{:.3} +- {sigma:.3}", r.value),
        None => format!("{:.3}", r.value),
    }
}

/// Water content in a sentence.
pub(super) fn water_line(w: &WaterContent) -> String {
    let with = |e: Estimate| {
        if w.uncertainty_known { plus_minus(e) } else { significant(e.value, 4) }
    };
    let unknown = if w.uncertainty_known { "" } else { "; no uncertainty was given" };
    format!(
        "Water fraction (Eq. 1) {}; volume fraction of solid n0S = {} (solid {} kg/m^3, water {} kg/m^3{unknown})",
        with(w.water_fraction),
        with(w.n0s),
        w.solid_density,
        w.water_density
    )
}

/// `11.69 [10.30, 12.80]`, or the value alone for a single curve.
pub(super) fn quartiles(q: Quartiles, decimals: usize) -> String {
    match q.count {
        0 => dash(),
        1 => format!("{:.decimals$}", q.median),
        _ => format!("{:.decimals$} [{:.decimals$}, {:.decimals$}]", q.median, q.q25, q.q75),
    }
}

/// A value with as many digits as its uncertainty allows: `0.0270 +- 0.0021`.
pub(super) fn plus_minus(e: Estimate) -> String {
    if e.sigma.is_nan() || e.sigma <= 0.0 {
        return significant(e.value, 4);
    }
    let decimals = (1.0 - e.sigma.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{:.decimals$} +- {:.decimals$}", e.value, e.sigma)
}

fn dash() -> String {
    "-".to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_follow_the_uncertainty() {
        assert_eq!(plus_minus(Estimate { value: 0.027_01, sigma: 0.0021 }), "0.0270 +- 0.0021");
        assert_eq!(plus_minus(Estimate { value: 123.4, sigma: 12.0 }), "123 +- 12");
        assert_eq!(plus_minus(Estimate { value: 0.5, sigma: 0.0 }), "0.5000");
    }
}
