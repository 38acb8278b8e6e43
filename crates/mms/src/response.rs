//! Responses to commands.

use std::fmt;

use mmsim_maze::CellSet;

/// The response to a command. [`Display`](fmt::Display) formats the response as mms does, without a
/// newline.
#[derive(Clone, Debug, PartialEq)]
pub enum Response {
    /// The movement is complete.
    Ack,
    /// The movement was blocked, or its distance was not positive.
    Crash,
    /// True or false.
    Bool(bool),
    /// A whole number.
    Count(u64),
    /// A number that may have a fraction, written with [`GeneralFormat`].
    Number(f64),
    /// A statistic that has no value yet, written as -1.
    NoValue,
    /// Cells, written as their number and then x and y of each cell.
    Cells(Box<CellSet>),
}

impl fmt::Display for Response {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ack => f.write_str("ack"),
            Self::Crash => f.write_str("crash"),
            Self::Bool(value) => write!(f, "{value}"),
            Self::Count(count) => write!(f, "{count}"),
            Self::Number(number) => write!(f, "{}", GeneralFormat(*number)),
            Self::NoValue => f.write_str("-1"),
            Self::Cells(cells) => {
                write!(f, "{}", cells.len())?;
                cells.iter().try_for_each(|cell| write!(f, " {} {}", cell.x, cell.y))
            }
        }
    }
}

/// Formats a number with six significant digits, like `%g` in C and Qt.
///
/// ```
/// use mmsim_mms::GeneralFormat;
/// let numbers = [20., 3.5, 0.1 + 0.2, 1234567., 0.000_012_5];
/// let texts = numbers.map(|number| GeneralFormat(number).to_string());
/// assert_eq!(texts, ["20", "3.5", "0.3", "1.23457e+06", "1.25e-05"]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralFormat(pub f64);

impl fmt::Display for GeneralFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const DIGITS: i32 = 6;
        let rounded = format!("{:.5e}", self.0);
        let Some((mantissa, exponent)) = rounded.split_once('e') else {
            // NaN or infinity.
            return f.write_str(&rounded);
        };
        let exponent: i32 = exponent.parse().unwrap_or(0);
        let trim_zeros = |text: &str| {
            let is_whole = !text.contains('.');
            let end =
                if is_whole { text } else { text.trim_end_matches('0').trim_end_matches('.') };
            end.to_string()
        };
        if (-4..DIGITS).contains(&exponent) {
            let decimals = usize::try_from(DIGITS - 1 - exponent).unwrap_or(0);
            f.write_str(&trim_zeros(&format!("{:.decimals$}", self.0)))
        } else {
            write!(f, "{}e{exponent:+03}", trim_zeros(mantissa))
        }
    }
}

#[cfg(test)]
mod tests {
    use mmsim_maze::MazeSize;

    use super::*;

    #[test]
    fn responses_are_written_as_in_mms() {
        let responses = [
            Response::Ack,
            Response::Crash,
            Response::Bool(true),
            Response::Bool(false),
            Response::Count(16),
            Response::Number(2000.),
            Response::NoValue,
            Response::Cells(Box::new(MazeSize::CLASSIC.central_cells())),
            Response::Cells(Box::default()),
        ];
        let texts = ["ack", "crash", "true", "false", "16", "2000", "-1", "4 7 7 8 7 7 8 8 8", "0"];
        assert_eq!(responses.map(|response| response.to_string()), texts);
    }

    #[test]
    fn numbers_have_six_significant_digits() {
        for (number, text) in [
            (0., "0"),
            (0.5, "0.5"),
            (123.456_789, "123.457"),
            (999_999.4, "999999"),
            (999_999.6, "1e+06"),
            (100_000., "100000"),
            (1e100, "1e+100"),
            (0.000_1, "0.0001"),
            (-2.25, "-2.25"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(GeneralFormat(number).to_string(), text);
        }
    }
}
