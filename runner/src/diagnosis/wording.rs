//! The answer in plain words.

use super::result::{Diagnosis, EffectSummary, Kind};
use crate::data::measurement::DOUBT;
use crate::inference::effect::Candidate;
use crate::inference::wording::{list, significant, whole_percent};
use crate::report::columns;
use std::fmt::Write as _;

/// First lines of everything that is printed: the answer, how large the effects are or what is left looks like, and whether what it explains
/// matters.
pub fn headline(d: &Diagnosis) -> String {
    let v = &d.verdict;
    let left = d.leftover.as_ref().map(|left| format!(" {}", left.in_words())).unwrap_or_default();
    let answer = format!("{}{}{left}", answer(d), sizes(d));
    if v.kind == Kind::NoGap || v.gap_percent >= v.matters_percent {
        return answer;
    }
    let (gap, matters) = (significant(v.gap_percent, 2), significant(v.matters_percent, 2));
    format!("{answer} The gap is at most {gap} % of the peak, less than the {matters} % that matters.")
}

/// How large the effects of the answer are, in their units.
fn sizes(d: &Diagnosis) -> String {
    let of = |name: &String| {
        let effect = d.effects.iter().find(|e| e.name == *name)?;
        let model = d.models.iter().find(|m| match d.verdict.kind {
            Kind::Pair => m.effects.len() == 2 && m.effects.contains(name),
            _ => m.effects == [name.clone()],
        })?;
        let place = model.effects.iter().position(|e| e == name)?;
        let (size, deviation) = *model.magnitudes.get(place)?;
        // A switch has no size.
        let unit = if effect.unit.is_empty() { "of its plausible scale" } else { &effect.unit };
        (deviation > 0.0).then(|| {
            let digits = |value: f64| significant(value * effect.scale, 3);
            format!(
                "{} {} +- {} {unit}",
                effect.name,
                digits(size),
                digits(deviation).trim_start_matches('-')
            )
        })
    };
    let found: Vec<String> = d.verdict.effects.iter().filter_map(of).collect();
    if found.is_empty() { String::new() } else { format!(" Found: {}.", list(&found)) }
}

fn answer(d: &Diagnosis) -> String {
    let percent = format!("{} %", whole_percent(d.verdict.confidence));
    let title = |name: &String| {
        let known = d.effects.iter().find(|e| e.name == *name);
        known.map_or_else(
            || name.clone(),
            |e| {
                if e.name.contains(" against ") {
                    e.name.clone()
                } else {
                    format!("{} [{}]", e.title, e.name)
                }
            },
        )
    };
    let titles: Vec<String> = d.verdict.effects.iter().map(title).collect();
    let names: Vec<&str> = titles.iter().map(String::as_str).collect();
    match d.verdict.kind {
        Kind::NoGap if d.verdict.is_immaterial => {
            let v = &d.verdict;
            let (gap, matters) = (significant(v.gap_percent, 2), significant(v.matters_percent, 2));
            format!(
                "No gap that matters: model and data differ by {gap} % of the peak at most, where {matters} % matters (confidence {percent})."
            )
        }
        // Specimens of other heights, or few of them, show more than what matters.
        Kind::NoGap if d.verdict.gap_percent >= d.verdict.matters_percent => format!(
            "No gap: model and data differ by {} % of the peak at most, no more than their noise does (confidence {percent}).",
            significant(d.verdict.gap_percent, 2)
        ),
        Kind::NoGap => format!("No gap: model and data agree within the noise (confidence {percent})."),
        Kind::Effect => {
            format!("Effect: {} explains the gap (confidence {percent}){}.", titles[0], removed(d))
        }
        Kind::Group => format!(
            "Group: one of {} explains the gap; these data cannot tell which (confidence {percent}){}.",
            list(&names),
            removed(d)
        ),
        Kind::Pair if names.len() > 2 => format!(
            "Pair: {} together with one of {} explains the gap; these data cannot tell which (confidence {percent}){}.",
            names[0],
            list(&names[1..]),
            removed(d)
        ),
        Kind::Pair => {
            format!("Pair: {} together explain the gap (confidence {percent}){}.", list(&names), removed(d))
        }
        Kind::NoneOfThese => format!(
            "None of these: there is a gap, and no effect of the catalogue explains it (confidence {percent})."
        ),
    }
}

fn removed(d: &Diagnosis) -> String {
    let Some(s) = &d.shrinkage else { return String::new() };
    let Some(part) = part_gone(s.value, s.interval) else {
        return "; in the data not fitted the plain model has no significant gap to check it by".to_owned();
    };
    let gap = format!("{part} of the gap of {:.3} mN in data not fitted", s.before_mn);
    let answer = &d.verdict.effects;
    // One of a pair alone is not the pair.
    let is_answer = match d.verdict.kind {
        Kind::Pair => answer.iter().all(|name| s.chosen.contains(name)),
        _ => s.chosen.iter().all(|name| answer.contains(name)),
    };
    match is_answer {
        true => format!("; it removes {gap}"),
        false => format!("; what the fitted data alone would choose, {}, removes {gap}", list(&s.chosen)),
    }
}

/// A shrinkage with its interval.
fn part_gone(value: Option<f64>, interval: Option<(f64, f64)>) -> Option<String> {
    let range = |(low, high): (f64, f64)| format!(" [{}, {}]", whole_percent(low), whole_percent(high));
    value.map(|value| format!("{} %{}", whole_percent(value), interval.map(range).unwrap_or_default()))
}

/// What would tell an effect from its rivals.
pub fn next(candidate: &Candidate) -> String {
    format!("{}: {}", candidate.name, candidate.effect.reveals)
}

