//! A table of named columns, written as CSV and as Parquet.

use super::StudyError;
use crate::output::mark;
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

/// Values of a column.
#[derive(Debug, Clone, PartialEq)]
enum Column {
    Text(Vec<String>),
    Number(Vec<Option<f64>>),
}

/// Columns of one length, in their order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Frame {
    columns: Vec<(String, Column)>,
}

impl Frame {
    /// Adds a column of words.
    pub fn text(&mut self, name: impl Into<String>, values: impl Iterator<Item = String>) {
        self.columns.push((name.into(), Column::Text(values.collect())));
    }

    /// Adds a column of numbers; what is missing stays empty.
    pub fn number(&mut self, name: impl Into<String>, values: impl Iterator<Item = Option<f64>>) {
        self.columns.push((name.into(), Column::Number(values.collect())));
    }

    /// Adds a column of somebody else's table: numbers where [`are_numbers`] says so of all its cells.
    pub fn either(&mut self, name: impl Into<String>, values: impl Iterator<Item = String>, numbers: bool) {
        if numbers {
            self.number(name, values.map(|cell| cell.trim().parse().ok()));
        } else {
            self.text(name, values);
        }
    }

    /// Reads a CSV text with a header.
    ///
    /// # Errors
    /// When it is none.
    pub fn of_csv(text: &str, file: &Path) -> Result<Self, StudyError> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let failed = |e: csv::Error| StudyError::File { file: file.to_owned(), problem: e.to_string() };
        let names: Vec<String> = reader.headers().map_err(failed)?.iter().map(str::to_owned).collect();
        let mut cells = vec![Vec::new(); names.len()];
        for record in reader.records() {
            let record = record.map_err(failed)?;
            cells.iter_mut().zip(&record).for_each(|(column, cell)| column.push(cell.to_owned()));
        }
        let mut frame = Self::default();
        for (name, cells) in names.into_iter().zip(cells) {
            let numbers = are_numbers(cells.iter().map(String::as_str));
            frame.either(name, cells.into_iter(), numbers);
        }
        Ok(frame)
    }

    fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| match column {
            Column::Text(values) => values.len(),
            Column::Number(values) => values.len(),
        })
    }

    fn columns(&self) -> Result<Vec<Arc<Type>>, ParquetError> {
        let field = |(name, column): &(String, Column)| {
            let builder = match column {
                Column::Text(_) => Type::primitive_type_builder(name, Physical::BYTE_ARRAY)
                    .with_logical_type(Some(LogicalType::String))
                    .with_repetition(Repetition::REQUIRED),
                Column::Number(_) => {
                    Type::primitive_type_builder(name, Physical::DOUBLE).with_repetition(Repetition::OPTIONAL)
                }
            };
            builder.build().map(Arc::new)
        };
        self.columns.iter().map(field).collect()
    }
}

/// Whether cells are numbers: each that is not empty, and none is a name like 007.
pub fn are_numbers<'a>(cells: impl Iterator<Item = &'a str>) -> bool {
    let is_name = |cell: &str| cell.starts_with('0') && cell[1..].starts_with(|c: char| c.is_ascii_digit());
    let mut filled = cells.map(str::trim).filter(|cell| !cell.is_empty()).peekable();
    filled.peek().is_some() && filled.all(|cell| !is_name(cell) && cell.parse::<f64>().is_ok())
}

/// Writes a table as CSV, block after block of its rows; all blocks have the same columns.
///
/// # Errors
/// When it cannot be written.
pub fn write_csv(blocks: impl Iterator<Item = Frame>, out: &mut (dyn Write + Send)) -> io::Result<()> {
    writeln!(out, "# {}", mark::words())?;
    let mut out = csv::Writer::from_writer(out);
    for (k, block) in blocks.enumerate() {
        if k == 0 {
            out.write_record(block.columns.iter().map(|(name, _)| name))?;
        }
        for row in 0..block.rows() {
            let cell = |column: &Column| match column {
                Column::Text(values) => values[row].clone(),
                Column::Number(values) => values[row].map(|v| v.to_string()).unwrap_or_default(),
            };
            out.write_record(block.columns.iter().map(|(_, column)| cell(column)))?;
        }
    }
    out.flush()
}

