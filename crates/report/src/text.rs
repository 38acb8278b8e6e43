//! Untrusted text, such as names of candidates and mazes, and numbers as text.

use mmsim_maze::Escaped;
use unicode_truncate::UnicodeTruncateStr as _;
use unicode_width::UnicodeWidthStr as _;

/// Replaces characters that would control a terminal or that XML cannot represent.
pub(crate) fn clean(text: &str) -> String {
    Escaped(text).to_string().replace(['\u{fffe}', '\u{ffff}'], "\u{fffd}")
}

/// [Cleans](clean) a text and shortens it to at most `max` columns. A wide character, such as `決`,
/// occupies two columns.
pub(crate) fn shortened(text: &str, max: usize) -> String {
    let text = clean(text);
    if text.width() <= max { text } else { text.unicode_truncate(max - 1).0.to_owned() + "…" }
}

/// The format of the numbers of one measure: all have the same number of decimals, so that they can
/// be compared at a glance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NumberFormat {
    decimals: usize,
}

impl NumberFormat {
    /// Chooses the decimals such that a number of the size of `largest` has about four digits: one
    /// to four decimals.
    pub(crate) fn for_size(largest: f64) -> Self {
        let decimals = match largest.abs() {
            size if size >= 100.0 => 1,
            size if size >= 10.0 => 2,
            size if size >= 1.0 || size == 0.0 => 3,
            _ => 4,
        };
        Self { decimals }
    }

    /// Chooses no decimals if all numbers are integers. Otherwise, chooses the decimals by the largest
    /// number.
    pub(crate) fn for_values(numbers: impl IntoIterator<Item = f64>) -> Self {
        let (largest, are_integers) =
            numbers.into_iter().fold((0.0, true), |(largest, are_integers), number| {
                (number.abs().max(largest), are_integers && number.fract() == 0.0)
            });
        if are_integers { Self { decimals: 0 } } else { Self::for_size(largest) }
    }

    /// Formats a number, for example `12.4`.
    pub(crate) fn plain(self, number: f64) -> String {
        let text = format!("{number:.*}", self.decimals);
        // A number that is rounded to 0 has no sign.
        match text.strip_prefix('-') {
            Some(zero) if zero.chars().all(|c| matches!(c, '0' | '.')) => zero.into(),
            _ => text,
        }
    }

    /// Formats a difference with its sign, for example `+12.4`.
    pub(crate) fn signed(self, number: f64) -> String {
        let text = self.plain(number);
        let is_zero = text.chars().all(|c| matches!(c, '0' | '.'));
        if is_zero || text.starts_with('-') { text } else { format!("+{text}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_end_with_an_ellipsis() {
        assert_eq!(shortened("b\n\u{ffff}", 24), "b\\n\u{fffd}");
        assert_eq!(shortened("four", 4), "four");
        assert_eq!(shortened("fünfzehn", 4), "fün…");
        assert_eq!(shortened("全日本決勝", 10), "全日本決勝");
        assert_eq!(shortened("全日本決勝", 9), "全日本決…");
        assert_eq!(shortened("全日本決勝", 8), "全日本…", "half of a character does not fit");
        let (accents, family) = ("e\u{301}".repeat(4), "👩\u{200d}👩\u{200d}👧");
        assert_eq!(shortened(&accents, 4), accents);
        assert_eq!(shortened(&accents, 3), "e\u{301}e\u{301}…");
        assert_eq!(shortened(&format!("a{family}{family}"), 4), format!("a{family}…"));
    }

    #[test]
    fn numbers_have_about_four_digits() {
        let shown = [0.0, 0.123_456, 1.0, 12.345, 999.96, -123.456, 12_345.67]
            .map(|number| NumberFormat::for_size(number).plain(number));
        assert_eq!(shown, ["0.000", "0.1235", "1.000", "12.35", "1000.0", "-123.5", "12345.7"]);
    }

    #[test]
    fn integers_have_no_decimals() {
        let shown = |numbers: &[f64]| {
            let format = NumberFormat::for_values(numbers.iter().copied());
            numbers.iter().map(|&number| format.plain(number)).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(shown(&[7.0, -120.0]), "7 -120");
        assert_eq!(shown(&[7.0, 12.5]), "7.00 12.50");
        assert_eq!(shown(&[]), "");
    }

    #[test]
    fn only_numbers_other_than_zero_have_a_sign() {
        let format = NumberFormat::for_size(100.0);
        let shown = [0.0, -0.0, 0.04, -0.04, 0.06, -0.06].map(|number| format.signed(number));
        assert_eq!(shown, ["0.0", "0.0", "0.0", "0.0", "+0.1", "-0.1"]);
    }
}
