//! The statistics in words that an experimenter reads.

use super::derived::DerivedEstimate;
use super::identifiability::{Finding, FindingKind};
use super::resolution::{Resolution, ResolvedBranch, Standing};
use super::statistics::{Determination, Statistics};

/// A half-width in ln(value) as people say it: `4 %`, `a factor of 2.3`, `many orders of magnitude`.
pub fn spread(half_width: f64) -> String {
    let percent = 100.0 * half_width;
    if percent < 0.1 {
        "0.1 %".to_owned()
    } else if percent < 1.0 {
        format!("{percent:.1} %")
    } else if half_width < 0.4 {
        format!("{percent:.0} %")
    } else if half_width < 10f64.ln() {
        format!("a factor of {:.1}", half_width.exp())
    } else if half_width < 1e4f64.ln() {
        format!("a factor of {}", significant(half_width.exp(), 1))
    } else {
        "many orders of magnitude".to_owned()
    }
}

/// A number with `digits` significant digits, plain between 1e-3 and 1e5, in powers of ten beyond.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    // Round first: 9.996 has one digit more before the point than its logarithm says.
    let rounded: f64 = format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value);
    let exponent = rounded.abs().log10().floor() as i32;
    if (-3..5).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        format!("{rounded:.decimals$}")
    } else {
        format!("{rounded:.*e}", digits.saturating_sub(1))
    }
}

/// A number with `digits` digits after the point; what is rounded to nothing has no sign.
pub fn fixed(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(size) if size.chars().all(|c| matches!(c, '0' | '.')) => size.to_owned(),
        _ => text,
    }
}

/// A part of a whole in per cent, without the sign `%`.
pub fn whole_percent(part: f64) -> String {
    fixed(100.0 * part, 0)
}

/// `a`, `a and b`, `a, b and c`.
pub fn list<S: AsRef<str>>(items: &[S]) -> String {
    match items {
        [] => String::new(),
        [one] => one.as_ref().to_owned(),
        [start @ .., last] => {
            let start: Vec<_> = start.iter().map(AsRef::as_ref).collect();
            format!("{} and {}", start.join(", "), last.as_ref())
        }
    }
}

/// What a finding means, of parameters of which those that are `open` are not determined by themselves.
pub(super) fn finding(
    finding: &Finding,
    symbols: &[&str],
    open: &[&str],
    known: Option<&DerivedEstimate>,
) -> String {
    let names = list(symbols);
    match finding.kind {
        FindingKind::Invisible => format!(
            "{names} is invisible in these data: a factor of ten changes the force by {} of the noise (rms), \
             too little to be seen",
            significant(finding.decade_change, 2)
        ),
        FindingKind::Loose => {
            format!(
                "{names} is known only to within {} either way: a factor of ten changes the force by {} times \
                 the noise (rms), part of which the other parameters make up for",
                spread(finding.half_width),
                significant(finding.decade_change, 2)
            )
        }
        FindingKind::TradeOff => trade_off(finding, symbols, open, known),
    }
}

fn trade_off(finding: &Finding, symbols: &[&str], open: &[&str], known: Option<&DerivedEstimate>) -> String {
    let names = list(symbols);
    let correlation = finding.correlation.map_or(String::new(), |c| format!(" (correlation {c:.4})"));
    let (whose, is) = match open {
        _ if open.len() == symbols.len() => ("each".to_owned(), "is"),
        [one] => ((*one).to_owned(), "is"),
        _ => (list(open), "are"),
    };
    let alone = match Determination::of(finding.half_width) {
        Determination::Undetermined => format!("{whose} alone {is} not determined"),
        _ => format!("{whose} alone only to {}", spread(finding.half_width)),
    };
    if let Some(known) = known {
        return format!(
            "{names} enter almost only as {} = {}{correlation}: this is known to {}, {alone}",
            known.symbol,
            known.formula,
            spread(known.half_width)
        );
    }
    if let ([a, b], [da, db]) = (symbols, &finding.direction[..]) {
        // Orthogonal to (da, db) in log parameters: a^1 b^(-da/db) stays the same.
        let exponent = -da / db;
        let combination = match exponent {
            e if (e - 1.0).abs() < 0.05 => format!("the product {a} {b}"),
            e if (e + 1.0).abs() < 0.05 => format!("the ratio {a} / {b}"),
            e => format!("{a} {b}^{e:.2}"),
        };
        return format!("{names} enter almost only as {combination}{correlation}: {alone}");
    }
    let moves: Vec<String> =
        symbols.iter().zip(&finding.direction).map(|(s, d)| format!("{s} x {:.2}", d.exp())).collect();
    format!("{names} trade off against each other ({} changes almost nothing): {alone}", moves.join(", "))
}

