//! Numbers and texts as lines, and the labels in the cells.

use std::fmt::Write as _;

/// The distance from one character to the next, in units.
pub(crate) const ADVANCE: f64 = 5.0;

/// The stroke width of a character, in units.
pub(crate) const STROKE: f64 = 0.95;

/// The stroke width of a character of a text in a cell, in units. Texts are bolder than weights.
pub(crate) const TEXT_STROKE: f64 = 1.35;

/// The path of each character from the space to `~`, in the order of ASCII. A path starts at the
/// middle of the left edge of the character's box, and its first command moves to the beginning of
/// the first stroke. The box is [`ADVANCE`] units wide; capitals and digits are 6.8 units high.
#[rustfmt::skip]
pub(crate) const GLYPHS: [&str; 95] = [
    "",
    "m2.5-3.4v4.4m0 2v.2",
    "m1.7-3.4v1.8m1.6-1.8v1.8",
    "m2-2.8-.6 5.6m2.3-5.6-.6 5.6m-2.4-3.8h3.7m-3.8 2.1h3.7",
    "m4.1-2c-.4-.5-.9-.8-1.6-.8-.9 0-1.5.5-1.5 1.3 0 1.8 3.1 1.2 3.1 3 0 .9-.7 1.4-1.6 1.4-.7 0-1.3-.3-1.7-.9m1.7-6v8.1",
    "m4.2-3.4-3.4 6.8m.7-6.7c.6 0 .9.4.9 1.1s-.3 1.1-.9 1.1-.9-.4-.9-1.1 .3-1.1.9-1.1zm2 4.4c.6 0 .9.4.9 1.1s-.3 1.1-.9 1.1-.9-.4-.9-1.1 .3-1.1.9-1.1z",
    "m4.3 3.4-2.8-4.5c-.6-1.1-.2-2.3.8-2.3 .9 0 1.3.9.8 1.8-.5.8-2.3 1.6-2.3 3.3 0 1.1.7 1.7 1.6 1.7 1 0 1.7-1 1.8-2.5",
    "m2.5-3.4v1.8",
    "m3.3-4c-1.6 2.4-1.6 5.6 0 8",
    "m1.7-4c1.6 2.4 1.6 5.6 0 8",
    "m2.5-3v4m-1.7-3 3.4 2m0-2-3.4 2",
    "m2.5-2v4m-1.9-2h3.8",
    "m2.6 2.9-.7 1.8",
    "m1.1.1h2.8",
    "m2.5 3.1v.2",
    "m4.1-3.8-3.2 7.8",
    "m2.5-3.4c1.2 0 1.75 1.4 1.75 3.4s-.55 3.4-1.75 3.4-1.75-1.4-1.75-3.4.55-3.4 1.75-3.4z",
    "m1.15-2.2 1.75-1.2v6.8",
    "m.95-1.9c.15-.9.8-1.5 1.65-1.5.95 0 1.55.65 1.55 1.55 0 1.7-3.25 3.05-3.35 5.25h3.5",
    "m.9-2.75c.4-.4.9-.65 1.5-.65 1 0 1.6.65 1.6 1.55s-.65 1.5-1.7 1.5c1.2 0 1.95.7 1.95 1.8s-.8 1.95-1.95 1.95c-.65 0-1.2-.25-1.6-.7",
    "m3.3 3.4v-6.8l-2.65 4.7h3.75",
    "m4-3.4h-2.65l-.25 2.95c.4-.4.85-.55 1.35-.55 1.1 0 1.8.85 1.8 2.1s-.8 2.3-1.95 2.3c-.6 0-1.1-.2-1.5-.6",
    "m3.75-3.05c-.3-.25-.6-.35-1-.35-1.3 0-2 1.6-2 3.9 0 1.85.65 2.9 1.75 2.9 1.05 0 1.75-.85 1.75-2.1s-.65-2-1.65-2c-.95 0-1.7.65-1.85 1.7",
    "m.75-3.4h3.5c-1.2 1.9-1.95 4.1-2.05 6.8",
    "m2.5-3.4c.95 0 1.55.65 1.55 1.5s-.6 1.5-1.55 1.5-1.55-.65-1.55-1.5.6-1.5 1.55-1.5zm0 3c1.1 0 1.75.8 1.75 1.9s-.65 1.9-1.75 1.9-1.75-.8-1.75-1.9.65-1.9 1.75-1.9z",
    "m1.25 3.05c.3.25.6.35 1 .35 1.3 0 2-1.6 2-3.9 0-1.85-.65-2.9-1.75-2.9-1.05 0-1.75.85-1.75 2.1s.65 2 1.65 2c.95 0 1.7-.65 1.85-1.7",
    "m2.5-.7v.2m0 3.4v.2",
    "m2.6-.7v.2m0 3.4-.7 1.8",
    "m4-2.4-3 2.4 3 2.4",
    "m.8-1.1h3.4m-3.4 2.2h3.4",
    "m1-2.4 3 2.4-3 2.4",
    "m1-2.4c.2-.6.7-1 1.5-1 1 0 1.6.6 1.6 1.5 0 1.5-1.6 1.5-1.6 3.1m0 1.9v.2",
    "m3.5-.9v1.8c.1.9 1 .4 1-1.2 0-2-.7-3.1-2-3.1s-2 1.4-2 3.4 .7 3.4 2.2 3.4c.6 0 1-.1 1.4-.4m-.6-3c0-.9-.4-1.3-1-1.3s-1 .4-1 1.3 .4 1.3 1 1.3 1-.4 1-1.3",
    "m.7 3.4 1.8-6.8 1.8 6.8m-3-2.2h2.4",
    "m1-3.4v6.8h1.5c1.1 0 1.7-.7 1.7-1.8s-.6-1.8-1.7-1.8h-1.5m0-3.2h1.4c1 0 1.6.6 1.6 1.6s-.6 1.6-1.6 1.6",
    "m4.2-2.3c-.4-.7-.9-1.1-1.6-1.1-1.2 0-1.8 1.4-1.8 3.4s.6 3.4 1.8 3.4c.7 0 1.2-.4 1.6-1.1",
    "m1-3.4v6.8h1.1c1.4 0 2.1-1.3 2.1-3.4s-.7-3.4-2.1-3.4z",
    "m4-3.4h-3v6.8h3m-3-3.5h2.5",
    "m4-3.4h-3v6.8m0-3.5h2.5",
    "m4.1-2.4c-.4-.6-.9-1-1.5-1-1.2 0-1.8 1.4-1.8 3.4s.6 3.4 1.8 3.4c.9 0 1.5-.7 1.5-1.8v-1.3h-1.4",
    "m.9-3.4v6.8m3.2-6.8v6.8m-3.2-3.5h3.2",
    "m1.3-3.4h2.4m-1.2 0v6.8m-1.2 0h2.4",
    "m1.8-3.4h2v5.1c0 1.1-.6 1.7-1.5 1.7-.8 0-1.3-.4-1.5-1.2",
    "m1-3.4v6.8m3.1-6.8-3.1 4.1m1-1.3 2.2 4",
    "m1-3.4v6.8h3.1",
    "m.7 3.4v-6.8l1.8 4 1.8-4v6.8",
    "m.9 3.4v-6.8l3.2 6.8v-6.8",
    "m2.5-3.4c1.5 0 1.9.8 1.9 3.4s-.4 3.4-1.9 3.4-1.9-.8-1.9-3.4 .4-3.4 1.9-3.4z",
    "m1 3.4v-6.8h1.5c1.1 0 1.7.7 1.7 1.8s-.6 1.8-1.7 1.8h-1.5",
    "m2.5-3.4c1.5 0 1.9.8 1.9 3.4s-.4 3.4-1.9 3.4-1.9-.8-1.9-3.4 .4-3.4 1.9-3.4zm.4 5.2 1.6 2.3",
    "m1 3.4v-6.8h1.5c1.1 0 1.7.7 1.7 1.8s-.6 1.8-1.7 1.8h-1.5m1.6 0 1.6 3.2",
    "m4.1-2.4c-.4-.6-.9-1-1.6-1-1 0-1.6.6-1.6 1.5 0 2.2 3.3 1.4 3.3 3.6 0 1.1-.7 1.7-1.7 1.7-.8 0-1.4-.4-1.7-1.2",
    "m.6-3.4h3.8m-1.9 0v6.8",
    "m.9-3.4v4.8c0 1.3.6 2 1.6 2s1.6-.7 1.6-2v-4.8",
    "m.6-3.4 1.9 6.8 1.9-6.8",
    "m.4-3.4 1 6.8 1.1-4.6 1.1 4.6 1-6.8",
    "m.8-3.4 3.4 6.8m0-6.8-3.4 6.8",
    "m.7-3.4 1.8 3.6v3.2m1.8-6.8-1.8 3.6",
    "m.9-3.4h3.2l-3.2 6.8h3.2",
    "m3.5-3.9h-1.5v7.9h1.5",
    "m.9-3.8 3.2 7.8",
    "m1.5-3.9h1.5v7.9h-1.5",
    "m.9-.8 1.6-2.6 1.6 2.6",
    "m.5 4.3h4",
    "m1.8-3.6 1.1 1.3",
    "m1.1-.5c.2-.5.7-.8 1.4-.8 1 0 1.4.5 1.4 1.4v3.3m0-2.4h-1.5c-1 0-1.5.4-1.5 1.2s.5 1.3 1.3 1.3c1 0 1.7-.6 1.7-1.6",
    "m1-3.4v6.8m0-2.3c0-1.5.6-2.4 1.6-2.4s1.5.9 1.5 2.4-.5 2.4-1.5 2.4-1.6-.9-1.6-2.4",
    "m3.9-.4c-.2-.6-.7-.9-1.3-.9-1.1 0-1.7.9-1.7 2.4s.6 2.4 1.7 2.4c.6 0 1.1-.3 1.3-.9",
    "m4-3.4v6.8m0-2.3c0-1.5-.6-2.4-1.6-2.4s-1.5.9-1.5 2.4 .5 2.4 1.5 2.4 1.6-.9 1.6-2.4",
    "m.9 1h3.2c0-1.5-.6-2.3-1.6-2.3s-1.6.9-1.6 2.4 .6 2.4 1.7 2.4c.6 0 1.1-.3 1.3-.9",
    "m4-3.2c-.2-.1-.5-.2-.8-.2-.8 0-1.2.5-1.2 1.5v5.3m-1.2-4.5h2.9",
    "m4-1.2v5c0 1-.6 1.5-1.5 1.5-.6 0-1.1-.2-1.4-.6m2.9-3.7c0-1.4-.6-2.3-1.6-2.3s-1.5.9-1.5 2.3 .5 2.2 1.5 2.2 1.6-.8 1.6-2.2",
    "m1-3.4v6.8m0-2.8c.1-1.2.7-1.9 1.6-1.9 .9 0 1.4.6 1.4 1.8v2.9",
    "m1.4-1.2h1.1v4.6m-1.2 0h2.4m-1.3-6.7v.2",
    "m1.8-1.2h1.3v5.1c0 .9-.4 1.4-1.2 1.4-.4 0-.7-.1-.9-.2m2-8.4v.2",
    "m1.1-3.4v6.8m2.8-4.6-2.8 2.6m1-.9 2 2.9",
    "m1.4-3.4h1.1v6.8m-1.2 0h2.4",
    "m.6 3.4v-4.6m0 1.2c.2-.9.5-1.3 1-1.3 .6 0 .9.4.9 1.2v3.5m0-3.4c.2-.9.5-1.3 1-1.3 .6 0 .9.4.9 1.2v3.5",
    "m1 3.4v-4.6m0 1.8c.1-1.2.7-1.9 1.6-1.9 .9 0 1.4.6 1.4 1.8v2.9",
    "m2.5-1.3c1.1 0 1.6.9 1.6 2.4s-.5 2.4-1.6 2.4-1.6-.9-1.6-2.4 .5-2.4 1.6-2.4z",
    "m1-1.2v6.5m0-4.2c0-1.5.6-2.4 1.6-2.4s1.5.9 1.5 2.4-.5 2.4-1.5 2.4-1.6-.9-1.6-2.4",
    "m4-1.2v6.5m0-4.2c0-1.5-.6-2.4-1.6-2.4s-1.5.9-1.5 2.4 .5 2.4 1.5 2.4 1.6-.9 1.6-2.4",
    "m1.3 3.4v-4.6m0 2c.2-1.3.8-2.1 1.7-2.1 .3 0 .6.1.9.3",
    "m3.8-.6c-.2-.4-.7-.7-1.3-.7-.9 0-1.4.4-1.4 1.1 0 1.7 2.9.9 2.9 2.5 0 .8-.6 1.2-1.5 1.2-.8 0-1.3-.3-1.6-.9",
    "m2-2.8v5c0 .9.4 1.3 1.1 1.3 .3 0 .6-.1.8-.2m-3.1-4.5h2.9",
    "m1-1.2v2.9c0 1.2.5 1.8 1.4 1.8 .9 0 1.5-.7 1.6-1.9m0-2.8v4.6",
    "m.8-1.2 1.7 4.6 1.7-4.6",
    "m.5-1.2 .9 4.6 1.1-3.2 1.1 3.2 .9-4.6",
    "m.9-1.2 3.2 4.6m0-4.6-3.2 4.6",
    "m.8-1.2 1.7 4.6m1.7-4.6-1.7 4.6c-.4 1.3-.8 1.9-1.6 1.9",
    "m1-1.2h3l-3 4.6h3",
    "m3.6-3.9c-1 0-1.2.5-1.2 1.5v1.4c0 .7-.4 1-1.1 1 .7 0 1.1.3 1.1 1v1.5c0 1 .2 1.5 1.2 1.5",
    "m2.5-4v8.2",
    "m1.4-3.9c1 0 1.2.5 1.2 1.5v1.4c0 .7.4 1 1.1 1-.7 0-1.1.3-1.1 1v1.5c0 1-.2 1.5-1.2 1.5",
    "m.7.6c.5-1.3 1.3-1.2 1.8-.5s1.3.8 1.8-.5",
];

