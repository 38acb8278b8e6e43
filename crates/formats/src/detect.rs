//! Format detection.
//!
//! A format is detected even if the file has errors, because the error messages depend on the
//! format. Usually, the first two lines of a file determine its format. The remaining lines are
//! examined only if the first two are ambiguous.

use mmsim_maze::MazeSize;

use crate::format::Format;
use crate::rows::{Item, decode_text, items, lines};
use crate::{csv, grid, hex, maz, num};

impl Format {
    /// Detects the format of a maze file, even if the file has errors.
    ///
    /// ```
    /// use mmsim_formats::Format;
    /// assert_eq!(Format::detect(b"o---o\n| S |\no---o\n"), Format::Text);
    /// assert_eq!(Format::detect(b"2\n1,3\n4,12\n"), Format::Trial);
    /// ```
    pub fn detect(content: &[u8]) -> Self {
        if maz::matches(content) {
            return Self::Maz;
        }
        let text = &decode_text(content);
        let mut first_lines = lines(text).map(|(_, content)| content.trim());
        let (first, second) = (first_lines.next().unwrap_or(""), first_lines.next().unwrap_or(""));
        if first.starts_with("OSHWDEM") {
            Self::Oshwdem
        } else if num::matches_line(first) || num::matches_line(second) {
            Self::Num
        } else if is_side(first) && (is_separated(second) || !is_hex(second)) {
            Self::Trial
        } else if is_separated(first) {
            detect_table(text, first)
        } else if is_hex(first) && !is_separated(second) && (is_hex(second) || !is_drawn(first)) {
            Self::Hex
        } else if grid::has_unknown(text) {
            Self::Maze
        } else {
            Self::Text
        }
    }
}

/// Detects the format of a file whose first line contains commas, semicolons or blanks.
fn detect_table(text: &str, first: &str) -> Format {
    let first_items = items(1, first);
    let is_number = |item: &Item| csv::number(item.text).is_some();
    let is_digit = |item: &Item| hex::are_digits(&[hex::digit(*item)]);
    if !is_hex(first) {
        let numbers = first_items.iter().filter(|&item| is_number(item)).count();
        let count = first_items.len();
        let required = if first.contains([',', ';']) { count.div_ceil(2) } else { count };
        return if numbers >= required { Format::Csv } else { Format::Text };
    }
    let rows = lines(text).take(usize::from(MazeSize::MAX_SIDE));
    let all: Vec<Item> = rows.flat_map(|(line, content)| items(line, content)).collect();
    if all.iter().any(|item| is_number(item) && !is_digit(item)) {
        return Format::Csv;
    }
    let is_only_hex = all.iter().any(|item| !is_number(item) || item.text.starts_with('0'));
    // The digits 1 to 9 are valid in both formats. The format is hex if only hex gives a maze.
    let makes_only_hex = || csv::parse(text).is_err() && hex::parse(text).is_ok();
    if is_only_hex || makes_only_hex() { Format::Hex } else { Format::Csv }
}

/// Returns true if a line is a number of one or two digits, like the side length in the first line
/// of a [`Format::Trial`] file.
fn is_side(line: &str) -> bool {
    (1..=2).contains(&line.len()) && line.bytes().all(|c| c.is_ascii_digit())
}

/// Returns true if a line has at least three characters and all of them are the same, as in a
/// drawing that uses one character for posts and walls.
fn is_drawn(line: &str) -> bool {
    line.len() >= 3 && line.chars().all(|c| line.starts_with(c))
}

fn is_hex(line: &str) -> bool {
    hex::are_digits(&hex::digits(1, line))
}

fn is_separated(line: &str) -> bool {
    line.contains([',', ';']) || items(1, line).len() > 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_detected() {
        let maz: String = "\u{e}\u{8}".to_string() + &"\0".repeat(254);
        for (what, content, expected) in [
            ("nothing", "", Format::Text),
            ("words", "hello\nworld\n", Format::Text),
            ("a drawing", "o---o\n| S |\no---o\n", Format::Text),
            ("a drawing with plus signs", "+-+\n|S|\n+-+\n", Format::Text),
            ("a gap in the first line", "o   o---o\n|   |   |\no---o---o\n", Format::Text),
            ("a drawing of digits", "11111\n1   1\n11111\n", Format::Text),
            ("a narrow drawing of digits", "111\n1S1\n111\n", Format::Text),
            ("a drawing of letters", "eeeeeee\ne  G Ge\ne eee e\n", Format::Text),
            ("unknown walls", "o---o---o\n| S .   |\no---o---o\n", Format::Maze),
            ("an OSHWDEM title", "\nOSHWDEM\n+---+\n", Format::Oshwdem),
            ("a trial", "2\n1,3\n4,12\n", Format::Trial),
            ("a trial with blanks", "\n 12 \n1, 7, 5", Format::Trial),
            ("a trial that is cut off", "12\n", Format::Trial),
            ("a trial with an odd line", "2\nx,3\n", Format::Trial),
            ("bytes", &maz, Format::Maz),
            ("bytes that are cut off", &maz[..200], Format::Maz),
            ("bytes and a line end", &(maz.clone() + "\n"), Format::Maz),
            ("bytes, one too high", &(maz[..255].to_string() + "o"), Format::Maz),
            ("blanks, as many as there are cells", &"\n".repeat(256), Format::Text),
            ("cells", "0 0 1 1 1 1\n", Format::Num),
            ("cells, the first wrong", "0 0 1 1 1\n0 1 1 1 1 1\n", Format::Num),
            ("codes", "8,2,7\n9,9,9\n11,5,6\n", Format::Csv),
            ("codes of one digit that make a maze", "8,7\n5,6\n", Format::Csv),
            ("codes, one wrong", "8,2,x\n9,9,9\n11,5,6\n", Format::Csv),
            ("codes, contradictory", "8,2,7\n9,15,9\n11,5,6\n", Format::Csv),
            ("codes with blanks", "8 2 7\n9 9 9\n11 5 6\n", Format::Csv),
            ("codes as floats", "8.0,7.0\n5.0,6.0\n", Format::Csv),
            ("codes in one row", "14,10,12\n", Format::Csv),
            ("codes in one column", "13,\n9,\n11,\n", Format::Csv),
            ("hex digits", "9553\na93a\naaaa\nec46\n", Format::Hex),
            ("16 of them", "9515555555555553\n8555555555555556\n", Format::Hex),
            ("two of them", "93\ne6\n", Format::Hex),
            ("two rows that could be numbers", "93\n76\n", Format::Hex),
            ("hex digits, one wrong", "9553\na93x\n", Format::Hex),
            ("hex digits with blanks", "9 5 5 3\na 9 3 a\n", Format::Hex),
            ("hex digits with signs", "0x9,0x5\n0xa,0xc\n", Format::Hex),
            ("hex digits that are no codes", "9,0\n1,2\n", Format::Hex),
            ("hex digits that are codes but make no maze as such", "4,4\n1,1\n", Format::Hex),
            ("six hex digits a row", "9 5 5 5 5 3\nc 5 5 5 5 6\n", Format::Hex),
        ] {
            assert_eq!(Format::detect(content.as_bytes()), expected, "{what}");
        }
    }
}
