//! Where the table is in a file: behind which preamble, under which names and units, with which separator.

use super::header::read_column;
use super::names::{is_unit, meaning};
use super::number::{DecimalMark, decimal_mark, number};
use super::reading::Reading;

/// A table that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Line of the names, from 1.
    pub header_line: u64,
    /// Names of the columns.
    pub names: Vec<String>,
    /// The row of units under them.
    pub units: Option<Vec<String>>,
    /// What separates fields.
    pub delimiter: u8,
    /// What stands before the decimals; `None` where it cannot be told.
    pub decimal: Option<DecimalMark>,
    /// Lines before the first row of numbers.
    pub skip: usize,
    /// What was found that is not obvious.
    pub notes: Vec<String>,
}

/// A preamble is looked through this far.
const LONGEST_PREAMBLE: usize = 2000;
/// Rows that tell the decimal mark.
const SAMPLE: usize = 500;
const DELIMITERS: [u8; 3] = [b'\t', b';', b','];

/// Finds the table; `None` where there is no line that could be a header.
pub fn find(text: &str, reading: &Reading) -> Option<Layout> {
    let lines: Vec<&str> = text.lines().collect();
    let is_text = |line: &str| !line.starts_with('#') && !line.trim().is_empty();
    let first = lines.iter().position(|l| is_text(l))?;
    let candidates = || (first..lines.len().min(first + LONGEST_PREAMBLE)).filter(|&i| is_text(lines[i]));
    let scored = |i: usize| {
        let score = |d: &u8| (named(&split(lines[i], *d), reading), split(lines[i], *d).len());
        // Of equals the last: a comma where nothing else is known.
        DELIMITERS.iter().copied().max_by_key(score).map(|d| (score(&d).0, d))
    };
    // Names that are understood; a line of prose may hold a word that is one, so numbers must follow.
    let named_at = candidates().find_map(|i| {
        let (score, delimiter) = scored(i).filter(|(score, _)| *score >= 2)?;
        let follows = lines[i + 1..].iter().filter(|l| is_text(l)).take(2);
        let numeric = i == first
            || follows.into_iter().any(|l| is_numeric(l, delimiter, split(lines[i], delimiter).len()));
        (score >= 2 && numeric).then_some((i, delimiter))
    });
    // Otherwise what stands right above the first three rows of numbers.
    let above_numbers = || {
        DELIMITERS.iter().find_map(|&delimiter| {
            let rows = candidates().filter(|&i| i + 2 < lines.len());
            let start = rows.into_iter().find(|&i| {
                let width = split(lines[i], delimiter).len();
                width > 1 && lines[i..i + 3].iter().all(|l| is_numeric(l, delimiter, width))
            })?;
            let width = split(lines[start], delimiter).len();
            let above: Vec<usize> = (first..start)
                .rev()
                .filter(|&i| is_text(lines[i]))
                .take(2)
                .filter(|&i| split(lines[i], delimiter).len() == width)
                .collect();
            let header = match above[..] {
                [units, names]
                    if split(lines[units], delimiter).iter().all(|c| c.is_empty() || is_unit(c)) =>
                {
                    names
                }
                [names, ..] => names,
                [] => start,
            };
            Some((header, delimiter))
        })
    };
    let fallback = || {
        (first, DELIMITERS.iter().copied().find(|d| lines[first].contains(char::from(*d))).unwrap_or(b','))
    };
    let (header, delimiter) = named_at.or_else(above_numbers).unwrap_or_else(fallback);
    Some(layout(&lines, first, header, delimiter, reading))
}

fn layout(lines: &[&str], first: usize, header: usize, delimiter: u8, reading: &Reading) -> Layout {
    let names = split(lines[header], delimiter);
    let mut notes = Vec::new();
    if header > first {
        notes.push(format!("lines {} to {header} before the table are not used", first + 1));
    }
    let below =
        (header + 1..lines.len()).find(|&i| !lines[i].trim().is_empty() && !lines[i].starts_with('#'));
    let units = below.map(|i| split(lines[i], delimiter)).filter(|cells| is_unit_row(cells, names.len()));
    let skip = match (&units, below) {
        (Some(_), Some(i)) => i + 1,
        _ if names
            .iter()
            .all(|n| number(n, DecimalMark::Point).or(number(n, DecimalMark::Comma)).is_some()) =>
        {
            header
        }
        _ => header + 1,
    };
    if delimiter != b',' {
        notes.push(format!("fields are separated by `{}`", char::from(delimiter).escape_default()));
    }
    let rows: Vec<Vec<String>> = lines[skip.min(lines.len())..]
        .iter()
        .filter(|l| !l.trim().is_empty() && !l.starts_with('#'))
        .take(SAMPLE)
        .map(|l| split(l, delimiter))
        .collect();
    let fields = rows.iter().flatten().map(String::as_str).filter(|f| f.contains(['.', ',']));
    let decimal = reading.decimal.or_else(|| decimal_mark(fields));
    if decimal == Some(DecimalMark::Comma) {
        notes.push("numbers have decimal commas".to_owned());
    }
    Layout { header_line: header as u64 + 1, names, units, delimiter, decimal, skip, notes }
}

/// Fields of one line.
pub fn split(line: &str, delimiter: u8) -> Vec<String> {
    let mut fields = if line.contains('"') {
        quoted(line, delimiter)
    } else if line.is_empty() {
        vec![]
    } else {
        line.split(char::from(delimiter)).map(|f| f.trim().to_owned()).collect()
    };
    // A separator at the end of every line makes no column.
    if fields.len() > 1 && fields.last().is_some_and(String::is_empty) {
        fields.pop();
    }
    fields
}

/// Fields of a line with quotes in it.
fn quoted(line: &str, delimiter: u8) -> Vec<String> {
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(line.as_bytes());
    let record = reader.records().next().and_then(Result::ok).unwrap_or_default();
    record.iter().map(str::to_owned).collect()
}

/// How many of the fields are names of columns.
fn named(fields: &[String], reading: &Reading) -> usize {
    let chosen = |f: &String| reading.columns.iter().any(|c| c.name.eq_ignore_ascii_case(f));
    fields.iter().filter(|f| chosen(f) || meaning(f).is_some() || read_column(f).is_ok()).count()
}

fn is_numeric(line: &str, delimiter: u8, width: usize) -> bool {
    let fields = split(line, delimiter);
    let is_number = |f: &&String| {
        number(f, DecimalMark::Point).is_some()
            || number(f, DecimalMark::Comma).is_some()
            || super::number::clock(f, DecimalMark::Point, true).is_some()
    };
    // Some columns hold words; a row of units is as good as a row of numbers.
    fields.len() == width
        && (fields.iter().filter(is_number).count() >= 2.min(width) || is_unit_row(&fields, width))
}

fn is_unit_row(fields: &[String], width: usize) -> bool {
    let filled: Vec<&String> = fields.iter().filter(|f| !f.is_empty()).collect();
    fields.len() <= width
        && filled.len() >= 2
        && filled.iter().filter(|f| is_unit(f)).count() >= 2
        && filled.iter().all(|f| number(f, DecimalMark::Point).is_none())
}