/// What is known, e.g. `G_inf = 234 Pa to 3 %`: combinations first, then the parameters that no finding names.
pub(super) fn determined(
    statistics: &Statistics,
    derived: &[DerivedEstimate],
    unnamed: impl Fn(&str) -> bool,
) -> Vec<String> {
    let combinations = derived.iter().filter(|d| d.determination == Determination::Determined).map(|d| {
        let scope = statistics.resolution.scope_s(&d.name).map_or(String::new(), scope);
        known(&d.symbol, d.unit.from_si(d.value), &d.unit.name, d.half_width) + &scope
    });
    let parameters = statistics
        .estimates
        .iter()
        .filter(|e| e.determination == Determination::Determined && e.at_bound.is_none())
        .filter(|e| unnamed(&e.parameter.name))
        .map(|e| {
            let p = &e.parameter;
            known(&p.symbol, p.unit.from_si(e.value), &p.unit.name, e.half_width)
        });
    combinations.chain(parameters).collect()
}

/// What a modulus stands for.
fn scope([from_s, to_s]: [f64; 2]) -> String {
    let from = significant(from_s, 2);
    if to_s.is_finite() {
        format!(" (of all that relaxes within {from} to {} s)", significant(to_s, 2))
    } else {
        format!(" (of all that relaxes slower than {from} s)")
    }
}

/// What the data do not tell of the branches.
pub(super) fn unresolved(resolution: &Resolution) -> Vec<String> {
    let pair = |[a, b]: [&ResolvedBranch; 2]| {
        format!(
            "branches {0} and {1} are too close ({2}) for this noise to be told apart (two must be {3} apart): only their sum \
             G_{0} + G_{1} is known",
            a.label,
            b.label,
            spread((b.tau_s / a.tau_s).ln()),
            spread(a.factor.min(b.factor).ln())
        )
    };
    let slow = |b: &ResolvedBranch| {
        format!(
            "branch {0} (tau_{0} = {1} s) is slower than the longest hold ({2} s): what of G_{0} and G_inf would relax after it is \
             not in these data",
            b.label,
            significant(b.tau_s, 3),
            significant(resolution.hold_s, 3)
        )
    };
    let is_slow = |b: &&ResolvedBranch| b.standing == Standing::Slow;
    resolution.close_pairs().map(pair).chain(resolution.branches.iter().filter(is_slow).map(slow)).collect()
}

fn known(symbol: &str, value: f64, unit: &str, half_width: f64) -> String {
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    format!("{symbol} = {}{unit} to {}", significant(value, 3), spread(half_width))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_read_well() {
        for (half_width, text) in [
            (1e-5, "0.1 %"),
            (0.0042, "0.4 %"),
            (0.031, "3 %"),
            (0.7, "a factor of 2.0"),
            (5.0, "a factor of 100"),
            (40.0, "many orders of magnitude"),
        ] {
            assert_eq!(spread(half_width), text);
        }
    }

    #[test]
    fn significant_digits_survive_rounding_up() {
        for (value, digits, text) in [
            (9.996, 3, "10.0"),
            (0.018, 3, "0.0180"),
            (-216.9, 3, "-217"),
            (2.3e-9, 3, "2.30e-9"),
            (123456.0, 3, "1.23e5"),
            (99999.9, 3, "1.00e5"),
            (4680.0, 3, "4680"),
        ] {
            assert_eq!(significant(value, digits), text);
        }
    }

    #[test]
    fn nothing_has_no_sign() {
        assert_eq!([-0.004, 0.004, -0.006, 0.996].map(whole_percent), ["0", "0", "-1", "100"]);
        assert_eq!([-0.0004, -0.0006, 0.0].map(|value| fixed(value, 3)), ["0.000", "-0.001", "0.000"]);
    }

    #[test]
    fn lists_read_well() {
        assert_eq!(list(&["a"]), "a");
        assert_eq!(list(&["a", "b", "c"]), "a, b and c");
    }
}
