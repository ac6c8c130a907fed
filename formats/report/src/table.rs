//! A table of a study, for a CSV file and for a page.

use std::fmt::Write as _;
use std::path::Path;

use crate::html::escaped;
use dcb_formats::Error;
use dcb_formats::output::write_text;

/// Text with more bytes than this may be broken into lines on a page.
const LONG: usize = 32;

/// One column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name in files, for example `frequency_error_held`.
    pub name: String,
    /// Heading for people, for example `frequency error, held`.
    pub heading: String,
    /// Unit, `1` for none; empty for text and counts.
    pub unit: String,
}

impl Column {
    /// A column with its unit.
    pub fn new(name: &str, heading: &str, unit: &str) -> Self {
        Self {
            name: name.to_owned(),
            heading: heading.to_owned(),
            unit: unit.to_owned(),
        }
    }

    fn title_in_files(&self) -> String {
        match self.unit.as_str() {
            "" => self.name.clone(),
            unit => format!("{} [{unit}]", self.name),
        }
    }

    fn title_on_pages(&self) -> String {
        match self.unit.as_str() {
            "" | "1" => self.heading.clone(),
            unit => format!("{} [{unit}]", self.heading),
        }
    }
}

/// One entry.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A name.
    Text(String),
    /// A number of things.
    Count(u64),
    /// A quantity.
    Number(f64),
    /// Not applicable.
    Empty,
}

impl Cell {
    /// A quantity, or nothing.
    pub fn maybe(value: Option<f64>) -> Self {
        value.map_or(Self::Empty, Self::Number)
    }

    /// With every digit.
    fn exact(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Count(count) => count.to_string(),
            Self::Number(value) => format!("{value:?}"),
            Self::Empty => String::new(),
        }
    }

    /// For people: three digits.
    fn short(&self) -> String {
        match self {
            Self::Number(value) if *value == 0.0 => "0".to_owned(),
            Self::Number(value) if (0.01..1e4).contains(&value.abs()) => {
                let decimals = (2 - value.abs().log10().floor() as i32).max(0) as usize;
                format!("{value:.decimals$}")
            }
            Self::Number(value) => format!("{value:.2e}"),
            other => other.exact(),
        }
    }
}

/// Rows under columns.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Table {
    /// Columns.
    pub columns: Vec<Column>,
    /// Rows, a cell for each column.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// As comma-separated values, titled `name [unit]`, with as few digits as give the same numbers back.
    ///
    /// # Errors
    /// As [`write_text`].
    pub fn write_csv(&self, path: &Path) -> Result<(), Error> {
        let told = |source: std::io::Error| Error::io(path, "cannot write", source);
        let mut writer = csv::Writer::from_writer(Vec::new());
        let titles = self.columns.iter().map(Column::title_in_files);
        (writer.write_record(titles)).map_err(|error| told(error.into()))?;
        for row in &self.rows {
            (writer.write_record(row.iter().map(Cell::exact)))
                .map_err(|error| told(error.into()))?;
        }
        let bytes = (writer.into_inner()).map_err(|error| told(error.into_error()))?;
        write_text(path, &String::from_utf8_lossy(&bytes))
    }

    /// As HTML, without columns that have no entry; the rows at `marked` stand out.
    pub fn html(&self, marked: &[usize]) -> String {
        let mut html = String::from("<div class=\"wide\"><table>\n<tr>");
        let has_entries = |index: usize| self.rows.iter().any(|row| row[index] != Cell::Empty);
        let shown: Vec<usize> = (0..self.columns.len())
            .filter(|index| has_entries(*index))
            .collect();
        for index in &shown {
            let title = self.columns[*index].title_on_pages();
            let _ = write!(html, "<th>{}</th>", escaped(&title));
        }
        html += "</tr>\n";
        for (index, row) in self.rows.iter().enumerate() {
            html += match marked.contains(&index) {
                true => "<tr class=\"marked\">",
                false => "<tr>",
            };
            for cell in shown.iter().map(|index| &row[*index]) {
                let class = match cell {
                    Cell::Text(text) if text.len() > LONG => "",
                    Cell::Text(_) => " class=\"word\"",
                    _ => " class=\"number\"",
                };
                let _ = write!(html, "<td{class}>{}</td>", escaped(&cell.short()));
            }
            html += "</tr>\n";
        }
        html + "</table></div>\n"
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_table_keeps_every_digit_in_files_and_three_on_pages() {
        let table = Table {
            columns: vec![
                Column::new("name", "name", ""),
                Column::new("error", "its error", "1"),
            ],
            rows: vec![
                vec![Cell::Text("a, \"b\" <c>".into()), Cell::Number(1.0 / 3.0)],
                vec![Cell::Empty, Cell::Number(1.0 / 3.0 * 1e-9)],
            ],
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        table.write_csv(&path).unwrap();
        let mut reader = csv::Reader::from_path(&path).unwrap();
        assert_eq!(reader.headers().unwrap(), vec!["name", "error [1]"]);
        let rows: Vec<_> = reader.records().map(|row| row.unwrap()).collect();
        assert_eq!(&rows[0][0], "a, \"b\" <c>");
        assert_eq!(rows[0][1].parse::<f64>().unwrap(), 1.0 / 3.0);
        let html = table.html(&[1]);
        assert!(
            html.contains("&lt;c&gt;") && html.contains(">0.333<") && html.contains(">3.33e-10<")
        );
        assert_eq!(html.matches("class=\"marked\"").count(), 1);
        assert!(html.contains("<th>its error</th>"), "{html}");
    }

    #[test]
    fn a_column_without_entries_is_in_files_alone() {
        let table = Table {
            columns: vec![Column::new("a", "a", ""), Column::new("b", "b", "")],
            rows: vec![vec![Cell::Empty, Cell::Count(3)]; 2],
        };
        let html = table.html(&[]);
        assert!(!html.contains("<th>a</th>") && html.contains("<th>b</th>"));
        assert_eq!(html.matches("<td").count(), 2);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        table.write_csv(&path).unwrap();
        assert!(std::fs::read_to_string(&path).unwrap().starts_with("a,b\n"));
    }
}
