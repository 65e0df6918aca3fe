//! Numbers as laboratories write them: decimal point or comma, thousands in groups, clocks.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// What stands before the decimals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize)]
pub enum DecimalMark {
    /// `1.5`
    #[default]
    Point,
    /// `1,5`
    Comma,
}

/// A number; `None` for what is none.
pub fn number(field: &str, mark: DecimalMark) -> Option<f64> {
    let field = field.trim();
    let (decimal, group) = match mark {
        DecimalMark::Point => ('.', ','),
        DecimalMark::Comma => (',', '.'),
    };
    if !field.contains(['.', ',']) || (mark == DecimalMark::Point && !field.contains(',')) {
        return field.parse().ok();
    }
    let (whole, rest) = field.split_once(decimal).unwrap_or((field, ""));
    if rest.contains([decimal, group]) {
        return None;
    }
    let mut groups = whole.split(group);
    let first = groups.next().unwrap_or("");
    let mut later = 0;
    for digits in groups {
        later += 1;
        if digits.len() != 3 || !digits.bytes().all(|b| b.is_ascii_digit()) {
            return None;
        }
    }
    // `1,234.5` has its thousands in a group, `2,5` has not.
    let leading = first.trim_start_matches(['+', '-']);
    if later > 0 && (!(1..=3).contains(&leading.len()) || leading.starts_with('0')) {
        return None;
    }
    format!("{}.{rest}", whole.replace(group, "")).parse().ok()
}

/// What the numbers of some fields are written with; `None` where both readings are possible and differ.
pub fn decimal_mark<'a>(fields: impl Iterator<Item = &'a str> + Clone) -> Option<DecimalMark> {
    let reads = |mark| fields.clone().filter(|f| number(f, mark).is_some()).count();
    let (point, comma) = (reads(DecimalMark::Point), reads(DecimalMark::Comma));
    if point != comma {
        return Some(if point > comma { DecimalMark::Point } else { DecimalMark::Comma });
    }
    let same = fields.clone().all(|f| number(f, DecimalMark::Point) == number(f, DecimalMark::Comma));
    same.then_some(DecimalMark::Point)
}

/// Seconds of `h:m:s` or, where `short` says so, `m:s`; the last part may have decimals.
pub fn clock(field: &str, mark: DecimalMark, short: bool) -> Option<f64> {
    let parts: Vec<&str> = field.trim().split(':').collect();
    let (hours, minutes, seconds) = match parts[..] {
        [hours, minutes, seconds] => (hours, minutes, seconds),
        [minutes, seconds] if short => ("0", minutes, seconds),
        _ => return None,
    };
    let whole = |text: &str| text.parse::<u32>().ok();
    let seconds = number(seconds, mark).filter(|s| (0.0..60.0).contains(s))?;
    let (hours, minutes) = (whole(hours)?, whole(minutes)?);
    (minutes < 60 || short).then(|| f64::from(hours) * 3600.0 + f64::from(minutes) * 60.0 + seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_both_conventions() {
        use DecimalMark::{Comma, Point};
        for (text, mark, value) in [
            ("1.5", Point, Some(1.5)),
            ("-1,5", Comma, Some(-1.5)),
            ("1,234.5", Point, Some(1234.5)),
            ("1.234,5", Comma, Some(1234.5)),
            ("1,5E-3", Comma, Some(1.5e-3)),
            ("2,5", Point, None),
            ("1.5", Comma, None),
            ("12", Comma, Some(12.0)),
            ("1,2,3", Comma, None),
            ("1e-3", Point, Some(1e-3)),
            ("x", Point, None),
        ] {
            assert_eq!(number(text, mark), value, "{text} {mark:?}");
        }
    }

    #[test]
    fn the_mark_is_told_where_the_fields_tell_it() {
        let mark = |fields: &[&str]| decimal_mark(fields.iter().copied());
        assert_eq!(mark(&["1.5", "2"]), Some(DecimalMark::Point));
        assert_eq!(mark(&["1,5", "2"]), Some(DecimalMark::Comma));
        assert_eq!(mark(&["2,250", "1,250"]), None, "thousands, or decimals");
        assert_eq!(mark(&["0,250", "1,250"]), Some(DecimalMark::Comma));
        assert_eq!(mark(&["2,250", "-12,5"]), Some(DecimalMark::Comma));
        assert_eq!(mark(&["1", "2"]), Some(DecimalMark::Point));
    }

    #[test]
    fn clocks() {
        assert_eq!(clock("0:01:30.5", DecimalMark::Point, false), Some(90.5));
        assert_eq!(clock("01:30", DecimalMark::Point, true), Some(90.0));
        assert_eq!(clock("01:30", DecimalMark::Point, false), None);
        assert_eq!(clock("0:01:75", DecimalMark::Point, false), None);
    }
}