/// Why an effect cannot be tested.
pub fn too_weak(e: &EffectSummary, threshold: f64) -> String {
    format!(
        "at its plausible scale its score would be {:.1} where {threshold:.1} is needed: a refit of the parameters \
         hides {:.0} % of it",
        e.power,
        100.0 * e.absorbed
    )
}

/// The tables on the terminal.
pub fn table(d: &Diagnosis) -> String {
    let mut text = format!("{}\n", d.verdict.text);
    // Geometry and doubtful data have been told in the first lines.
    for w in d.warnings.iter().filter(|w| !w.contains(DOUBT) && !w.starts_with("warning: ")) {
        let _ = writeln!(text, "mind: {w}");
    }
    spots(&mut text, d);
    effects(&mut text, d);
    models(&mut text, d);
    for h in &d.held_out {
        let told = if h.informative { "" } else { ", whose size it does not determine" };
        let _ = writeln!(text, "\nheld out: {}: log score {:+.1}", h.split, 0.5 * h.score);
        let _ = writeln!(text, "  with {}, chosen by the fitted part alone{told}", list(&h.chosen));
        for p in &h.parts {
            let went = part_gone(p.shrinkage, p.interval)
                .map_or_else(|| "undefined".to_owned(), |part| format!("{part} gone"));
            let _ = writeln!(text, "  {:12} {:.3} -> {:.3} mN, {went}", p.part, p.before_mn, p.after_mn);
        }
    }
    if !d.next.is_empty() {
        let _ = writeln!(text, "\nwhat to measure next:");
        for p in &d.proposals {
            let _ = writeln!(text, "  {}", p.in_words());
        }
        for n in &d.next {
            let _ = writeln!(text, "  {n}");
        }
    }
    let _ = write!(text, "\n{:.0} s", d.seconds);
    text
}

fn spots(text: &mut String, d: &Diagnosis) {
    let _ = writeln!(
        text,
        "\nwhere (largest scores; noise alone passes {:.1} in 1 of 20 cases, and the largest of these and of the effects' with probability {:.2}):",
        d.location.threshold, d.location.probability
    );
    let mut spots: Vec<_> = d.location.spots.iter().collect();
    spots.sort_by(|a, b| b.score.abs().total_cmp(&a.score.abs()));
    for s in spots.iter().take(8) {
        let place = match (s.phase, s.time_s) {
            (Some(phase), _) => format!("cycle {}, {}, {}", s.cycle.unwrap_or(1), phase.name(), s.pattern),
            (None, Some(time_s)) => format!("holds, relaxation at {time_s} s"),
            (None, None) => s.pattern.clone(),
        };
        let _ = writeln!(text, "  {:6} {place:38} {:7.1}   {:8.3} mN", s.test, s.score, s.mean_mn);
    }
}

/// Effects as screening sees them; those that cannot be tested by name only.
fn effects(text: &mut String, d: &Diagnosis) {
    let row = |e: &&EffectSummary| {
        let refit = e.actual_gain.map_or_else(|| "-".to_owned(), |g| format!("{g:.1}"));
        let title = e.name.clone();
        let numbers = [format!("{:.1}", e.score), magnitude(e), refit];
        let hidden = [format!("{:.0} %", 100.0 * e.absorbed), format!("{:.1}", e.evidence)];
        [title].into_iter().chain(numbers).chain(hidden).collect::<Vec<String>>()
    };
    let header = ["which", "score", "magnitude", "refit", "hidden", "evidence"];
    // What was refitted all the same, or is part of the answer, has numbers, too.
    let is_shown =
        |e: &&EffectSummary| e.testable || e.actual_gain.is_some() || d.verdict.effects.contains(&e.name);
    let (shown, others): (Vec<&EffectSummary>, Vec<&EffectSummary>) = d.effects.iter().partition(is_shown);
    columns(text, header, &shown.iter().map(row).collect::<Vec<_>>());
    let names: Vec<&str> = others.iter().map(|e| e.name.as_str()).collect();
    if !names.is_empty() {
        let _ = writeln!(text, "not testable with these data: {}", names.join(", "));
    }
}

/// Magnitude in units of the effect's plausible scale, where the data say anything of it.
fn magnitude(e: &EffectSummary) -> String {
    // Beyond this the data do not tell the effect from none at any size that occurs.
    const UNKNOWN: f64 = 100.0;
    if e.magnitude_sigma < UNKNOWN {
        format!("{:.2} +- {:.2}", e.magnitude, e.magnitude_sigma)
    } else {
        "not determined".to_owned()
    }
}

fn models(text: &mut String, d: &Diagnosis) {
    if d.models.is_empty() {
        return;
    }
    let row = |name: String, numbers: [String; 4]| [name].into_iter().chain(numbers).collect::<Vec<String>>();
    let dash = || "-".to_owned();
    let plain = [
        format!("{:.1}", d.baseline.chi_square),
        "0.0".to_owned(),
        format!("{:.3}", d.baseline.adequacy),
        dash(),
    ];
    let mut rows = vec![row("plain model".to_owned(), plain)];
    for m in &d.models {
        let share = format!("{:.1} %", 100.0 * m.probability);
        let numbers = [
            format!("{:.1}", m.chi_square),
            format!("{:.1}", m.evidence),
            format!("{:.3}", m.adequacy),
            share,
        ];
        rows.push(row(m.effects.join(" + "), numbers));
    }
    let something = [dash(), format!("{:.1}", d.something_else_evidence), dash(), dash()];
    rows.push(row("something else".to_owned(), something));
    columns(text, ["refits", "chi^2", "evidence", "fits", "share"], &rows);
}
