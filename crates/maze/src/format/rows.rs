//! Rows of numbers in a text: what the formats that are tables have in common.

use super::{ParseError, Place, quoted};
use crate::MazeSize;

const MOST: usize = MazeSize::MAX_SIDE as usize;

/// The most items of a line that are looked at: one more than there may be.
pub(super) const MAX_ITEMS: usize = MOST + 1;

/// A number of a table as it is written, and where it stands.
#[derive(Clone, Copy)]
pub(super) struct Item<'a> {
    pub(super) text: &'a str,
    pub(super) line: usize,
    pub(super) column: usize,
}

impl Item<'_> {
    pub(super) const fn place(&self) -> Place {
        Place::Text { line: self.line, column: self.column }
    }

    pub(super) fn error(&self, expected: impl Into<String>) -> ParseError {
        ParseError::at(self.place(), expected, quoted(self.text))
    }
}

/// The lines that are not blank, each with its number.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    (1..).zip(text.lines()).filter(|(_, content)| !content.trim().is_empty())
}

/// What stands between the commas of a line; where there are none between its semicolons, or
/// else between its blanks. A comma or semicolon may follow after the last.
pub(super) fn items(line: usize, content: &str) -> Vec<Item<'_>> {
    let separator = [',', ';'].into_iter().find(|&separator| content.contains(separator));
    let parts = |c: char| separator.map_or(c.is_whitespace(), |separator| c == separator);
    let (mut items, mut at) = (Vec::new(), 1);
    for slot in content.trim_end().split(parts) {
        if items.len() == MAX_ITEMS {
            break;
        }
        let text = slot.trim();
        let blanks = slot.chars().count() - slot.trim_start().chars().count();
        if separator.is_some() || !text.is_empty() {
            items.push(Item { text, line, column: if text.is_empty() { at } else { at + blanks } });
        }
        at += slot.chars().count() + 1;
    }
    // What follows after the last separator.
    items.pop_if(|last| last.text.is_empty());
    items
}

/// The column just after the last character of a line.
pub(super) fn end(content: &str) -> usize {
    content.trim_end().chars().count() + 1
}

/// A table of rows alike in length, and its size. `split` gives the items of a line, and `what`
/// says what they are.
pub(super) fn table<'a>(
    text: &'a str,
    what: &str,
    split: impl Fn(usize, &'a str) -> Vec<Item<'a>>,
) -> Result<(Vec<Vec<Item<'a>>>, MazeSize), ParseError> {
    let mut rows: Vec<Vec<Item>> = Vec::new();
    let mut first = 1;
    for (line, content) in lines(text) {
        if rows.len() == MOST {
            return Err(ParseError::new(line, 1, "at most 32 rows of cells", "one more"));
        }
        let row = split(line, content);
        match (row.get(MOST), rows.first().map(Vec::len)) {
            (Some(beyond), _) => {
                return Err(ParseError::at(
                    beyond.place(),
                    "at most 32 cells side by side",
                    "more",
                ));
            }
            (None, Some(width)) if row.len() != width => {
                let expected = format!("{width} {what}, as on line {first}");
                return Err(ParseError::new(line, end(content), expected, row.len().to_string()));
            }
            (None, Some(_)) => {}
            (None, None) => first = line,
        }
        rows.push(row);
    }
    let width = rows.first().map_or(0, Vec::len);
    let size = MazeSize::new(width, rows.len())
        .map_err(|_| ParseError::new(first, 1, format!("rows of {what}"), "the end of the file"))?;
    Ok((rows, size))
}
