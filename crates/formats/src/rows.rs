//! Splitting text into rows of items.

use std::mem;

use crate::error::{Location, Note, ParseError, quoted};

/// An item of a row and its column, counted from 1.
#[derive(Clone, Copy)]
pub(crate) struct Item<'a> {
    pub(crate) text: &'a str,
    pub(crate) line: usize,
    pub(crate) column: usize,
}

/// The items of a line of text, or of the inner brackets of an array. A row has at least one item.
#[derive(Default)]
pub(crate) struct Row<'a> {
    pub(crate) items: Vec<Item<'a>>,
    /// True if the row contains a comma or semicolon.
    pub(crate) is_separated: bool,
}

impl<'a> Row<'a> {
    pub(crate) fn texts(&self) -> Vec<&'a str> {
        self.items.iter().map(|item| item.text).collect()
    }

    /// Returns the items, or the digits of a single item.
    pub(crate) fn numbers(&self, are_digits: bool) -> Vec<Item<'a>> {
        match self.items[..] {
            [word] if are_digits => word.characters(),
            _ => self.items.clone(),
        }
    }
}

impl Item<'_> {
    pub(crate) const fn location(&self) -> Location {
        Location::Text { line: self.line, column: self.column }
    }

    /// Returns the location after the last character.
    pub(crate) fn end(&self) -> Location {
        Location::Text { line: self.line, column: self.column + self.text.chars().count() }
    }

    pub(crate) fn error(&self, expected: impl Into<String>) -> ParseError {
        ParseError::new(self.location(), expected, quoted(self.text))
    }

    pub(crate) fn ignored(&self) -> Note {
        Note::ignored(self.location(), self.text)
    }

    /// Returns the item without the prefix of hexadecimal numbers.
    fn without_prefix(self) -> Self {
        let digits = ["0x", "0X"].iter().find_map(|prefix| self.text.strip_prefix(prefix));
        let digits = digits.filter(|digits| !digits.is_empty());
        digits.map_or(self, |text| Self { text, column: self.column + 2, ..self })
    }

    /// Returns the characters of the item, without the prefix of hexadecimal numbers, as items.
    pub(crate) fn characters(self) -> Vec<Self> {
        let Self { text, column, .. } = self.without_prefix();
        let characters = text.char_indices().map(|(at, c)| &text[at..at + c.len_utf8()]);
        characters.zip(column..).map(|(text, column)| Self { text, column, ..self }).collect()
    }

    /// Returns the number from 0 to 255. A decimal number may have the form of a float.
    pub(crate) fn number(self, is_hex: bool) -> Option<u8> {
        let bare = self.without_prefix().text;
        if is_hex || bare.len() < self.text.len() {
            return u8::from_str_radix(bare, 16).ok().filter(|_| !bare.starts_with('+'));
        }
        let number: f64 = bare.parse().ok()?;
        let is_whole = number.fract() == 0.0 && (0.0..256.0).contains(&number);
        // The number is whole and small.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        is_whole.then_some(number as u8)
    }
}

/// Replaces the comments of programs by blanks. If the rest has brackets, returns only the first
/// array, after as many lines as in the text.
pub(crate) fn without_code(text: &str) -> String {
    const COMMENTS: [(&str, &str); 3] = [("//", "\n"), ("/*", "*/"), ("#", "\n")];
    // Without an array, a number sign is part of a drawing.
    let comments = &COMMENTS[..if text.contains(['{', '[']) { 3 } else { 2 }];
    let (mut end, mut begun) = ("", 0);
    let strip = |(at, c): (usize, char)| {
        let begins = |(start, _): &&(&str, &str)| end.is_empty() && text[at..].starts_with(start);
        if let Some(comment) = comments.iter().find(begins) {
            (end, begun) = (comment.1, at);
        } else if !end.is_empty() && text[begun + 1..at].ends_with(end) {
            end = "";
        }
        if end.is_empty() || c == '\n' { c } else { ' ' }
    };
    let code: String = text.char_indices().map(strip).collect();
    let from = code.find('=').filter(|&at| code[at..].contains(['{', '['])).unwrap_or(0);
    let Some(start) = code[from..].find(['{', '[']).map(|at| from + at) else { return code };
    let (mut depth, mut is_open) = (0, true);
    let array = code[start..].split_inclusive(['{', '[', '}', ']']).take_while(|part| {
        depth += if part.ends_with(['{', '[']) { 1 } else { -1 };
        mem::replace(&mut is_open, depth > 0)
    });
    let before = code[..start].chars().map(|c| if c == '\n' { c } else { ' ' });
    before.collect::<String>() + &array.collect::<String>()
}

/// Splits text into rows of items: the lines that are not blank, or the inner brackets of an array.
pub(crate) fn rows(text: &str) -> Vec<Row<'_>> {
    let is_nested = text.matches(['{', '[']).count() > 1;
    let (mut rows, mut row, mut start) = (Vec::new(), Row::default(), None);
    let (mut line, mut column) = (1, 1);
    for (at, c) in text.char_indices().chain([(text.len(), '\n')]) {
        let is_row_end = if is_nested { "{[]}".contains(c) } else { c == '\n' };
        if !c.is_whitespace() && !"{[]},;()\"'".contains(c) {
            start = start.or(Some((at, column)));
        } else if let Some((from, column)) = start.take() {
            row.items.push(Item { text: &text[from..at], line, column });
        }
        row.is_separated |= ",;".contains(c);
        if (is_row_end || at == text.len()) && !row.items.is_empty() {
            rows.push(mem::take(&mut row));
        }
        (line, column) = if c == '\n' { (line + 1, 1) } else { (line, column + 1) };
    }
    rows
}