/// The path of a character that the font does not contain: a question mark in a box.
pub(crate) const MISSING: &str =
    "m.8-3.4h3.4v6.8h-3.4zm1 2.2c.2-.5.4-.6.7-.6 .5 0 .8.3.8.8 0 .7-.8.8-.8 1.6m0 1.3v.1";

/// Returns the SVG path of a number, centred on (0, 0). One unit of the path is 1/20 of a cell.
/// Draw the path with a stroke that has round caps and joins. Up to three digits fit between the
/// walls of a cell.
///
/// ```
/// assert_eq!(mmsim_drawing::digits(1), "M-2.5 0m1.15-2.2 1.75-1.2v6.8");
/// assert!(mmsim_drawing::digits(255).starts_with("M-7.5 0m"));
/// ```
pub fn digits(number: u16) -> String {
    line(&number.to_string(), 0.0)
}

/// Returns the SVG path of a line of text, centred on (0, `y`).
pub(crate) fn line(text: &str, y: f64) -> String {
    let count = text.chars().count();
    let mut path = String::new();
    for (index, letter) in text.chars().enumerate() {
        // Half an advance is a whole number of hundredths, so this is exact.
        #[expect(clippy::cast_precision_loss, reason = "at most ten characters")]
        let x = (index as f64 - count as f64 / 2.0) * ADVANCE;
        let _ = write!(path, "M{}{}", pair(x, y), glyph(letter));
    }
    path
}

