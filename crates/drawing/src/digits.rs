//! Numbers drawn as strokes.

use std::fmt::Write as _;

/// The distance from one digit to the next, in units.
pub(crate) const ADVANCE: f64 = 5.0;

/// The stroke width of a digit, in units.
pub(crate) const STROKE: f64 = 0.95;

/// The path of each digit. A path starts at the middle of the left edge of the digit's box, and its
/// first command moves to the beginning of the first stroke. The box is [`ADVANCE`] units wide; a
/// digit is 3.4 units wide (the 1 is narrower) and 6.8 units high.
pub(crate) const DIGITS: [&str; 10] = [
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
];

/// Returns the SVG path of a number, centred on (0, 0). One unit of the path is 1/20 of a cell.
/// Draw the path with a stroke that has round caps and joins. Up to three digits fit between the
/// walls of a cell.
///
/// ```
/// assert_eq!(mmsim_drawing::digits(1), "M-2.5 0m1.15-2.2 1.75-1.2v6.8");
/// assert!(mmsim_drawing::digits(255).starts_with("M-7.5 0m"));
/// ```
pub fn digits(number: u16) -> String {
    let text = number.to_string();
    let count = text.len();
    let mut path = String::new();
    for (index, digit) in text.bytes().map(|letter| usize::from(letter - b'0')).enumerate() {
        // Half an advance is a whole number of hundredths, so this is exact.
        #[expect(clippy::cast_precision_loss, reason = "at most five digits")]
        let x = (index as f64 - count as f64 / 2.0) * ADVANCE;
        let _ = write!(path, "M{} 0{}", decimals(x), DIGITS[digit]);
    }
    path
}

/// Formats a number with at most two decimals and no trailing zeros.
pub(crate) fn decimals(number: f64) -> String {
    let text = format!("{number:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_its_digits_side_by_side() {
        insta::assert_snapshot!(digits(107), @"M-7.5 0m1.15-2.2 1.75-1.2v6.8M-2.5 0m2.5-3.4c1.2 0 1.75 1.4 1.75 3.4s-.55 3.4-1.75 3.4-1.75-1.4-1.75-3.4.55-3.4 1.75-3.4zM2.5 0m.75-3.4h3.5c-1.2 1.9-1.95 4.1-2.05 6.8");
        assert_eq!(digits(10), format!("M-5 0{}M0 0{}", DIGITS[1], DIGITS[0]));
        assert_eq!(digits(u16::MAX).matches('M').count(), 5);
    }

    #[test]
    fn decimals_are_short() {
        let numbers = [0.0, -0.001, -2.5, 7.0, 1.0 / 3.0, 100.0].map(decimals);
        assert_eq!(numbers, ["0", "0", "-2.5", "7", "0.33", "100"]);
    }
}