/// Writes a table as Parquet, a row group for each block: words as strings, numbers as doubles that may be missing.
///
/// # Errors
/// When it cannot be written.
pub fn write_parquet(blocks: impl Iterator<Item = Frame>, out: &mut (dyn Write + Send)) -> io::Result<()> {
    let write = || -> Result<(), ParquetError> {
        let mut blocks = blocks.peekable();
        let Some(first) = blocks.peek() else { return Ok(()) };
        let schema = Type::group_type_builder("table").with_fields(first.columns()?).build()?;
        let properties = Arc::new(WriterProperties::builder().set_created_by(mark::words()).build());
        let mut file = SerializedFileWriter::new(out, Arc::new(schema), properties)?;
        for block in blocks {
            let mut group = file.next_row_group()?;
            for (_, column) in &block.columns {
                let Some(mut writer) = group.next_column()? else { break };
                match column {
                    Column::Text(values) => {
                        let words: Vec<ByteArray> = values.iter().map(|v| v.as_str().into()).collect();
                        writer.typed::<ByteArrayType>().write_batch(&words, None, None)?;
                    }
                    Column::Number(values) => {
                        let there: Vec<f64> = values.iter().flatten().copied().collect();
                        let levels: Vec<i16> = values.iter().map(|v| i16::from(v.is_some())).collect();
                        writer.typed::<DoubleType>().write_batch(&there, Some(&levels), None)?;
                    }
                }
                writer.close()?;
            }
            group.close()?;
        }
        file.close().map(drop)
    };
    write().map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    /// In two blocks.
    fn frames() -> [Frame; 2] {
        let block = |specimen: &str, g: Option<f64>, rig: &str, day: &str| {
            let mut frame = Frame::default();
            frame.text("specimen", [specimen.to_owned()].into_iter());
            frame.number("G_1 [Pa]", [g].into_iter());
            frame.either("rig", [rig.to_owned()].into_iter(), true);
            frame.either("day", [day.to_owned()].into_iter(), false);
            frame
        };
        [block("001", Some(2822.5), "1", "Mon"), block("002, \"x\"", None, "2", "")]
    }

    #[test]
    fn numbers_and_names() {
        assert!(are_numbers(["1", "", " 2.5 ", "-1e3", "0", "0.5"].into_iter()));
        for cells in [["1", "two"], ["", ""], ["007", "8"], ["1", "1,5"]] {
            assert!(!are_numbers(cells.into_iter()), "{cells:?}");
        }
    }

    #[test]
    fn as_csv() {
        let mut bytes = Vec::new();
        write_csv(frames().into_iter(), &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let (mark, table) = text.split_once('\n').unwrap();
        assert_eq!(mark, format!("# {}", mark::words()));
        assert_eq!(table, "specimen,G_1 [Pa],rig,day\n001,2822.5,1,Mon\n\"002, \"\"x\"\"\",,2,\n");
        let mut again = Vec::new();
        write_csv([Frame::of_csv(table, Path::new("t.csv")).unwrap()].into_iter(), &mut again).unwrap();
        assert_eq!(again, text.as_bytes());
    }

    #[test]
    fn as_parquet() {
        let file = tempfile::NamedTempFile::new().unwrap();
        crate::output::write_file_in_parts(&file.path().with_extension("parquet"), |out| {
            write_parquet(frames().into_iter(), out)
        })
        .unwrap();
        let path = file.path().with_extension("parquet");
        assert!(mark::has_mark(&path).unwrap(), "it may be replaced by poropunch");
        let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
        let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(rows.len(), 2);
        assert_eq!(
            (rows[1].get_string(0).unwrap().as_str(), rows[0].get_double(1).unwrap()),
            ("002, \"x\"", 2822.5)
        );
        assert!(rows[1].get_double(1).is_err(), "what is missing is missing");
        assert_eq!((rows[1].get_double(2).unwrap(), rows[0].get_string(3).unwrap().as_str()), (2.0, "Mon"));
    }
}
