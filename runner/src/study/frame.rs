//! A table of named columns, written as CSV and as Parquet.

use super::StudyError;
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
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

    /// Adds a column of somebody else's table: numbers where every cell that is not empty is one, and none is a name like 007.
    pub fn either(&mut self, name: impl Into<String>, values: Vec<String>) {
        let is_name =
            |cell: &str| cell.starts_with('0') && cell[1..].starts_with(|c: char| c.is_ascii_digit());
        let number = |cell: &String| match cell.trim() {
            "" => Some(None),
            cell if is_name(cell) => None,
            cell => cell.parse::<f64>().ok().map(Some),
        };
        match values.iter().map(number).collect::<Option<Vec<_>>>() {
            Some(numbers) if numbers.iter().any(Option::is_some) => self.number(name, numbers.into_iter()),
            _ => self.text(name, values.into_iter()),
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
        names.into_iter().zip(cells).for_each(|(name, cells)| frame.either(name, cells));
        Ok(frame)
    }

    fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| match column {
            Column::Text(values) => values.len(),
            Column::Number(values) => values.len(),
        })
    }

    /// As CSV; `file` is named in an error.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn csv(&self, file: &Path) -> Result<Vec<u8>, StudyError> {
        let failed = |problem: String| StudyError::File { file: file.to_owned(), problem };
        let mut out = csv::Writer::from_writer(Vec::new());
        out.write_record(self.columns.iter().map(|(name, _)| name)).map_err(|e| failed(e.to_string()))?;
        for row in 0..self.rows() {
            let cell = |column: &Column| match column {
                Column::Text(values) => values[row].clone(),
                Column::Number(values) => values[row].map(|v| v.to_string()).unwrap_or_default(),
            };
            let cells = self.columns.iter().map(|(_, column)| cell(column));
            out.write_record(cells).map_err(|e| failed(e.to_string()))?;
        }
        out.into_inner().map_err(|e| failed(e.to_string()))
    }

    /// As Parquet: words as strings, numbers as doubles that may be missing; `file` is named in an error.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn parquet(&self, file: &Path) -> Result<Vec<u8>, StudyError> {
        let write = || -> Result<Vec<u8>, ParquetError> {
            let field = |(name, column): &(String, Column)| {
                let builder = match column {
                    Column::Text(_) => Type::primitive_type_builder(name, Physical::BYTE_ARRAY)
                        .with_logical_type(Some(LogicalType::String))
                        .with_repetition(Repetition::REQUIRED),
                    Column::Number(_) => Type::primitive_type_builder(name, Physical::DOUBLE)
                        .with_repetition(Repetition::OPTIONAL),
                };
                builder.build().map(Arc::new)
            };
            let fields = self.columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
            let schema = Type::group_type_builder("table").with_fields(fields).build()?;
            let properties = Arc::new(WriterProperties::builder().build());
            let mut out = SerializedFileWriter::new(Vec::new(), Arc::new(schema), properties)?;
            let mut group = out.next_row_group()?;
            for (_, column) in &self.columns {
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
            out.into_inner()
        };
        write().map_err(|e| StudyError::File { file: file.to_owned(), problem: e.to_string() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    fn frame() -> Frame {
        let mut frame = Frame::default();
        frame.text("specimen", ["001", "002, \"x\""].map(str::to_owned).into_iter());
        frame.number("G_1 [Pa]", [Some(2822.5), None].into_iter());
        frame.either("rig", ["1", "2"].map(str::to_owned).to_vec());
        frame.either("day", ["Mon", ""].map(str::to_owned).to_vec());
        frame
    }

    #[test]
    fn as_csv() {
        let text = String::from_utf8(frame().csv(Path::new("t.csv")).unwrap()).unwrap();
        assert_eq!(text, "specimen,G_1 [Pa],rig,day\n001,2822.5,1,Mon\n\"002, \"\"x\"\"\",,2,\n");
        let again = Frame::of_csv(&text, Path::new("t.csv")).unwrap();
        assert_eq!(again, frame());
    }

    #[test]
    fn as_parquet() {
        let bytes = frame().parquet(Path::new("t.parquet")).unwrap();
        let mut file = tempfile::tempfile().unwrap();
        std::io::Write::write_all(&mut file, &bytes).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 2);
        assert_eq!(
            (rows[1].get_string(0).unwrap().as_str(), rows[0].get_double(1).unwrap()),
            ("002, \"x\"", 2822.5)
        );
        assert!(rows[1].get_double(1).is_err(), "what is missing is missing");
        assert_eq!((rows[1].get_double(2).unwrap(), rows[0].get_string(3).unwrap().as_str()), (2.0, "Mon"));
    }
}
