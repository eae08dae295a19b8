//! Numbers and tables as text.

/// A number in the fewest digits that keep 15 significant ones, so that 0.8 m reads 800 and not
/// 800.0000000000001 when it is written in mm.
pub fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.14e}").parse().unwrap_or(value);
    format!("{:?}", if rounded == 0.0 { 0.0 } else { rounded })
}

/// A table to be written as CSV.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CsvTable {
    /// Comment lines, without `#`. They stand below the rows: readers of other programs take the first line for the names.
    pub comments: Vec<String>,
    /// Column names with units.
    pub header: Vec<String>,
    /// Cells.
    pub rows: Vec<Vec<String>>,
}

impl CsvTable {
    /// Puts the columns of another table with as many rows to the right of its own.
    pub fn append(&mut self, other: &Self) {
        self.header.extend_from_slice(&other.header);
        for (row, more) in self.rows.iter_mut().zip(&other.rows) {
            row.extend_from_slice(more);
        }
    }

    /// The file's text.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for row in std::iter::once(&self.header).chain(&self.rows) {
            let cells: Vec<String> = row.iter().map(|c| quoted(c)).collect();
            text += &cells.join(",");
            text.push('\n');
        }
        // A name of several lines must not become a row.
        let line = |comment: &String| format!("# {}\n", comment.replace(|c: char| c.is_control(), " "));
        text.extend(self.comments.iter().map(line));
        text
    }
}

fn quoted(cell: &str) -> String {
    if cell.contains(['"', ',', '\n', '\r']) || cell.starts_with('#') {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.into()
    }
}
