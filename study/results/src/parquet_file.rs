//! Parquet files of tables, for pandas, polars, `DuckDB` and others: the numbers of the CSV file
//! with their types.
//!
//! A column of words is UTF-8, one of whole numbers `INT64`, any other `DOUBLE`; a cell that is
//! empty in CSV is null. Key-value metadata are `about`, the meaning of the table, and `columns`, a
//! list in JSON of the name, unit, meaning and role of each column. Pages are not compressed. The
//! same table is the same bytes.

use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::error::ResultsError;
use crate::table::{Table, TableCell};

/// Data type of a Parquet column: text, whole numbers or floating-point numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ColumnContent {
    Words,
    Counts,
    Numbers,
}

impl ColumnContent {
    /// Returns the Parquet data type of a column of a table.
    fn of(table: &Table, column: usize) -> Self {
        if table.columns[column].unit.is_empty() {
            return Self::Words;
        }
        let mut counts = 0;
        for row in &table.rows {
            match &row[column] {
                TableCell::Count(count) if i64::try_from(*count).is_ok() => counts += 1,
                TableCell::Empty => {}
                _ => return Self::Numbers,
            }
        }
        // A column without a number is one of numbers that are not known.
        if counts > 0 {
            Self::Counts
        } else {
            Self::Numbers
        }
    }

    fn field(self, name: &str) -> Result<Type, ParquetError> {
        let (kind, logical) = match self {
            Self::Words => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
            Self::Counts => (PhysicalType::INT64, None),
            Self::Numbers => (PhysicalType::DOUBLE, None),
        };
        Type::primitive_type_builder(name, kind)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical)
            .build()
    }
}

impl Table {
    /// Returns the name of the table's Parquet file.
    pub fn parquet_file(&self) -> String {
        format!("{}.parquet", self.name)
    }

    /// Formats the table as a Parquet file.
    ///
    /// # Errors
    /// As [`Table::to_csv`], and [`ResultsError::Parquet`].
    pub fn to_parquet(&self) -> Result<Vec<u8>, ResultsError> {
        self.check()?;
        self.parquet().map_err(|error| ResultsError::Parquet {
            table: self.name.to_string(),
            message: error.to_string(),
        })
    }

    fn parquet(&self) -> Result<Vec<u8>, ParquetError> {
        let kinds: Vec<ColumnContent> = (0..self.columns.len())
            .map(|column| ColumnContent::of(self, column))
            .collect();
        let fields = kinds.iter().zip(&self.columns);
        let fields = fields.map(|(kind, column)| kind.field(&column.name).map(Arc::new));
        let schema = Type::group_type_builder("table")
            .with_fields(fields.collect::<Result<_, _>>()?)
            .build()?;
        let columns = serde_json::to_string(&self.columns)
            .map_err(|error| ParquetError::General(error.to_string()))?;
        let told = [("about", self.about.to_string()), ("columns", columns)];
        let told = told
            .map(|(key, text)| KeyValue::new(key.to_owned(), text))
            .to_vec();
        let properties = WriterProperties::builder()
            .set_key_value_metadata(Some(told))
            .build();
        let mut bytes = Vec::new();
        let mut file =
            SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
        let mut group = file.next_row_group()?;
        for (index, kind) in kinds.into_iter().enumerate() {
            let cells = self.rows.iter().map(|row| &row[index]);
            let Some(mut column) = group.next_column()? else {
                break;
            };
            match kind {
                ColumnContent::Words => {
                    let words = cells.map(|cell| match cell {
                        TableCell::Text(text) if !text.is_empty() => {
                            Some(ByteArray::from(text.as_str()))
                        }
                        _ => None,
                    });
                    let (words, known) = split(words);
                    (column.typed::<ByteArrayType>()).write_batch(&words, Some(&known), None)?;
                }
                ColumnContent::Counts => {
                    let counts = cells.map(|cell| match cell {
                        TableCell::Count(count) => i64::try_from(*count).ok(),
                        _ => None,
                    });
                    let (counts, known) = split(counts);
                    (column.typed::<Int64Type>()).write_batch(&counts, Some(&known), None)?;
                }
                ColumnContent::Numbers => {
                    let (numbers, known) = split(cells.map(TableCell::number));
                    (column.typed::<DoubleType>()).write_batch(&numbers, Some(&known), None)?;
                }
            }
            column.close()?;
        }
        group.close()?;
        file.close()?;
        Ok(bytes)
    }
}

/// Splits cells into the known values, and the Parquet definition level of each cell: 0 for null.
fn split<T>(cells: impl Iterator<Item = Option<T>>) -> (Vec<T>, Vec<i16>) {
    let (mut values, mut known) = (Vec::new(), Vec::new());
    for cell in cells {
        known.push(i16::from(cell.is_some()));
        values.extend(cell);
    }
    (values, known)
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use parquet::file::reader::{FileReader as _, SerializedFileReader};
    use parquet::record::RowAccessor as _;

    use super::*;
    use crate::table::{Role, TableColumn};

    #[test]
    fn a_table_reads_back() {
        let column = |name: &'static str, unit: &'static str| TableColumn {
            name: name.into(),
            unit: unit.into(),
            meaning: format!("meaning of {name}").into(),
            role: Role::Value,
        };
        let text = |text: &str| TableCell::Text(text.to_owned());
        let table = Table {
            name: "energy".into(),
            about: "An energy.".into(),
            columns: vec![
                column("engine", ""),
                column("energy", "energy"),
                column("pairs", "1"),
                column("no", "1"),
            ],
            rows: vec![
                vec![
                    text("ed"),
                    TableCell::Number(0.1),
                    TableCell::Count(7),
                    TableCell::Empty,
                ],
                vec![
                    text("=x"),
                    TableCell::Count(2),
                    TableCell::Empty,
                    TableCell::Empty,
                ],
                vec![
                    TableCell::Empty,
                    TableCell::Number(f64::NAN),
                    TableCell::Count(u64::MAX >> 1),
                    TableCell::Empty,
                ],
            ],
            figures: Vec::new(),
        };
        let bytes = table.to_parquet().expect("a file");
        assert_eq!(bytes, table.to_parquet().expect("a file"));
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(&bytes).expect("written");
        let reader = SerializedFileReader::new(file).expect("a file");
        let told = reader
            .metadata()
            .file_metadata()
            .key_value_metadata()
            .expect("metadata")
            .clone();
        let told: Vec<_> = told
            .into_iter()
            .map(|one| (one.key, one.value.expect("a text")))
            .collect();
        let columns = serde_json::to_string(&table.columns).expect("text");
        let wanted = [
            ("about".to_owned(), "An energy.".to_owned()),
            ("columns".to_owned(), columns),
        ];
        assert_eq!(told, wanted);
        let rows: Vec<_> = reader
            .get_row_iter(None)
            .expect("rows")
            .map(|row| row.expect("a row"))
            .collect();
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[0].get_string(0).expect("words"), "ed");
        // As it is, without the apostrophe against spreadsheets.
        assert_eq!(rows[1].get_string(0).expect("words"), "=x");
        assert_eq!(
            (
                rows[0].get_double(1).expect("a number"),
                rows[1].get_double(1).expect("a number")
            ),
            (0.1, 2.0)
        );
        assert_eq!(
            (
                rows[0].get_long(2).expect("a count"),
                rows[2].get_long(2).expect("a count")
            ),
            (7, i64::MAX)
        );
        for (row, column) in [(2, 0), (2, 1), (1, 2), (0, 3)] {
            assert!(rows[row].get_string(column).is_err() && rows[row].get_double(column).is_err());
        }
    }
}
