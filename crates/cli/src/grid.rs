//! Text tables.

use std::iter::repeat_n;

use mmsim_maze::Escaped;
use unicode_width::UnicodeWidthStr as _;

/// The width that tables should not exceed, in columns of a terminal.
const WIDTH: usize = 80;

/// Formats rows as a table and escapes the text of the cells. The first column is left-aligned; all
/// other columns are right-aligned.
pub(crate) fn aligned(rows: &[Vec<String>]) -> String {
    format_rows(rows, 1)
}

/// Like [`aligned`], but with one table below the other if one would be wider than [`WIDTH`]. Each
/// table repeats the first column.
pub(crate) fn wrapped(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        widest(rows.iter().filter_map(|row| row.get(column)).map(|cell| Escaped(cell).to_string()))
    };
    let mut tables: Vec<(usize, Vec<usize>)> = Vec::new();
    for column in 1..columns.max(2) {
        let added = 2 + width(column);
        match tables.last_mut() {
            Some((total, list)) if *total + added <= WIDTH => {
                *total += added;
                list.push(column);
            }
            _ => tables.push((width(0) + added, vec![0, column])),
        }
    }
    let table = |(_, columns): &(usize, Vec<usize>)| {
        let cells = |row: &Vec<String>| {
            columns.iter().filter_map(|&column| row.get(column).cloned()).collect()
        };
        aligned(&rows.iter().map(cells).collect::<Vec<_>>())
    };
    tables.iter().map(table).collect::<Vec<_>>().join("\n")
}

/// Like [`aligned`], but with all columns left-aligned.
pub(crate) fn left_aligned(rows: &[Vec<String>]) -> String {
    format_rows(rows, usize::MAX)
}

/// Formats rows of which the first columns are left-aligned.
fn format_rows(rows: &[Vec<String>], left_columns: usize) -> String {
    let escaped = |row: &Vec<String>| row.iter().map(|cell| Escaped(cell).to_string()).collect();
    let rows: Vec<Vec<String>> = rows.iter().map(escaped).collect();
    let width = |column: usize| widest(rows.iter().filter_map(|row| row.get(column)));
    let widths: Vec<usize> = (0..rows.iter().map(Vec::len).max().unwrap_or(0)).map(width).collect();
    let mut text = String::new();
    for row in &rows {
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            text += if column == 0 { "" } else { "  " };
            let padding = repeat_n(' ', width - cell.width());
            if column < left_columns {
                text += cell;
                text.extend(padding);
            } else {
                text.extend(padding);
                text += cell;
            }
        }
        text.truncate(text.trim_end_matches(' ').len());
        text.push('\n');
    }
    text
}

/// Returns the largest number of columns that one of the texts occupies on a terminal. Wide
/// characters occupy two columns, and combining characters none.
pub(crate) fn widest<T: AsRef<str>>(texts: impl IntoIterator<Item = T>) -> usize {
    texts.into_iter().map(|text| text.as_ref().width()).max().unwrap_or(0)
}

/// Appends spaces to a text until it occupies this many columns on a terminal.
pub(crate) fn padded(text: &str, columns: usize) -> String {
    format!("{text}{:1$}", "", columns.saturating_sub(text.width()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_fit_their_widest_cell() {
        let rows = [vec!["ä", "1", ""], vec!["bcd", "22", "x"], vec!["e"]];
        let rows = rows.map(|row| row.into_iter().map(String::from).collect());
        assert_eq!(aligned(&rows), "ä     1\nbcd  22  x\ne\n");
        assert_eq!(left_aligned(&rows), "ä    1\nbcd  22  x\ne\n");
        assert_eq!(aligned(&[]), "");
        assert_eq!(aligned(&[vec!["a\nb".into(), "1".into()]]), "a\\nb  1\n");
    }

    #[test]
    fn wide_tables_are_wrapped() {
        let row = |cells: [&str; 4]| cells.map(String::from).to_vec();
        // With the first column and the gaps, these two are 80 columns wide.
        let (wide, most) = ("x".repeat(37), "y".repeat(37));
        let rows = [row(["a", &wide, &most, "z"]), row(["bc", "1", "2", "3"])];
        let pad = " ".repeat(36);
        let expected = format!("a   {wide}  {most}\nbc  {pad}1  {pad}2\n\na   z\nbc  3\n");
        assert_eq!(wrapped(&rows), expected);
        assert_eq!(wrapped(&[vec!["a".into()]]), "a\n");
    }

    #[test]
    fn wide_characters_fill_two_columns_and_combining_ones_none() {
        let rows = [["全日本2017決勝", "1"], ["e\u{301}か\u{3099}", "決勝"], ["a", "22"]];
        let rows = rows.map(|row| row.map(String::from).to_vec());
        let expected = "\
            全日本2017決勝     1\n\
            e\u{301}か\u{3099}             決勝\n\
            a                 22\n";
        assert_eq!(aligned(&rows), expected);
    }
}