fn glyph(letter: char) -> &'static str {
    let index = (letter as usize).checked_sub(' ' as usize);
    index.and_then(|index| GLYPHS.get(index)).copied().unwrap_or(MISSING)
}

/// Formats the coordinates of a point.
pub(crate) fn pair(x: f64, y: f64) -> String {
    format!("{} {}", decimals(x), decimals(y))
}

/// Formats a number with at most two decimals and no trailing zeros.
pub(crate) fn decimals(number: f64) -> String {
    let text = format!("{number:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// The weight that a client assigns to a cell without a path to the goal. A client also sends 255
/// for weights above 255, because a weight is sent as one byte.
pub(crate) const NO_PATH: u8 = u8::MAX;

/// The path of the sign ∞, centred on (0, 0).
pub(crate) const INFINITY: &str = "M0 0c1-1.5 1.8-2.1 2.8-2.1 1.1 0 2 .9 2 2.1s-.9 2.1-2 2.1c-1 0-1.8-.6-2.8-2.1s-1.8-2.1-2.8-2.1c-1.1 0-2 .9-2 2.1s.9 2.1 2 2.1c1 0 1.8-.6 2.8-2.1z";

/// The maximum number of characters in a line of text. A longer text is split into two lines, as in
/// mms.
pub(crate) const LINE_CHARS: usize = 5;

/// The number of characters that fit between the walls of a cell without scaling.
pub(crate) const FULL_CHARS: usize = 3;

/// The distance of each of two lines from the middle of the cell, in units.
pub(crate) const LINE_OFFSET: f64 = 5.5;

/// Returns the SVG path of a weight: its [`digits`], or the sign ∞ for 255.
///
/// ```
/// assert_eq!(mmsim_drawing::weight(254), mmsim_drawing::digits(254));
/// assert!(mmsim_drawing::weight(255).starts_with("M0 0c"));
/// ```
pub fn weight(weight: u8) -> String {
    Label::from_weight(weight).path()
}

/// The label in a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Label {
    Number(u16),
    /// The sign ∞.
    NoPath,
}

impl Label {
    pub(crate) fn from_weight(weight: u8) -> Self {
        if weight == NO_PATH { Self::NoPath } else { Self::Number(weight.into()) }
    }

    /// Returns the number on which the heat colour depends.
    pub(crate) const fn number(&self) -> Option<u16> {
        match self {
            Self::Number(number) => Some(*number),
            Self::NoPath => None,
        }
    }

    /// Returns the path of the label, centred on (0, 0).
    pub(crate) fn path(&self) -> String {
        match self {
            Self::Number(number) => digits(*number),
            Self::NoPath => INFINITY.into(),
        }
    }

    /// Returns the factor by which the path is scaled to fit into a cell.
    pub(crate) fn scale(&self) -> f64 {
        match self {
            Self::Number(number) => line_scale(number.to_string().len()),
            Self::NoPath => 1.0,
        }
    }
}

/// Returns the SVG path of a text of up to 10 characters and the factor by which the path is scaled
/// to fit into a cell. The path is centred on (0, 0). The scaled path is at most 15 units wide.
pub(crate) fn cell_text(text: &str) -> (String, f64) {
    let count = text.chars().count();
    let Some((end, _)) = text.char_indices().nth(LINE_CHARS) else {
        return (line(text, 0.0), line_scale(count));
    };
    let (first, second) = text.split_at(end);
    let path = line(first, -LINE_OFFSET) + &line(second, LINE_OFFSET);
    (path, line_scale(LINE_CHARS.max(count - LINE_CHARS)))
}

/// Returns the factor by which a line with this number of characters is scaled.
#[expect(clippy::cast_precision_loss, reason = "small numbers")]
fn line_scale(chars: usize) -> f64 {
    FULL_CHARS as f64 / chars.max(FULL_CHARS) as f64
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use resvg::usvg::{Options, Tree};

    use super::*;

    #[test]
    fn a_number_is_its_digits_side_by_side() {
        insta::assert_snapshot!(digits(107), @"M-7.5 0m1.15-2.2 1.75-1.2v6.8M-2.5 0m2.5-3.4c1.2 0 1.75 1.4 1.75 3.4s-.55 3.4-1.75 3.4-1.75-1.4-1.75-3.4.55-3.4 1.75-3.4zM2.5 0m.75-3.4h3.5c-1.2 1.9-1.95 4.1-2.05 6.8");
        assert_eq!(digits(10), format!("M-5 0{}M0 0{}", glyph('1'), glyph('0')));
        assert_eq!(digits(u16::MAX).matches('M').count(), 5);
    }

    #[test]
    fn each_character_has_its_own_glyph() {
        let glyphs: Vec<&str> = (' '..='~').map(glyph).collect();
        assert_eq!(glyphs, GLYPHS);
        let distinct: BTreeSet<&str> = glyphs.into_iter().chain([MISSING]).collect();
        assert_eq!(distinct.len(), 96);
        assert_eq!(glyph(' '), "");
        for missing in ['\n', '\u{7f}', 'é', '🐭'] {
            assert_eq!(glyph(missing), MISSING);
        }
    }

    #[test]
    fn characters_stay_in_their_boxes() {
        let visible = ('!'..='~').map(|letter| (letter, glyph(letter))).chain([('é', MISSING)]);
        for (letter, path) in visible {
            let drawing = format!(
                "<svg xmlns='http://www.w3.org/2000/svg' width='1' height='1'>\
                 <path d='M0 0{path}' fill='none' stroke='red' stroke-width='{STROKE}' \
                 stroke-linecap='round' stroke-linejoin='round'/></svg>"
            );
            let tree = Tree::from_str(&drawing, &Options::default()).unwrap();
            let area = tree.root().abs_stroke_bounding_box();
            assert!(area.left() >= -0.2 && area.right() <= 5.2, "{letter}: {area:?}");
            assert!(area.top() >= -4.6 && area.bottom() <= 5.9, "{letter}: {area:?}");
            assert!(area.width() > 0.9 && area.height() > 0.9, "{letter}: {area:?}");
        }
    }

    #[test]
    fn decimals_are_short() {
        let numbers = [0.0, -0.001, -2.5, 7.0, 1.0 / 3.0, 100.0].map(decimals);
        assert_eq!(numbers, ["0", "0", "-2.5", "7", "0.33", "100"]);
    }

    #[test]
    fn texts_fit_into_a_cell() {
        for (characters, expected) in
            [(0, 1.0), (1, 1.0), (3, 1.0), (4, 0.75), (5, 0.6), (6, 0.6), (10, 0.6)]
        {
            let (path, scale) = cell_text(&"8".repeat(characters));
            assert!((scale - expected).abs() < 1e-9, "{characters}");
            assert_eq!(path.matches('M').count(), characters);
            let lines = [" 0m", " -5.5m", " 5.5m"].map(|y| path.matches(y).count());
            let second = characters.saturating_sub(5);
            let expected = if second == 0 { [characters, 0, 0] } else { [0, 5, second] };
            assert_eq!(lines, expected, "{path}");
        }
    }

    #[test]
    fn characters_count_not_bytes() {
        assert_eq!(cell_text("äöüäöü").0, line("äöüäö", -5.5) + &line("ü", 5.5));
    }

    #[test]
    fn long_numbers_are_scaled() {
        for (number, expected) in [(0, 1.0), (999, 1.0), (1000, 0.75), (65535, 0.6)] {
            assert!((Label::Number(number).scale() - expected).abs() < 1e-9, "{number}");
        }
    }
}
