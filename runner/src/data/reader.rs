//! Reads a measurement file; every complaint names file, line, column and remedy.

use super::error::{DataError, Problem};
use super::header::{Column, Quantity, read_column};
use super::measurement::Measurement;
use std::collections::BTreeMap;
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
const FEWEST_POINTS: usize = 5;

/// Reads a file.
///
/// # Errors
/// The first thing that is wrong, with file, line, column and remedy.
pub fn read(file: &Path, wanted: Wanted) -> Result<Measurement, DataError> {
    let fail = |problem| DataError { file: file.to_owned(), line: None, column: None, problem };
    let bytes = std::fs::read(file).map_err(|e| fail(Problem::Unreadable(e.to_string())))?;
    let text = String::from_utf8(bytes).map_err(|_| fail(Problem::NotText))?;
    read_str(&text, file, wanted)
}

/// Reads the text of a file; `file` is for names and messages only.
///
/// # Errors
/// As [`read`].
pub fn read_str(text: &str, file: &Path, wanted: Wanted) -> Result<Measurement, DataError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let fail = |line, column: Option<&str>, problem| DataError {
        file: file.to_owned(),
        line,
        column: column.map(str::to_owned),
        problem,
    };
    let header_line = text.lines().find(|l| !l.starts_with('#') && !l.trim().is_empty());
    let header_line = header_line.ok_or_else(|| fail(None, None, Problem::Empty))?;
    let delimiter = delimiter_of(header_line);
    let mut rows = csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let unreadable = |e: csv::Error| {
        let line = e.position().map(csv::Position::line);
        fail(line, None, Problem::Unreadable(e.to_string()))
    };

    let header = rows.headers().map_err(unreadable)?.clone();
    let header_at = header.position().map(csv::Position::line);
    if header.iter().all(|f| f.parse::<f64>().is_ok()) {
        return Err(fail(header_at, None, Problem::NoHeader));
    }
    let mut columns = Vec::with_capacity(header.len());
    for name in &header {
        columns.push(read_column(name).map_err(|p| fail(header_at, Some(name), p))?);
    }
    check_columns(&columns, wanted).map_err(|(c, p)| fail(header_at, c.as_deref(), p))?;

    let mut table = Table::default();
    for record in rows.records() {
        let record = record.map_err(unreadable)?;
        let line = record.position().map(csv::Position::line);
        if record.len() != columns.len() {
            let problem = Problem::FieldCount { found: record.len(), expected: columns.len() };
            return Err(fail(line, None, problem));
        }
        let mut row = Row { line: line.unwrap_or(0), ..Row::default() };
        for (field, column) in record.iter().zip(&columns) {
            row.take(field, column).map_err(|p| fail(line, Some(&column.name), p))?;
        }
        table.push(row).map_err(|(c, p)| fail(line, Some(c), p))?;
    }

    let mut notes: Vec<String> = columns.iter().filter_map(|c| c.note.clone()).collect();
    if delimiter != b',' {
        notes.push(format!("fields are separated by `{}`", char::from(delimiter).escape_default()));
    }
    let specimens = columns.iter().filter(|c| c.quantity == Quantity::SpecimenForce);
    let specimen_names = specimens.map(|c| c.name.clone()).collect();
    let comments = text.lines().filter_map(|l| l.strip_prefix('#')).map(|c| c.trim().to_owned());
    let name = file.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let described = Measurement {
        name,
        file: file.to_owned(),
        comments: comments.collect(),
        notes,
        specimen_names,
        ..Measurement::default()
    };
    let measurement = table.into_measurement(described).map_err(|p| fail(None, None, p))?;
    check_motion(&measurement).map_err(|p| fail(None, None, p))?;
    Ok(measurement)
}

/// One row in SI units.
#[derive(Debug, Default)]
struct Row {
    time: f64,
    displacement: f64,
    force: Option<f64>,
    std: Option<f64>,
    quartiles: (Option<f64>, Option<f64>),
    specimens: Vec<f64>,
    specimen: String,
    line: u64,
}

impl Row {
    fn take(&mut self, field: &str, column: &Column) -> Result<(), Problem> {
        if column.quantity == Quantity::Specimen {
            self.specimen = field.to_owned();
            return if field.is_empty() { Err(Problem::EmptyField) } else { Ok(()) };
        }
        if column.quantity == Quantity::Unused {
            return Ok(());
        }
        let value = number(field)? * column.factor;
        match column.quantity {
            Quantity::Time => self.time = value,
            Quantity::Displacement => self.displacement = value,
            Quantity::Force => self.force = Some(value),
            Quantity::ForceStd if value < 0.0 => return Err(Problem::NegativeSpread(value / column.factor)),
            Quantity::ForceStd => self.std = Some(value),
            Quantity::ForceQ25 => self.quartiles.0 = Some(value),
            Quantity::ForceQ75 => self.quartiles.1 = Some(value),
            Quantity::SpecimenForce => self.specimens.push(value),
            Quantity::Specimen | Quantity::Unused => {}
        }
        Ok(())
    }

    /// Standard deviation given, or from the quartiles of a normal distribution.
    fn spread(&self) -> Result<Option<f64>, Problem> {
        const QUARTILES_PER_DEVIATION: f64 = 1.348_979_5;
        match (self.std, self.quartiles) {
            (Some(std), _) => Ok(Some(std)),
            (None, (Some(q25), Some(q75))) if q75 < q25 => Err(Problem::NegativeSpread((q75 - q25) * 1e3)),
            (None, (Some(q25), Some(q75))) => Ok(Some((q75 - q25) / QUARTILES_PER_DEVIATION)),
            _ => Ok(None),
        }
    }
}

