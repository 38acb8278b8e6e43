//! Text tables, and lines that fit the terminal.

use std::iter::repeat_n;
use std::mem;

use mmsim_maze::Escaped;
use unicode_width::UnicodeWidthStr as _;

use crate::terminal::columns;

/// The space between two columns.
const GAP: &str = "  ";

/// Formats rows as a table and escapes the text of the cells. The first column is left-aligned; all
/// other columns are right-aligned.
pub(crate) fn aligned(rows: &[Vec<String>]) -> String {
    format_rows(rows, 1)
}

/// Formats rows as a table of left-aligned columns. If it does not fit the terminal, each text in the
/// first column has a line of its own, above its rows.
pub(crate) fn titled(rows: &[Vec<String>]) -> String {
    titled_within(rows, columns())
}

fn titled_within(rows: &[Vec<String>], columns: usize) -> String {
    let table = format_rows(rows, usize::MAX);
    if widest(table.lines()) <= columns {
        return table;
    }
    let untitled = |row: &Vec<String>| {
        let rest = row.iter().skip(1).cloned();
        [String::new()].into_iter().chain(rest).collect()
    };
    let table = format_rows(&rows.iter().map(untitled).collect::<Vec<_>>(), usize::MAX);
    let (mut text, mut last) = (String::new(), None);
    for (row, line) in rows.iter().zip(table.lines()) {
        if let Some(title) = row.first().filter(|&title| Some(title) != last) {
            text.extend([Escaped(title).to_string(), "\n".into()]);
        }
        last = row.first();
        text += line;
        text.push('\n');
    }
    text
}

/// Like [`aligned`]. Columns that do not fit the terminal follow in further tables, each of which
/// repeats the first column.
pub(crate) fn stacked(rows: &[Vec<String>]) -> String {
    stacked_within(rows, columns())
}

fn stacked_within(rows: &[Vec<String>], columns: usize) -> String {
    let widths = widths(&escaped(rows));
    let (mut tables, mut table, mut used) = (Vec::new(), Vec::new(), 0);
    for (column, width) in widths.iter().enumerate().skip(1) {
        let width = GAP.len() + width;
        if !table.is_empty() && widths[0] + used + width > columns {
            tables.push(mem::take(&mut table));
            used = 0;
        }
        table.push(column);
        used += width;
    }
    tables.push(table);
    let format = |table: Vec<usize>| {
        let cells = |row: &Vec<String>| {
            let columns = [0].iter().chain(&table);
            columns.filter_map(|&column| row.get(column).cloned()).collect()
        };
        aligned(&rows.iter().map(cells).collect::<Vec<_>>())
    };
    tables.into_iter().map(format).collect::<Vec<_>>().join("\n")
}

/// Breaks a line after separators so that it fits the terminal. Indents the lines after the first.
pub(crate) fn wrapped(line: &str, separator: &str, indent: usize) -> String {
    wrapped_within(line, separator, indent, columns())
}

fn wrapped_within(line: &str, separator: &str, indent: usize, columns: usize) -> String {
    let mut lines = vec![String::new()];
    for part in line.split_inclusive(separator) {
        let last = lines.last_mut().map_or("", |line| &*line);
        if !last.trim().is_empty() && last.width() + part.trim_end().width() > columns {
            lines.push(" ".repeat(indent));
        }
        lines.last_mut().into_iter().for_each(|line| *line += part);
    }
    lines.iter().map(|line| line.trim_end()).collect::<Vec<_>>().join("\n")
}

fn escaped(rows: &[Vec<String>]) -> Vec<Vec<String>> {
    let escaped = |row: &Vec<String>| row.iter().map(|cell| Escaped(cell).to_string()).collect();
    rows.iter().map(escaped).collect()
}

/// Returns the width of each column.
fn widths(rows: &[Vec<String>]) -> Vec<usize> {
    let width = |column: usize| widest(rows.iter().filter_map(|row| row.get(column)));
    (0..rows.iter().map(Vec::len).max().unwrap_or(0)).map(width).collect()
}

/// Formats rows of which the first columns are left-aligned.
fn format_rows(rows: &[Vec<String>], left_columns: usize) -> String {
    let rows = escaped(rows);
    let widths = widths(&rows);
    let mut text = String::new();
    for row in &rows {
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            text += if column == 0 { "" } else { GAP };
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
        assert_eq!(titled_within(&rows, 10), "ä    1\nbcd  22  x\ne\n");
        assert_eq!(aligned(&[]), "");
        assert_eq!(aligned(&[vec!["a\nb".into(), "1".into()]]), "a\\nb  1\n");
    }

    #[test]
    fn wide_tables_are_stacked() {
        let rows = [["name", "1234", "56", "7"], ["b", "1", "2", "3"]];
        let rows = rows.map(|row| row.map(String::from).to_vec());
        assert_eq!(stacked_within(&rows, 80), aligned(&rows));
        assert_eq!(
            stacked_within(&rows, 14),
            "name  1234  56\nb        1   2\n\nname  7\nb     3\n"
        );
        assert_eq!(
            stacked_within(&rows, 5),
            "name  1234\nb        1\n\nname  56\nb      2\n\nname  7\nb     3\n"
        );
        assert_eq!(stacked_within(&[], 80), "");
    }

    #[test]
    fn titles_of_wide_tables_have_their_own_lines() {
        let rows = [&["maze", "mouse", "s"][..], &["a b", "x", "1"], &["a b", "y", "2"], &[]];
        let rows = rows.map(|row| row.iter().copied().map(String::from).collect());
        assert_eq!(titled_within(&rows, 14), "maze  mouse  s\na b   x      1\na b   y      2\n\n");
        assert_eq!(titled_within(&rows, 13), "maze\n  mouse  s\na b\n  x      1\n  y      2\n\n");
    }

    #[test]
    fn long_lines_are_broken_after_separators() {
        assert_eq!(wrapped_within("run  a bb ccc", " ", 5, 10), "run  a bb\n     ccc");
        assert_eq!(wrapped_within("a b, c, d", ", ", 2, 5), "a b,\n  c,\n  d");
        assert_eq!(wrapped_within("abcdefgh i", " ", 2, 4), "abcdefgh\n  i");
        assert_eq!(wrapped_within("", " ", 2, 4), "");
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
