//! Reads a measurement file; every complaint names file, line, column and remedy.

use super::columns::{Columns, decimal_question, resolve};
use super::coordinate::{Own, settle};
use super::encoding::decode;
use super::error::{DataError, Problem, Question};
use super::header::{Column, Quantity};
use super::layout::{Layout, find, split};
use super::measurement::Measurement;
use super::number::{DecimalMark, clock, number};
use super::plausibility::{self, is_absurd, is_sentinel};
use super::reading::Reading;
use super::table::{Row, Table};
use std::path::Path;

/// What the caller needs from the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// Time and displacement only.
    Motion,
    /// Time, displacement and force.
    MotionAndForce,
}

/// Fewest points that make a curve.
pub(super) const FEWEST_POINTS: usize = 5;

/// Reads a file that says everything itself.
///
/// # Errors
/// The first thing that is wrong, with file, line, column and remedy.
pub fn read(file: &Path, wanted: Wanted) -> Result<Measurement, DataError> {
    read_as(file, wanted, &Reading::default())
}

/// Reads a file with what the user says about it.
///
/// # Errors
/// As [`read`]; what is left open is asked all at once.
pub fn read_as(file: &Path, wanted: Wanted, reading: &Reading) -> Result<Measurement, DataError> {
    let fail = |problem| DataError { file: file.to_owned(), line: None, column: None, problem };
    let bytes = crate::output::read_input(file).map_err(|e| fail(Problem::Unreadable(e.to_string())))?;
    let (text, note) = decode(&bytes).map_err(fail)?;
    let mut measurement = read_text(&text, file, wanted, reading)?;
    measurement.notes.extend(note);
    Ok(measurement)
}

/// Reads the text of a file that says everything itself; `file` is for names and messages only.
///
/// # Errors
/// As [`read`].
pub fn read_str(text: &str, file: &Path, wanted: Wanted) -> Result<Measurement, DataError> {
    read_text(text, file, wanted, &Reading::default())
}

/// Reads the text of a file with what the user says about it.
///
/// # Errors
/// As [`read_as`].
pub fn read_text(
    text: &str,
    file: &Path,
    wanted: Wanted,
    reading: &Reading,
) -> Result<Measurement, DataError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let fail = |line, column: Option<&str>, problem| DataError {
        file: file.to_owned(),
        line,
        column: column.map(str::to_owned),
        problem,
    };
    let layout = find(text, reading).ok_or_else(|| fail(None, None, Problem::Empty))?;
    let header_at = Some(layout.header_line);
    let is_number = |n: &String| number(n, DecimalMark::Point).or(number(n, DecimalMark::Comma)).is_some();
    let by_number = reading.columns.iter().any(|c| c.name.parse::<usize>().is_ok());
    if layout.names.iter().all(is_number) && !by_number {
        return Err(fail(header_at, None, Problem::NoHeader));
    }
    let force = wanted == Wanted::MotionAndForce;
    let columns = resolve(&layout, reading, force).map_err(|(c, p)| fail(header_at, c.as_deref(), p))?;
    check_quartiles(&columns.all).map_err(|p| fail(header_at, None, p))?;
    let mut questions = columns.questions.clone();
    questions.extend(decimal_question(layout.decimal));
    let described = described(text, file, &layout, &columns);
    // Where a column is open the rows cannot be read; sign, zero and tare are asked with what is known.
    if !questions.is_empty() {
        let mut assumed = reading.clone();
        questions.iter().for_each(|q| q.assume(&mut assumed));
        if assumed != *reading
            && let Err(DataError { problem: Problem::Unclear(more), .. }) =
                read_text(text, file, wanted, &assumed)
        {
            let new = more.into_iter().filter(|q| !questions.iter().any(|p| p.answer == q.answer));
            questions.extend(new.collect::<Vec<_>>());
        }
        let single = open_column(&columns, &layout, wanted);
        return Err(match single {
            Some((name, problem)) if questions.len() == 1 => fail(header_at, name.as_deref(), problem),
            _ => fail(None, None, Problem::Unclear(questions)),
        });
    }
    let table = rows(text, &layout, &columns).map_err(|(line, c, p)| fail(Some(line), c.as_deref(), p))?;
    let mut measurement = table.into_measurement(described).map_err(|p| fail(None, None, p))?;
    if measurement.len() < FEWEST_POINTS {
        let found = measurement.len();
        return Err(fail(None, None, Problem::TooFewPoints { found, needed: FEWEST_POINTS }));
    }
    plausibility::check_specimens(&measurement).map_err(|p| fail(None, None, p))?;
    let questions = if measurement.force_n.len() == measurement.len() {
        settle(&mut measurement, own(&columns), reading)
    } else {
        settle_motion(&mut measurement, reading)
    };
    if !questions.is_empty() {
        return Err(fail(None, None, Problem::Unclear(questions)));
    }
    if measurement.depth_m() <= 0.0 {
        let max_mm = measurement.depth_m() * 1e3;
        return Err(fail(None, None, Problem::NeverTouches { max_mm }));
    }
    let found = plausibility::warnings(&measurement);
    measurement.warnings.extend(found);
    Ok(measurement)
}

