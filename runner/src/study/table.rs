//! The table of a study: one row per specimen, or a folder of cases.

use super::StudyError;
use crate::data::source::from_directory;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

/// One row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Row {
    /// Specimen.
    pub specimen: String,
    /// Its measurements, as the command line takes them, from anywhere.
    pub files: Vec<PathBuf>,
    /// Its group.
    pub group: Option<String>,
    /// `NAME=VALUE` of each parameter that has a column.
    pub set: Vec<String>,
    /// All other columns.
    pub covariates: BTreeMap<String, String>,
    /// Line in the table, from 1.
    pub line: u64,
}

/// What a column means.
enum Column {
    Specimen,
    Files,
    Group,
    Parameter { name: String, unit: String },
    Covariate(String),
}

impl Column {
    fn of(header: &str) -> Self {
        match header.to_lowercase().as_str() {
            "specimen" => return Self::Specimen,
            "files" | "file" | "measurements" => return Self::Files,
            "group" => return Self::Group,
            _ => {}
        }
        let (name, unit) = header.split_once([' ', '\t']).map_or((header, ""), |(n, u)| (n, u.trim()));
        // Parameters' names have a dot, as `geometry.sample_height`.
        if name.contains('.') {
            let unit = unit.trim_matches(['[', ']', '(', ')']).to_owned();
            return Self::Parameter { name: name.to_owned(), unit };
        }
        Self::Covariate(header.to_owned())
    }
}