/// Rows by specimen (one nameless specimen when there is no such column).
#[derive(Debug, Default)]
struct Table {
    specimens: BTreeMap<String, Vec<Row>>,
}

impl Table {
    fn push(&mut self, row: Row) -> Result<(), (&'static str, Problem)> {
        row.spread().map_err(|p| ("force_q75", p))?;
        let rows = self.specimens.entry(row.specimen.clone()).or_default();
        if let Some(last) = rows.last().filter(|last| row.time <= last.time) {
            let (time_s, previous_s) = (row.time, last.time);
            return Err(("time", Problem::NonMonotonicTime { time_s, previous_s }));
        }
        rows.push(row);
        Ok(())
    }

    fn into_measurement(self, described: Measurement) -> Result<Measurement, Problem> {
        let mut groups = self.specimens.into_iter();
        let Some((first, rows)) = groups.next() else {
            return Err(Problem::TooFewPoints { found: 0, needed: FEWEST_POINTS });
        };
        let time_s: Vec<f64> = rows.iter().map(|r| r.time).collect();
        let displacement_m: Vec<f64> = rows.iter().map(|r| r.displacement).collect();
        let lines = rows.iter().map(|r| r.line).collect();
        let mut m = Measurement { time_s, displacement_m, lines, ..described };
        let groups: Vec<_> = groups.collect();
        if groups.is_empty() {
            let n = rows.first().map_or(0, |r| r.specimens.len());
            m.specimens_n = (0..n).map(|k| rows.iter().map(|r| r.specimens[k]).collect()).collect();
            m.force_n = rows.iter().filter_map(|r| r.force).collect();
            let spread: Vec<f64> = rows.iter().filter_map(|r| r.spread().ok().flatten()).collect();
            m.spread_n = (spread.len() == rows.len()).then_some(spread);
            let quartiles: Vec<_> = rows.iter().filter_map(|r| r.quartiles.0.zip(r.quartiles.1)).collect();
            m.quartiles_n = (quartiles.len() == rows.len()).then_some(quartiles);
        } else {
            m.specimens_n.push(rows.iter().filter_map(|r| r.force).collect());
            m.specimen_names.push(first.clone());
            for (specimen, rows) in groups {
                let same = rows.len() == m.len()
                    && rows
                        .iter()
                        .zip(m.time_s.iter().zip(&m.displacement_m))
                        .all(|(r, (t, d))| (r.time - t).abs() < 1e-9 && (r.displacement - d).abs() < 1e-7);
                if !same {
                    return Err(Problem::SpecimensDiffer { specimen, first });
                }
                m.specimens_n.push(rows.iter().filter_map(|r| r.force).collect());
                m.specimen_names.push(specimen);
            }
        }
        m.summarise_specimens();
        Ok(m)
    }
}

fn number(field: &str) -> Result<f64, Problem> {
    if field.is_empty() {
        return Err(Problem::EmptyField);
    }
    let value: f64 = field.parse().map_err(|_| Problem::NotANumber(field.to_owned()))?;
    if value.is_finite() { Ok(value) } else { Err(Problem::NotFinite(field.to_owned())) }
}

/// Comma, or what else the header is made of.
fn delimiter_of(header: &str) -> u8 {
    if header.contains(',') {
        b','
    } else if header.contains(';') {
        b';'
    } else if header.contains('\t') {
        b'\t'
    } else {
        b','
    }
}

fn check_columns(columns: &[Column], wanted: Wanted) -> Result<(), (Option<String>, Problem)> {
    use Quantity as Q;
    let find = |q: Quantity| columns.iter().find(|c| c.quantity == q);
    for (i, column) in columns.iter().enumerate() {
        let single = !matches!(column.quantity, Q::SpecimenForce | Q::Unused);
        let earlier = columns[..i].iter().find(|c| single && c.quantity == column.quantity);
        if let Some(first) = earlier {
            return Err((Some(column.name.clone()), Problem::DuplicateColumn(first.name.clone())));
        }
    }
    let missing = |what| Err((None, Problem::MissingColumn(what)));
    if find(Q::Time).is_none() {
        return missing("time");
    }
    if find(Q::Displacement).is_none() {
        return missing("displacement");
    }
    let force_known =
        find(Q::Force).is_some() || (find(Q::SpecimenForce).is_some() && find(Q::Specimen).is_none());
    if wanted == Wanted::MotionAndForce && !force_known {
        return missing("force");
    }
    match (find(Q::ForceQ25), find(Q::ForceQ75)) {
        (Some(_), None) => missing("upper quartile"),
        (None, Some(_)) => missing("lower quartile"),
        _ => Ok(()),
    }
}

fn check_motion(m: &Measurement) -> Result<(), Problem> {
    if m.len() < FEWEST_POINTS {
        return Err(Problem::TooFewPoints { found: m.len(), needed: FEWEST_POINTS });
    }
    if m.depth_m() <= 0.0 {
        return Err(Problem::NeverTouches { max_mm: m.depth_m() * 1e3 });
    }
    Ok(())
}

#[cfg(test)]
#[path = "reader_tests.rs"]
mod tests;