/// A motion without force: only what the user says can be done to it.
fn settle_motion(m: &mut Measurement, reading: &Reading) -> Vec<Question> {
    let force = vec![0.0; m.len()];
    let kept = std::mem::replace(&mut m.force_n, force);
    let reading = Reading { tare: None, ..reading.clone() };
    let questions = settle(m, Own { displacement: true, force: true }, &reading);
    m.force_n = kept;
    questions
}

/// The one thing that is open, as a complaint of its own.
fn open_column(columns: &Columns, layout: &Layout, wanted: Wanted) -> Option<(Option<String>, Problem)> {
    let has = |q: Quantity| columns.all.iter().any(|c| c.quantity == q);
    let wants_force = wanted == Wanted::MotionAndForce;
    let missing = [
        (Quantity::Time, "time", "time_s"),
        (Quantity::Displacement, "displacement", "displacement_mm"),
        (Quantity::Force, "force", "force_mN"),
    ];
    let (.., what, example) =
        *missing.iter().find(|(q, ..)| !has(*q) && (*q != Quantity::Force || wants_force))?;
    let without_unit = layout.names.iter().find(|n| n.eq_ignore_ascii_case(what));
    match without_unit {
        Some(name) => Some((Some(name.clone()), Problem::MissingUnit { example })),
        None if columns.unused.len() == 1 && layout.units.is_none() => {
            Some((Some(columns.unused[0].clone()), Problem::UnknownInstead(what)))
        }
        None if columns.unused.is_empty() => Some((None, Problem::MissingColumn(what))),
        None => None,
    }
}

fn own(columns: &Columns) -> Own {
    let is_own = |q: Quantity| columns.all.iter().find(|c| c.quantity == q).is_none_or(|c| c.own);
    Own { displacement: is_own(Quantity::Displacement), force: is_own(Quantity::Force) }
}

/// The measurement without its rows.
fn described(text: &str, file: &Path, layout: &Layout, columns: &Columns) -> Measurement {
    let mut notes: Vec<String> = columns.all.iter().filter_map(|c| c.note.clone()).collect();
    notes.extend(layout.notes.iter().cloned());
    if !columns.unused.is_empty() {
        notes.push(format!("columns that are not used: {}", columns.unused.join(", ")));
    }
    let specimens = columns.all.iter().filter(|c| c.quantity == Quantity::SpecimenForce);
    Measurement {
        name: file.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned()),
        file: file.to_owned(),
        comments: text.lines().filter_map(|l| l.strip_prefix('#')).map(|c| c.trim().to_owned()).collect(),
        notes,
        specimen_names: specimens.map(|c| c.name.clone()).collect(),
        ..Measurement::default()
    }
}

