//! The scores as text.

use super::binomial::Share;
use super::score::{FAR, Scores, Table};
use crate::inference::wording::whole_percent;
use std::fmt::Write as _;

/// Gates of the design, section 7.
const GATES: [&str; 11] = [
    "<= 3 %, bound <= 6 %",
    ">= 92 %, bound >= 85 %",
    ">= 97 %",
    ">= 92 %",
    ">= 80 %",
    ">= 97 %",
    ">= 97 %",
    ">= 80 %",
    "84 to 95 %",
    "<= 30 %",
    "<= 1.5",
];

/// How a score is written.
type Cell = fn(&Scores) -> String;

/// Markdown: scores of the diagnosis beside those of the simple rules, then every answer.
pub fn markdown(table: &Table) -> String {
    let mut text = String::from("| | gate | diagnose | far from Table 1 |");
    table.rules.iter().for_each(|(name, _)| text.push_str(&format!(" {name} |")));
    text.push_str("\n|---|---|---|---|");
    table.rules.iter().for_each(|_| text.push_str("---|"));
    text.push('\n');
    let rows: [(&str, Cell); 11] = [
        ("false accusations of cases without a gap", |s| share(s.false_accusations)),
        ("visible single effects that matter, named first", |s| share(s.top_1)),
        ("the same, within the group of at most 3", |s| share(s.in_group)),
        ("causes outside the catalogue not blamed on it", |s| share(s.outside)),
        ("of these, where none of the catalogue is the answer: described rightly", |s| share(s.description)),
        ("visible effects that do not matter: nothing else accused", |s| share(s.immaterial)),
        ("effects too weak to see: nothing else accused", |s| share(s.weak)),
        ("pairs, both visible, both matter: both named", |s| share(s.pairs)),
        ("true shrinkage inside its 90 % interval", |s| share(s.coverage)),
        ("median width of that interval", |s| {
            s.width().map_or_else(|| "-".to_owned(), |w| format!("{:.0} %", 100.0 * w))
        }),
        ("mean size of a group", |s| s.group_size().map_or_else(|| "-".to_owned(), |n| format!("{n:.2}"))),
    ];
    for ((name, of), gate) in rows.iter().zip(GATES) {
        let _ = write!(text, "| {name} | {gate} | {} | {} |", of(&table.diagnosis), of(&table.far));
        table.rules.iter().for_each(|(_, scores)| text.push_str(&format!(" {} |", of(scores))));
        text.push('\n');
    }
    text.push_str("\nShares with exact 90 % intervals; each end is a one-sided bound of 95 %. ");
    let _ = write!(
        text,
        "Far: a modulus, time or permeability at least {FAR} times Table 1's, or 1/{FAR} of it."
    );
    let d = &table.diagnosis;
    if !d.accused_by_noise.is_empty() {
        let parts = d.accused_by_noise.iter().map(|(noise, s)| format!("{noise} {}", share(*s)));
        let _ = write!(text, " Accused, by noise: {}.", parts.collect::<Vec<_>>().join("; "));
    }
    let c = table.confidence();
    let told = c.reliability.iter().map(|(mean, s)| format!("{:.0} %: {}", 100.0 * mean, share(*s)));
    let _ = write!(
        text,
        " Confidence: expected calibration error {:.2}, Brier score {:.3} (a constant's {:.3}); right answers by mean confidence {}.",
        c.expected_error,
        c.brier,
        c.brier_of_a_constant,
        told.collect::<Vec<_>>().join("; ")
    );
    text.push_str("\n\n| case | behind it | visibility | gap | answer | confidence | shrinkage | true one | |\n|---|---|---|---|---|---|---|---|---|\n");
    for l in &table.lines {
        let seen = l.visibility.map_or_else(String::new, |v| format!("{v:.1}"));
        let gap = l.gap_percent.map_or_else(String::new, |g| format!("{g:.2} %"));
        let shrunk = l.shrinkage.map_or_else(String::new, |(v, low, high)| {
            format!("{} % [{}, {}]", whole_percent(v), whole_percent(low), whole_percent(high))
        });
        let truth = l.true_shrinkage.map_or_else(String::new, |v| format!("{} %", whole_percent(v)));
        let _ = writeln!(
            text,
            "| {} | {} | {seen} | {gap} | {} | {} % | {shrunk} | {truth} | {} |",
            l.id,
            l.truth,
            l.answer,
            whole_percent(l.confidence),
            if l.right { "" } else { "wrong" }
        );
    }
    for (what, cases) in [("Without an answer", &table.missing), ("Not counted", &table.left_out)] {
        if !cases.is_empty() {
            let _ = writeln!(text, "\n{what}: {}.", cases.join(", "));
        }
    }
    text
}

fn share(s: Share) -> String {
    let Some(value) = s.value() else { return "-".to_owned() };
    let (low, high) = s.interval();
    format!("{} of {} = {:.0} % [{:.0}, {:.0}]", s.hits, s.of, 100.0 * value, 100.0 * low, 100.0 * high)
}