/// Reads the table: columns `specimen`, `files` (several are separated by `;`, paths from the table's directory), optionally
/// `group`, parameters (`geometry.sample_height [mm]`) and covariates.
///
/// # Errors
/// When it cannot be read, has no such columns, a field is empty that must not be, or a specimen is there twice.
pub fn read(file: &Path) -> Result<Vec<Row>, StudyError> {
    let file_error = |problem: String| StudyError::File { file: file.to_owned(), problem };
    let bytes = crate::output::read_input(file).map_err(StudyError::io(file))?;
    let mut builder = csv::ReaderBuilder::new();
    let mut reader = builder.comment(Some(b'#')).trim(csv::Trim::All).from_reader(bytes.as_slice());
    let header = reader.headers().map_err(|e| file_error(e.to_string()))?.clone();
    let columns: Vec<Column> =
        header.iter().map(|h| Column::of(h.trim_start_matches('\u{feff}').trim())).collect();
    for (what, is_it) in [
        ("specimen", columns.iter().any(|c| matches!(c, Column::Specimen))),
        ("files", columns.iter().any(|c| matches!(c, Column::Files))),
    ] {
        if !is_it {
            let found = header.iter().collect::<Vec<_>>().join(", ");
            return Err(file_error(format!(
                "there is no column `{what}` (there are {found}); the table needs `specimen` and `files`, separated by commas"
            )));
        }
    }
    let (mut rows, mut seen) = (Vec::new(), HashMap::new());
    for record in reader.records() {
        let record = record.map_err(|e| file_error(e.to_string()))?;
        let line = record.position().map_or(0, csv::Position::line);
        let row = row(file, &columns, &record, line)?;
        if let Some(first) = seen.insert(row.specimen.clone(), line) {
            let problem = format!("`specimen`: `{}` is in line {first}, too; rename one", row.specimen);
            return Err(StudyError::Line { file: file.to_owned(), line, problem });
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(file_error("there is no specimen in the table".to_owned()));
    }
    Ok(rows)
}

fn row(file: &Path, columns: &[Column], record: &csv::StringRecord, line: u64) -> Result<Row, StudyError> {
    let wrong = |problem: String| StudyError::Line { file: file.to_owned(), line, problem };
    let mut row = Row { line, ..Row::default() };
    for (column, field) in columns.iter().zip(record) {
        match column {
            Column::Specimen if field.is_empty() => {
                return Err(wrong("`specimen` is empty; name it".to_owned()));
            }
            Column::Specimen => row.specimen = field.to_owned(),
            Column::Files => {
                let parts = field.split(';').map(str::trim).filter(|p| !p.is_empty());
                let here = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
                row.files = parts.map(|p| PathBuf::from(from_directory(p, &here))).collect();
                if row.files.is_empty() {
                    return Err(wrong("`files` is empty; name the measurement, several with `;`".to_owned()));
                }
            }
            Column::Group => row.group = Some(field.to_owned()).filter(|g| !g.is_empty()),
            Column::Parameter { .. } if field.is_empty() => {}
            Column::Parameter { name, unit } => row.set.push(format!("{name}={field}{unit}")),
            Column::Covariate(name) if !field.is_empty() => {
                row.covariates.insert(name.clone(), field.to_owned());
            }
            Column::Covariate(_) => {}
        }
    }
    Ok(row)
}

/// Cases of a folder that `challenge make` wrote, in alphabetical order.
///
/// # Errors
/// When it holds none.
pub fn cases(folder: &Path) -> Result<Vec<Row>, StudyError> {
    let inside = folder.join("cases");
    let none = |problem: String| StudyError::File { file: inside.clone(), problem };
    let entries = std::fs::read_dir(&inside)
        .map_err(|e| none(format!("{e}; `challenge make` writes cases into such a folder")))?;
    let mut all: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(|p| p.is_dir()).collect();
    all.sort();
    if all.is_empty() {
        return Err(none("there is no case in it".to_owned()));
    }
    let row = |case: PathBuf| Row {
        specimen: case.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        files: ["P1.csv", "P2.csv"].map(|name| case.join(name)).to_vec(),
        ..Row::default()
    };
    Ok(all.into_iter().map(row).collect())
}

/// The table of `batch`, whose values the command checks itself.
#[derive(Debug)]
pub struct Sets {
    file: PathBuf,
    header: csv::StringRecord,
    rows: Vec<csv::StringRecord>,
}

impl Sets {
    /// Reads it.
    ///
    /// # Errors
    /// When it cannot be read or has no row.
    pub fn read(file: &Path) -> Result<Self, StudyError> {
        let problem = |problem: String| StudyError::File { file: file.to_owned(), problem };
        let failed = |e: csv::Error| problem(e.to_string());
        let mut builder = csv::ReaderBuilder::new();
        let mut reader = builder
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_path(file)
            .map_err(failed)?;
        let header = reader.headers().map_err(failed)?.clone();
        let rows = reader.records().collect::<Result<Vec<_>, _>>().map_err(failed)?;
        if rows.is_empty() {
            return Err(problem("there is no row in it".to_owned()));
        }
        Ok(Self { file: file.to_owned(), header, rows })
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.rows.len()
    }

    /// Rows, from 1, as a table of its own; each has the name that it has in the whole one.
    ///
    /// # Errors
    /// When there are no such rows (any more).
    pub fn chunk(&self, (first, last): (usize, usize)) -> Result<Vec<u8>, StudyError> {
        let rows = self.rows.get(first - 1..last);
        let rows = rows.ok_or_else(|| StudyError::Changed { file: self.file.clone() })?;
        let is_named = self.header.iter().any(|h| h.trim() == "name");
        let problem = |problem: String| StudyError::File { file: self.file.clone(), problem };
        let mut out = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
        let with = |name: String, record: &csv::StringRecord| -> Vec<String> {
            let name = Some(name).filter(|_| !is_named);
            name.into_iter().chain(record.iter().map(str::to_owned)).collect()
        };
        out.write_record(with("name".to_owned(), &self.header)).map_err(|e| problem(e.to_string()))?;
        for (k, record) in rows.iter().enumerate() {
            let name = format!("{:04}", first + k);
            out.write_record(with(name, record)).map_err(|e| problem(e.to_string()))?;
        }
        out.into_inner().map_err(|e| problem(e.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<Vec<Row>, StudyError> {
        let d = tempfile::tempdir().unwrap();
        let file = d.path().join("specimens.csv");
        std::fs::write(&file, text).unwrap();
        let mut rows = read(&file)?;
        for path in rows.iter_mut().flat_map(|r| &mut r.files) {
            *path = path.strip_prefix(d.path()).unwrap_or(path).to_owned();
        }
        Ok(rows)
    }

    #[test]
    fn columns_are_files_groups_parameters_and_covariates() {
        let text = "specimen,files,group,geometry.sample_height [mm],age [d]\n\
                    # a note\na,a/P1.csv; a/P2.csv,young,5.1,12\nb,b.csv,,,\n";
        let rows = table(text).unwrap();
        assert_eq!(rows[0].files, [PathBuf::from("a/P1.csv"), PathBuf::from("a/P2.csv")]);
        assert_eq!(rows[0].set, ["geometry.sample_height=5.1mm"]);
        assert_eq!(rows[0].group.as_deref(), Some("young"));
        assert_eq!(rows[0].covariates["age [d]"], "12");
        assert_eq!((rows[1].line, &rows[1].group, rows[1].set.len()), (4, &None, 0));
    }

    #[test]
    fn what_is_wrong_is_told_with_line_field_and_remedy() {
        for (text, parts) in [
            ("specimen,group\na,b\n", ["no column `files`", "specimen, group"]),
            ("specimen,files\na,x.csv\na,y.csv\n", ["line 3", "is in line 2, too; rename"]),
            ("specimen,files\na,\n", ["line 2", "`files` is empty"]),
            ("specimen,files\n,x\n", ["line 2", "`specimen` is empty"]),
            ("specimen,files\n", ["no specimen", "specimens.csv"]),
        ] {
            let error = table(text).unwrap_err().to_string();
            assert!(parts.iter().all(|p| error.contains(p)), "{text}: {error}");
        }
    }

    #[test]
    fn chunks_are_tables_with_the_names_of_the_whole() {
        let d = tempfile::tempdir().unwrap();
        let file = d.path().join("sets.csv");
        std::fs::write(&file, "material.n0s\n0.1\n0.2\n0.3\n").unwrap();
        let sets = Sets::read(&file).unwrap();
        assert_eq!(sets.count(), 3);
        assert_eq!(sets.chunk((2, 3)).unwrap(), b"name,material.n0s\n0002,0.2\n0003,0.3\n");
        assert!(sets.chunk((3, 4)).is_err());
    }
}
