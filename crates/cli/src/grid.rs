//! Text tables.

use std::fmt::Write as _;

use mmsim_maze::Escaped;

/// Formats rows as a table and escapes the text of the cells. The first column is left-aligned; all
/// other columns are right-aligned.
pub(crate) fn aligned(rows: &[Vec<String>]) -> String {
    let escaped = |row: &Vec<String>| row.iter().map(|cell| Escaped(cell).to_string()).collect();
    let rows: Vec<Vec<String>> = rows.iter().map(escaped).collect();
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..rows.iter().map(Vec::len).max().unwrap_or(0)).map(width).collect();
    let mut text = String::new();
    for row in &rows {
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            // Writing to a string cannot fail.
            let _ = match column {
                0 => write!(text, "{cell:<width$}"),
                _ => write!(text, "  {cell:>width$}"),
            };
        }
        text.truncate(text.trim_end_matches(' ').len());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_fit_their_widest_cell() {
        let rows = [vec!["ä", "1", ""], vec!["bcd", "22", "x"], vec!["e"]];
        let rows = rows.map(|row| row.into_iter().map(String::from).collect());
        assert_eq!(aligned(&rows), "ä     1\nbcd  22  x\ne\n");
        assert_eq!(aligned(&[]), "");
        assert_eq!(aligned(&[vec!["a\nb".into(), "1".into()]]), "a\\nb  1\n");
    }
}
