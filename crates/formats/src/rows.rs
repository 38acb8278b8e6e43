//! Functions that split text into lines, items and tables.

use mmsim_maze::MazeSize;

use crate::error::{Location, ParseError, quoted};

pub(crate) const MAX_SIDE: usize = MazeSize::MAX_SIDE as usize;

/// The maximum number of items that are read from a line. The value is [`MAX_SIDE`] plus one, so
/// that lines with too many items are detected.
pub(crate) const MAX_ITEMS: usize = MAX_SIDE + 1;

/// An item of a table and its location in the file.
#[derive(Clone, Copy)]
pub(crate) struct Item<'a> {
    pub(crate) text: &'a str,
    pub(crate) line: usize,
    pub(crate) column: usize,
}

impl Item<'_> {
    pub(crate) const fn location(&self) -> Location {
        Location::Text { line: self.line, column: self.column }
    }

    pub(crate) fn error(&self, expected: impl Into<String>) -> ParseError {
        ParseError::at(self.location(), expected, quoted(self.text))
    }
}

/// Decodes a file as text. Removes the byte order mark and replaces `\r\n` and `\r` with `\n`.
pub(crate) fn decode_text(content: &[u8]) -> String {
    let text = String::from_utf8_lossy(content);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    text.replace("\r\n", "\n").replace('\r', "\n")
}

/// Returns the lines that are not blank, with their line numbers.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    (1..).zip(text.lines()).filter(|(_, content)| !content.trim().is_empty())
}

/// Splits a line at its commas. A line without commas is split at its semicolons, and a line with
/// neither is split at its blanks. A comma or semicolon after the last item is ignored.
pub(crate) fn items(line: usize, content: &str) -> Vec<Item<'_>> {
    let separator = [',', ';'].into_iter().find(|&separator| content.contains(separator));
    let separates = |c: char| separator.map_or(c.is_whitespace(), |separator| c == separator);
    let (mut items, mut at) = (Vec::new(), 1);
    for slot in content.trim_end().split(separates) {
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
    // Remove the empty item after a trailing separator.
    items.pop_if(|last| last.text.is_empty());
    items
}

/// Returns the column after the last character of a line, ignoring trailing blanks.
pub(crate) fn end(content: &str) -> usize {
    content.trim_end().chars().count() + 1
}

/// Reads a table with rows of equal length. Returns the rows and the size of the table. `split`
/// splits a line into items, and `what` describes the items in error messages.
pub(crate) fn table<'a>(
    text: &'a str,
    what: &str,
    split: impl Fn(usize, &'a str) -> Vec<Item<'a>>,
) -> Result<(Vec<Vec<Item<'a>>>, MazeSize), ParseError> {
    let mut rows: Vec<Vec<Item>> = Vec::new();
    let mut first = 1;
    for (line, content) in lines(text) {
        if rows.len() == MAX_SIDE {
            return Err(ParseError::new(line, 1, "at most 32 rows of cells", "one more"));
        }
        let row = split(line, content);
        match (row.get(MAX_SIDE), rows.first().map(Vec::len)) {
            (Some(beyond), _) => {
                let expected = "at most 32 cells per row";
                return Err(ParseError::at(beyond.location(), expected, "more"));
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