type RowFailure = (u64, Option<String>, Problem);

/// The rows under the header, in SI.
fn rows(text: &str, layout: &Layout, columns: &Columns) -> Result<Table, RowFailure> {
    let start: usize = text.split_inclusive('\n').take(layout.skip).map(str::len).sum();
    let mut records = csv::ReaderBuilder::new()
        .delimiter(layout.delimiter)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .has_headers(false)
        .from_reader(&text.as_bytes()[start..]);
    let line_of =
        |position: Option<&csv::Position>| position.map_or(0, csv::Position::line) + layout.skip as u64;
    let mark = layout.decimal.unwrap_or_default();
    let mut table = Table::default();
    let mut before: Vec<Option<f64>> = vec![None; columns.all.len()];
    for record in records.records() {
        let record = record.map_err(|e| (line_of(e.position()), None, Problem::Unreadable(e.to_string())))?;
        let line = line_of(record.position());
        if record.iter().all(str::is_empty) {
            continue;
        }
        // A separator at the end of every line makes no column.
        let found = record.len()
            - usize::from(record.len() == columns.all.len() + 1 && record.iter().next_back() == Some(""));
        if found != columns.all.len() {
            if table.has_rows() && is_epilogue(&text[start..], line - layout.skip as u64, layout.delimiter) {
                break;
            }
            return Err((line, None, Problem::FieldCount { found, expected: columns.all.len() }));
        }
        let mut row = Row::at(line);
        for ((field, column), before) in record.iter().zip(&columns.all).zip(&mut before) {
            take(&mut row, field, column, mark, before).map_err(|p| (line, Some(column.name.clone()), p))?;
        }
        table.push(row).map_err(|(c, p)| (line, Some(c.to_owned()), p))?;
    }
    Ok(table)
}

/// Whether no line from a line on (counted from 1) holds a number: what some programs write behind the table.
fn is_epilogue(text: &str, line: u64, delimiter: u8) -> bool {
    let first = usize::try_from(line).unwrap_or(1).saturating_sub(1);
    let is_number = |f: &String| number(f, DecimalMark::Point).or(number(f, DecimalMark::Comma)).is_some();
    text.lines().skip(first).all(|line| !split(line, delimiter).iter().any(is_number))
}

/// Reads one field into its row.
fn take(
    row: &mut Row,
    field: &str,
    column: &Column,
    mark: DecimalMark,
    before: &mut Option<f64>,
) -> Result<(), Problem> {
    match column.quantity {
        Quantity::Unused => return Ok(()),
        _ if field.is_empty() => return Err(Problem::EmptyField),
        Quantity::Specimen => {
            field.clone_into(&mut row.specimen);
            return Ok(());
        }
        _ => {}
    }
    let written = match column.clock {
        Some(short) => clock(field, mark, short),
        None => number(field, mark),
    };
    let written = written.ok_or_else(|| Problem::NotANumber(field.to_owned()))?;
    if !written.is_finite() {
        return Err(Problem::NotFinite(field.to_owned()));
    }
    if is_sentinel(written, *before) {
        return Err(Problem::Sentinel(field.to_owned()));
    }
    *before = Some(written);
    let value = written * column.factor;
    let kind = match column.quantity {
        Quantity::Time => 0,
        Quantity::Displacement => 1,
        _ => 2,
    };
    if is_absurd(value, kind) {
        return Err(Problem::Absurd(field.to_owned()));
    }
    row.set(column, value)
}

fn check_quartiles(columns: &[Column]) -> Result<(), Problem> {
    let has = |q: Quantity| columns.iter().any(|c| c.quantity == q);
    match (has(Quantity::ForceQ25), has(Quantity::ForceQ75)) {
        (true, false) => Err(Problem::MissingColumn("upper quartile")),
        (false, true) => Err(Problem::MissingColumn("lower quartile")),
        _ => Ok(()),
    }
}

#[cfg(test)]
#[path = "reader_tests.rs"]
mod tests;
