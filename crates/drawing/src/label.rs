//! The labels in the cells.

use crate::font::{digits, line};

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
            Self::Number(number) => {
                scale(number.checked_ilog10().map_or(1, |log| log as usize + 1))
            }
            Self::NoPath => 1.0,
        }
    }
}

/// Returns the SVG path of a text of up to 10 characters and the factor by which the path is scaled
/// to fit into a cell. The path is centred on (0, 0). The scaled path is at most 15 units wide.
pub(crate) fn text(text: &str) -> (String, f64) {
    let count = text.chars().count();
    let Some((end, _)) = text.char_indices().nth(LINE_CHARS) else {
        return (line(text, 0.0), scale(count));
    };
    let (first, second) = text.split_at(end);
    let path = line(first, -LINE_OFFSET) + &line(second, LINE_OFFSET);
    (path, scale(LINE_CHARS.max(count - LINE_CHARS)))
}

/// Returns the factor by which a line with this number of characters is scaled.
#[expect(clippy::cast_precision_loss, reason = "small numbers")]
fn scale(chars: usize) -> f64 {
    FULL_CHARS as f64 / chars.max(FULL_CHARS) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_fit_into_a_cell() {
        for (characters, expected) in
            [(0, 1.0), (1, 1.0), (3, 1.0), (4, 0.75), (5, 0.6), (6, 0.6), (10, 0.6)]
        {
            let (path, scale) = text(&"8".repeat(characters));
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
        assert_eq!(text("äöüäöü").0, line("äöüäö", -5.5) + &line("ü", 5.5));
    }

    #[test]
    fn long_numbers_are_scaled() {
        for (number, expected) in [(0, 1.0), (999, 1.0), (1000, 0.75), (65535, 0.6)] {
            assert!((Label::Number(number).scale() - expected).abs() < 1e-9, "{number}");
        }
    }
}
