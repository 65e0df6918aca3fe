//! The table of `batch`: one row per run, read twice - once to check every row, once to run them - so that its length
//! costs no memory but some bytes per row that has a name.

use super::exit::UsageError;
use crate::engine::Engine;
use crate::output::{check_no_device, protect};
use crate::setting::{number_in, variable_named};
use std::collections::{BTreeMap, HashSet};
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

/// Names of files that are there beside the runs' curves.
const RESERVED: [&str; 2] = ["summary", "cache"];

/// One row.
pub struct Set {
    /// Name of the run and of its curve's file.
    pub name: String,
    /// Values of the row's columns, in their order, in the FMU's units.
    pub values: Vec<(String, f64)>,
    line: u64,
}

/// The table, checked.
pub struct ParameterSets<'a> {
    file: PathBuf,
    engine: &'a Engine,
    columns: Vec<Column>,
    /// Number of rows.
    pub count: usize,
}

struct Column {
    name: String,
    unit: String,
}

impl<'a> ParameterSets<'a> {
    /// Reads the header and checks every row.
    ///
    /// # Errors
    /// When the file cannot be read; the first column or value that cannot be used; a name that two rows share.
    pub fn open(file: &Path, engine: &'a Engine) -> Result<Self, UsageError> {
        protect(file);
        let columns = columns(file, engine)?;
        let mut sets = Self { file: file.to_owned(), engine, columns, count: 0 };
        let mut names = HashSet::new();
        let has_names = sets.columns.iter().any(|c| c.name == "name");
        let mut count = 0;
        for set in sets.rows()? {
            let Set { name, line, .. } = set?;
            if RESERVED.contains(&name.to_lowercase().as_str()) {
                let why = format!("a run cannot be called `{name}`: batch writes that itself; rename it");
                return Err(at(file, line, &why));
            }
            let mut hasher = DefaultHasher::new();
            name.hash(&mut hasher);
            if has_names && !names.insert(hasher.finish()) {
                return Err(at(file, line, &format!("a second run is called `{name}`")));
            }
            count += 1;
        }
        sets.count = count;
        if count == 0 {
            return Err(UsageError(format!("{}: there is no parameter set in the file", file.display())));
        }
        Ok(sets)
    }

    /// Names of the parameters that the table sets, in the order of its columns.
    pub fn parameters(&self) -> Vec<&str> {
        self.columns.iter().map(|c| c.name.as_str()).filter(|name| *name != "name").collect()
    }

    /// The rows, one at a time.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn rows(&self) -> Result<impl Iterator<Item = Result<Set, UsageError>> + '_, UsageError> {
        let records = reader(&self.file)?.into_records();
        Ok(records.enumerate().map(|(index, record)| {
            let record = record.map_err(|e| unreadable(&self.file, &e))?;
            self.set(index, &record)
        }))
    }

    fn set(&self, index: usize, record: &csv::StringRecord) -> Result<Set, UsageError> {
        let line = record.position().map_or(0, csv::Position::line);
        let mut set = Set { name: format!("{:04}", index + 1), values: Vec::new(), line };
        for (Column { name, unit }, field) in self.columns.iter().zip(record) {
            if name == "name" {
                set.name = file_name(field);
                continue;
            }
            let value = variable_named(self.engine.wiring(), name)
                .and_then(|variable| number_in(variable, &format!("{field}{unit}")))
                .map_err(|e| at(&self.file, line, &e.to_string()))?;
            set.values.push((name.clone(), value));
        }
        if set.name.is_empty() {
            return Err(at(&self.file, line, "the run has no name"));
        }
        Ok(set)
    }
}

impl Set {
    /// Values of the row over those that all rows share.
    pub fn over(&self, common: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
        let mut all = common.clone();
        all.extend(self.values.iter().cloned());
        all
    }
}

fn columns(file: &Path, engine: &Engine) -> Result<Vec<Column>, UsageError> {
    let mut reader = reader(file)?;
    let header = reader.headers().map_err(|e| unreadable(file, &e))?;
    let line = header.position().map_or(1, csv::Position::line);
    let mut columns: Vec<Column> = Vec::new();
    for text in header.iter().map(|h| h.trim_start_matches('\u{feff}')) {
        // Parameter names hold brackets themselves: a unit is what follows a space.
        let (name, unit) = text.split_once([' ', '\t']).map_or((text, ""), |(n, u)| (n, u.trim()));
        let unit = unit.trim_matches(['[', ']', '(', ')']).to_owned();
        if name != "name" {
            variable_named(engine.wiring(), name).map_err(|e| at(file, line, &e.to_string()))?;
        }
        if columns.iter().any(|c| c.name == name) {
            return Err(at(file, line, &format!("`{name}` is there twice; keep one of the two")));
        }
        columns.push(Column { name: name.to_owned(), unit });
    }
    Ok(columns)
}

fn reader(file: &Path) -> Result<csv::Reader<File>, UsageError> {
    check_no_device(file).map_err(|e| UsageError(format!("{}: {e}", file.display())))?;
    let mut builder = csv::ReaderBuilder::new();
    builder.comment(Some(b'#')).trim(csv::Trim::All).from_path(file).map_err(|e| unreadable(file, &e))
}

fn unreadable(file: &Path, error: &csv::Error) -> UsageError {
    UsageError(format!("{}: {error}", file.display()))
}

fn at(file: &Path, line: u64, what: &str) -> UsageError {
    UsageError(format!("{}, line {line}: {what}", file.display()))
}

/// A name that is safe as a file name.
pub(super) fn file_name(text: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "-_.+".contains(c) { c } else { '_' };
    text.chars().map(safe).collect::<String>().trim_start_matches('.').to_owned()
}
